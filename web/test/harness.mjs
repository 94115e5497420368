// Starts what a test of the pages needs: the program, a browser, and a level meter at the page's output.
import { spawn } from 'node:child_process';
import { existsSync } from 'node:fs';
import { dirname, join } from 'node:path';
import { fileURLToPath } from 'node:url';

export const SOURCE_DIR = join(dirname(fileURLToPath(import.meta.url)), '../..');
const SKIPPED = 77; // exit status that CTest takes for a skipped test
const START_MS = 60_000;

/** Ends the test as skipped, and says why. */
function skip(why) {
  console.log(`skipped: ${why}`);
  process.exit(SKIPPED);
}

async function findChromium() {
  const playwright = await import('playwright-core').catch(() =>
    skip('playwright-core is not installed; ./dev test installs it (npm ci in web/)'));
  const places = [process.env.EARPOINT_CHROMIUM, '/usr/bin/chromium', '/usr/bin/chromium-browser'];
  const executablePath = places.find((path) => path && existsSync(path));
  if (!executablePath) skip('no chromium; install it, or name one in EARPOINT_CHROMIUM');
  return { chromium: playwright.chromium, executablePath };
}

/** Opens a headless browser in which pages may start sound by themselves. */
export async function openBrowser() {
  const { chromium, executablePath } = await findChromium();
  return chromium.launch({ executablePath, args: ['--no-sandbox', '--autoplay-policy=no-user-gesture-required'] });
}

/** Runs the program. `first` is the first line that it printed, with the page's address in it. */
export async function startProgram(...args) {
  const program = process.env.EARPOINT_PROGRAM;
  if (!program) throw new Error('EARPOINT_PROGRAM does not name the program to test');
  const child = spawn(program, args, { stdio: ['ignore', 'pipe', 'pipe'] });
  let errors = '';
  child.stderr.on('data', (text) => (errors += text));
  const first = await new Promise((resolve, reject) => {
    let text = '';
    const timer = setTimeout(() => reject(new Error(`no answer of ${args.join(' ')}: ${errors}`)), START_MS);
    child.stdout.on('data', (part) => {
      text += part;
      if (!text.includes('\n')) return;
      clearTimeout(timer);
      resolve(text.split('\n')[0]);
    });
    child.on('exit', (code) => reject(new Error(`${args.join(' ')} ended with ${code}: ${errors}`)));
  });
  const address = /http:\/\/\S+/.exec(first)[0];
  const stop = () => new Promise((resolve) => {
    child.removeAllListeners('exit');
    child.once('exit', resolve);
    child.kill();
  });
  return { address, first, stop };
}

/** Runs the program to its end. @returns what it printed; throws its error output if it fails */
export async function runProgram(...args) {
  const child = spawn(process.env.EARPOINT_PROGRAM, args, { stdio: ['ignore', 'pipe', 'pipe'] });
  let output = '';
  let errors = '';
  child.stdout.on('data', (text) => (output += text));
  child.stderr.on('data', (text) => (errors += text));
  const code = await new Promise((resolve) => child.on('close', resolve));
  if (code !== 0) throw new Error(`${args.join(' ')} ended with ${code}: ${errors}`);
  return output;
}

/** Who renders for pages of earpoint serve, unless a test says otherwise: `server` or `browser`, and nobody in their place. */
export const ENGINE = process.env.EARPOINT_PAGE_ENGINE ?? 'server';

/**
 * Opens a page and records the hosts that it contacts and its errors. `engine` is whom the page's address asks to render;
 * null: nobody in particular. `prepare` is called with the page before it is loaded.
 */
export async function openPage(browser, address, { engine = ENGINE, prepare = () => {}, ...options } = {}) {
  const page = await browser.newPage({ viewport: { width: 1280, height: 900 }, ...options });
  await prepare(page);
  const url = new URL(address);
  if (engine !== null) url.searchParams.set('engine', engine);
  const hosts = new Set();
  const problems = [];
  page.on('request', (request) => {
    const { protocol, host } = new URL(request.url());
    if (protocol.startsWith('http') || protocol.startsWith('ws')) hosts.add(host);
  });
  page.on('pageerror', (error) => problems.push(error.message));
  page.on('console', (message) => {
    if (message.type() === 'error') problems.push(message.text());
  });
  await page.goto(url.href);
  await page.waitForSelector('#play:not([disabled])');
  return { page, hosts, problems };
}

/** Waits until a condition holds in the page. (playwright's waitForFunction evaluates text, which the page forbids.) */
export async function until(page, isSo, argument) {
  const end = Date.now() + START_MS;
  while (!(await page.evaluate(isSo, argument))) {
    if (Date.now() > end) throw new Error(`timed out waiting for ${isSo}`);
    await page.waitForTimeout(50);
  }
}

/** Waits until the chosen method sounds, and everything that was rendered before has been played, including fades. */
export async function settle(page) {
  await until(page, () => window.earpoint.player.method === window.earpoint.method);
  const end = await page.evaluate(() => window.earpoint.player.sent + 0.2 * window.earpoint.clip.sample_rate_hz);
  await until(page, (sample) => window.earpoint.player.played >= sample, end);
}

/**
 * Measures what the page plays, until there are that many seconds without digital silence: a busy machine may leave
 * gaps. @returns levels of the ears in dB
 */
export function hear(page, seconds) {
  return page.evaluate(async ([duration_s, most_s]) => {
    const { output, context } = window.earpoint.player;
    const tap = context.createScriptProcessor(1024, 2, 2);
    const power = [0, 0];
    let samples = 0;
    await new Promise((resolve, reject) => {
      setTimeout(() => reject(new Error(`heard ${samples} samples in ${most_s} s`)), 1000 * most_s);
      tap.onaudioprocess = ({ inputBuffer }) => {
        const [left, right] = [0, 1].map((ear) => inputBuffer.getChannelData(ear));
        for (let i = 0; i < left.length; ++i) {
          if (left[i] === 0 && right[i] === 0) continue;
          power[0] += left[i] ** 2;
          power[1] += right[i] ** 2;
          ++samples;
        }
        if (samples >= duration_s * context.sampleRate) resolve();
      };
      output.connect(tap);
      tap.connect(context.destination);
    });
    output.disconnect(tap);
    tap.disconnect();
    const level_db = power.map((sum) => 10 * Math.log10(sum / samples));
    return { level_db, difference_db: level_db[0] - level_db[1] };
  }, [seconds, START_MS / 1000]);
}

/** Drags the listener on the map to a place with the pointer: metres, x ahead and y left. */
export async function dragTo(page, x, y) {
  await page.locator('#map').scrollIntoViewIfNeeded();
  const from = await page.evaluate(() => window.earpoint.map.pagePoint());
  const to = await page.evaluate(([px, py]) => window.earpoint.map.pagePoint(px, py), [x, y]);
  await page.mouse.move(...from);
  await page.mouse.down();
  await page.mouse.move(...to, { steps: 5 });
  await page.mouse.up();
}
