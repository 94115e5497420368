// The viewer in a real browser, on the clip and the networks that come with Earpoint.
import assert from 'node:assert/strict';
import { after, before, test } from 'node:test';
import { SOURCE_DIR, dragTo, hear, openBrowser, openPage, startProgram, until } from './harness.mjs';

const SPEAKER = [1.89, 0.196, 0.147]; // as examples/earpoints.json tells it
const RATE_HZ = 48000;

let browser;
let program;
let opened;

before(async () => {
  browser = await openBrowser();
  program = await startProgram('serve', `${SOURCE_DIR}/examples/clip.mp4`, '--speaker', SPEAKER.join(','), '--quiet');
  opened = await openPage(browser, program.address);
});

after(async () => {
  await browser?.close();
  await program?.stop();
});

/** Where the speaker is from a place and a heading: radians, to the left. */
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
  const heard = await hear(page, 1);
  assert.equal(await page.evaluate(() => window.earpoint.player.context.state), 'running');
  // The clip has speech throughout: silence would be digital zeros.
  assert.ok(heard.sounding > RATE_HZ, `${heard.sounding} of ${2 * heard.samples} samples are not zero`);
});

test('the ear on the side of the speaker is the louder one after a drag', async () => {
  const { page } = opened;
  for (const side of [-1, 1]) {
    // Beside the speaker, half a metre behind and a metre to the right or left of them.
    await dragTo(page, SPEAKER[0] - 0.5, SPEAKER[1] + side);
    const pose = await poseOf(page);
    assert.ok(Math.abs(pose.y - (SPEAKER[1] + side)) < 0.05, `dragged to y = ${pose.y}`);
    await page.waitForTimeout(300); // what was rendered before the drag has been played
    const { difference_db } = await hear(page, 1.2);
    const expected = Math.sign(azimuthFrom(pose)); // left is positive
    assert.ok(expected * difference_db > 1, `at y = ${pose.y} left is ${difference_db} dB louder than right`);
  }
});

test('another method sounds different', async () => {
  const { page } = opened;
  // Right of the speaker they are on the left; the recording was made in front of them.
  await dragTo(page, SPEAKER[0] - 0.5, SPEAKER[1] - 1);
  await page.waitForTimeout(300);
  const there = await hear(page, 1);
  await page.click('[data-method=input]');
  await page.waitForTimeout(300);
  const here = await hear(page, 1);
  assert.ok(there.difference_db - here.difference_db > 1, `${there.difference_db} and ${here.difference_db} dB`);
  assert.ok(here.sounding > RATE_HZ);
  await page.click('[data-method=gtf]');
});

test('no other host is asked for anything, and nothing fails in the page', () => {
  assert.deepEqual([...opened.hosts], [new URL(program.address).host]);
  assert.deepEqual(opened.problems, []);
});
