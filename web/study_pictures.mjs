// Takes pictures of a study's page (forced choice on a desktop, ratings on a phone in dark mode) and of a report.
// Usage: node web/study_pictures.mjs FOLDER CHOICE_STUDY RATING_STUDY REPORT_PAGE
import { join, resolve } from 'node:path';
import { pathToFileURL } from 'node:url';
import { openBrowser, startProgram, until } from './test/harness.mjs';

const HEADPHONE_STEPS = 6;
const [folder, choice, rating, report] = process.argv.slice(2);
const browser = await openBrowser();

/** Answers the headphone check and the practice as the page would, but without playing the sounds. */
async function passTheBeginning(page) {
  await page.evaluate(async (steps) => {
    const post = (path, body) => fetch(path, { method: 'POST', body: JSON.stringify(body) });
    const { participant } = await (await post('/api/participants', {})).json();
    localStorage.setItem('earpoint-study-participant', participant);
    const self = `/api/participants/${participant}`;
    for (let step = 0; step < steps; ++step) {
      // The quietest of three tones has the least energy; one of the others is out of phase between the ears.
      const bytes = await (await fetch(`${self}/steps/${step}/sounds/0`)).arrayBuffer();
      const sound = (await new OfflineAudioContext(2, 1, 48000).decodeAudioData(bytes)).getChannelData(0);
      const energies = [0, 0, 0];
      sound.forEach((x, i) => { energies[Math.floor((3 * i) / sound.length)] += x * x; });
      await post(`${self}/steps/${step}`, { choice: energies.indexOf(Math.min(...energies)), revision: 0 });
    }
    const state = await (await fetch(self)).json();
    for (let step = state.at; state.steps[step].kind === 'training'; ++step) {
      const sounds = state.steps[step].sounds;
      const given = state.steps[step].scale ? { ratings: Array(sounds).fill(50) } : { choice: 0 };
      await post(`${self}/steps/${step}`, { ...given, revision: 0 });
    }
  }, HEADPHONE_STEPS);
  await page.reload();
  await until(page, () => document.getElementById('progress-text').textContent.startsWith('Question 1'));
}

async function takeQuestion(study, name, options, answer) {
  const program = await startProgram('study', 'serve', study);
  try {
    const page = await browser.newPage(options);
    await page.goto(program.address);
    await passTheBeginning(page);
    await until(page, () => document.querySelector('.picture')?.naturalWidth > 0);
    for (const button of await page.locator('.play').all()) {
      await button.click();
      await until(page, () => !document.querySelector('.playing'));
    }
    await answer(page);
    await page.locator('.play').first().click();
    await page.screenshot({ path: join(folder, `${name}.jpg`), type: 'jpeg', quality: 85, fullPage: true });
    await page.close();
  } finally {
    await program.stop();
  }
}

try {
  await takeQuestion(choice, 'study-choice', { viewport: { width: 760, height: 860 } },
    (page) => page.locator('input[name=closest]').nth(1).check());
  await takeQuestion(rating, 'study-ratings', { viewport: { width: 390, height: 844 }, colorScheme: 'dark' },
    async (page) => {
      const sliders = await page.locator('input[type=range]').all();
      for (const [i, slider] of sliders.entries()) await slider.fill(String((37 * i + 20) % 100));
    });
  const page = await browser.newPage({ viewport: { width: 1100, height: 900 } });
  await page.goto(pathToFileURL(resolve(report)).href);
  await page.screenshot({ path: join(folder, 'study-report.jpg'), type: 'jpeg', quality: 85 });
} finally {
  await browser.close();
}
