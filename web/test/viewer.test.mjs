// The viewer in a real browser, on the clip and the networks that come with Earpoint.
import assert from 'node:assert/strict';
import { mkdtempSync, readFileSync, rmSync } from 'node:fs';
import { networkInterfaces, tmpdir } from 'node:os';
import { join } from 'node:path';
import { after, before, test } from 'node:test';
import { SOURCE_DIR, dragTo, hear, openBrowser, openPage, runProgram, settle, startProgram, until } from './harness.mjs';

const SPEAKER = [1.89, 0.196, 0.147]; // as in examples/earpoints.json
const CLIP = `${SOURCE_DIR}/examples/clip.mp4`;
const KNOWN = `${SOURCE_DIR}/examples/earpoints.json`;
const TOLD = ['--speaker', SPEAKER.join(','), '--speaker-box', '0.383,0.348,0.513,1'];

let browser;
let program;
let opened;

before(async () => {
  browser = await openBrowser();
  program = await startProgram('serve', CLIP, ...TOLD, '--earpoints', KNOWN, '--quiet');
  opened = await openPage(browser, program.address);
});

after(async () => {
  await browser?.close();
  await program?.stop();
});

/** Azimuth of the speaker from a pose: radians, positive to the left. */
const azimuthFrom = ({ x, y, yaw_deg }) => Math.atan2(SPEAKER[1] - y, SPEAKER[0] - x) - (yaw_deg * Math.PI) / 180;

const poseOf = (page) => page.evaluate(() => ({ ...window.earpoint.map.pose }));

test('the page shows the clip', async () => {
  const { page } = opened;
  assert.match(await page.textContent('#name'), /clip\.mp4/);
  await until(page, () => document.getElementById('picture').naturalWidth > 0);
});

test('sound starts', async () => {
  const { page } = opened;
  await page.click('#play');
  await until(page, () => window.earpoint.player?.playing);
  const { level_db } = await hear(page, 1);
  assert.equal(await page.evaluate(() => window.earpoint.player.context.state), 'running');
  assert.ok(Math.min(...level_db) > -80, `${level_db} dB`);
});

test('the ear on the side of the speaker is the louder one after a drag', async () => {
  const { page } = opened;
  for (const side of [-1, 1]) {
    // Beside the speaker, half a metre behind and a metre to the right or left of them.
    await dragTo(page, SPEAKER[0] - 0.5, SPEAKER[1] + side);
    const pose = await poseOf(page);
    assert.ok(Math.abs(pose.y - (SPEAKER[1] + side)) < 0.05, `dragged to y = ${pose.y}`);
    await settle(page);
    const { difference_db } = await hear(page, 1.2);
    const expected = Math.sign(azimuthFrom(pose)); // left is positive
    assert.ok(expected * difference_db > 1, `at y = ${pose.y} left is ${difference_db} dB louder than right`);
  }
});

test('another method sounds different', async () => {
  const { page } = opened;
  // From the right of the speaker, they are on the left; the recording was made in front of them.
  await dragTo(page, SPEAKER[0] - 0.5, SPEAKER[1] - 1);
  await settle(page);
  const there = await hear(page, 1);
  await page.click('[data-method=input]');
  await settle(page);
  const here = await hear(page, 1);
  assert.ok(there.difference_db - here.difference_db > 1, `${there.difference_db} and ${here.difference_db} dB`);
  await page.click('[data-method=gtf]');
});

test('every method can be heard, and loudness is matched on request', async () => {
  const { page } = opened;
  for (const method of ['dsp', 'vigas']) {
    await page.click(`[data-method=${method}]`);
    await settle(page);
    const { level_db } = await hear(page, 0.5);
    assert.ok(Math.min(...level_db) > -80, `${method}: ${level_db} dB`);
  }
  // Four metres behind the camera gtf is far quieter than the recording.
  await page.click('[data-method=gtf]');
  await dragTo(page, -4, 0);
  const loudness = async () => {
    await page.evaluate(() => window.earpoint.player.leap(1)); // the same words each time
    await settle(page);
    return Math.max(...(await hear(page, 1)).level_db);
  };
  const quiet = await loudness();
  await page.check('#match');
  const matched = await loudness();
  await page.uncheck('#match');
  assert.ok(matched > quiet + 2, `${matched} dB, without ${quiet} dB`);
});

test('keys walk, turn and play', async () => {
  const { page } = opened;
  await page.click('#home');
  await page.focus('#map');
  for (const key of ['ArrowUp', 'ArrowUp', 'ArrowRight', 'q', 'r']) await page.keyboard.press(key);
  const pose = await poseOf(page);
  assert.deepEqual(Object.values(pose).map((n) => Number(n.toFixed(3))), [0.2, -0.1, 0.05, 5]);
  await page.keyboard.press(' ');
  assert.equal(await page.evaluate(() => window.earpoint.player.playing), false);
});

test('a recorded walk is replayed, and gives the same files on the page and by the command line', async () => {
  const { page } = opened;
  const folder = mkdtempSync(join(tmpdir(), 'earpoint-walk-'));
  const save = async (name) => {
    const [download] = await Promise.all([page.waitForEvent('download'), page.click(`text=Save ${name}`)]);
    const path = join(folder, `page.${name.toLowerCase()}`);
    await download.saveAs(path);
    return path;
  };
  try {
    await page.click('#record');
    await until(page, () => window.earpoint.player?.playing);
    await settle(page);
    await dragTo(page, 1.4, 0.9);
    await settle(page);
    await page.click('#record');
    await page.click('#play');
    const csv = await save('CSV');
    const steps = readFileSync(csv, 'utf8').trim().split('\n').slice(1).map((line) => line.split(',').map(Number));
    assert.ok(steps.length > 8);

    // Somewhere else, and then once more from the first step to the last.
    await page.click('#home');
    await dragTo(page, -1, -1);
    await page.click('#replay');
    const isAt = ([, x, y]) => until(page, ([px, py]) => {
      const { pose } = window.earpoint.map;
      return Math.hypot(pose.x - px, pose.y - py) < 0.02;
    }, [x, y]);
    await isAt(steps[0]);
    await isAt(steps[steps.length - 1]);
    const moved = steps.find(([, x, y]) => Math.hypot(x - steps[0][1], y - steps[0][2]) > 0.1);
    assert.ok(moved, 'the walk stands still');
    await until(page, (time_s) => window.earpoint.player.time_s >= time_s, moved[0]);
    await page.click('#play');

    for (const name of ['WAV', 'MP4']) {
      const saved = await save(name);
      const again = join(folder, `again.${name.toLowerCase()}`);
      await runProgram('render', CLIP, ...TOLD, '--path', csv, '--model', 'gtf', '--quiet', '-o', again);
      assert.ok(readFileSync(saved).equals(readFileSync(again)), `the two ${name} files differ`);
    }
  } finally {
    rmSync(folder, { recursive: true });
  }
});

test('two pages play at once', async () => {
  const { page } = opened;
  const other = await openPage(browser, program.address);
  await other.page.click('#play');
  await page.click('#play');
  await until(other.page, () => window.earpoint.player?.playing);
  await Promise.all([hear(page, 0.5), hear(other.page, 0.5)]);
  await other.page.close();
  assert.deepEqual(other.problems, []);
});

test('a recording of the user is played, and a program with the name of a movie is refused', async () => {
  const { page } = await openPage(browser, program.address);
  const bring = (name, buffer) => page.setInputFiles('#file', { name, mimeType: 'video/mp4', buffer });
  await bring('holiday.mp4', readFileSync(process.execPath).subarray(0, 1_000_000));
  await until(page, () => document.getElementById('problem').textContent !== '');
  assert.match(await page.textContent('#problem'), /^holiday\.mp4: .*\w/);
  // This one is dropped on the page.
  const told = page.waitForNavigation();
  await page.evaluate(([name, base64]) => {
    const bytes = Uint8Array.from(atob(base64), (c) => c.charCodeAt(0));
    const dataTransfer = new DataTransfer();
    dataTransfer.items.add(new File([bytes], name, { type: 'video/mp4' }));
    for (const event of ['dragover', 'drop']) {
      document.body.dispatchEvent(new DragEvent(event, { dataTransfer, bubbles: true, cancelable: true }));
    }
  }, ['mine.mp4', readFileSync(CLIP).toString('base64')]);
  await told;
  await until(page, () => document.getElementById('name').textContent.startsWith('mine.mp4'));
  await page.click('#play');
  await until(page, () => window.earpoint.player?.playing);
  await hear(page, 0.5);
  await page.close();
});

test('the truth is heard at the places where it is known', async () => {
  const { page, problems } = await openPage(browser, `${program.address}?clip=earpoints`);
  await page.click('text=speaker on the right');
  assert.deepEqual(Object.values(await poseOf(page)).map((n) => Number(n.toFixed(2))), [1.49, 0.6, 0, 45]);
  await page.click('[data-method=truth]');
  await page.click('#play');
  await until(page, () => window.earpoint.player?.playing);
  assert.ok((await hear(page, 1)).difference_db < -1);
  await page.click('text=speaker on the left');
  await settle(page);
  assert.ok((await hear(page, 1)).difference_db > 1);
  await page.close();
  assert.deepEqual(problems, []);
});

test('another computer plays with the token, where browsers have no worklets', async (t) => {
  const shared = await startProgram('serve', CLIP, ...TOLD, '--host', '0.0.0.0', '--quiet');
  try {
    // An address of the network, which a browser does not take for this computer.
    const { port, search } = new URL(shared.address);
    const places = Object.values(networkInterfaces()).flat().filter(({ family, internal }) => family === 'IPv4' && !internal);
    if (places.length === 0) return t.skip('this computer has no network address');
    const { page, problems } = await openPage(browser, `http://${places[0].address}:${port}/${search}`);
    assert.equal(await page.evaluate(() => window.isSecureContext), false);
    assert.ok(!page.url().includes('token'));
    await page.click('#play');
    await until(page, () => window.earpoint.player?.playing);
    assert.ok(Math.min(...(await hear(page, 0.5)).level_db) > -80);
    await dragTo(page, SPEAKER[0] - 0.5, SPEAKER[1] - 1);
    await settle(page);
    assert.ok((await hear(page, 1)).difference_db > 1);
    await page.close();
    assert.deepEqual(problems, []);
  } finally {
    await shared.stop();
  }
});

test('no other host is asked for anything, and nothing fails in the page', () => {
  assert.deepEqual([...opened.hosts], [new URL(program.address).host]);
  assert.deepEqual(opened.problems, []);
});
