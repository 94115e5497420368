// The page of earpoint serve in a real browser, with the sound rendered there by the engine (./dev wasm).
import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import { networkInterfaces } from 'node:os';
import { after, before, test } from 'node:test';
import { SOURCE_DIR, dragTo, hear, openBrowser, openPage, settle, startProgram, until } from './harness.mjs';

const SPEAKER = [1.89, 0.196, 0.147]; // as in examples/earpoints.json
const CLIP = `${SOURCE_DIR}/examples/clip.mp4`;
const TOLD = ['--speaker', SPEAKER.join(','), '--speaker-box', '0.383,0.348,0.513,1'];

/**
 * Largest difference between the page's sound and the server's. The engine's own is 1e-4, of rounding (recording.mjs);
 * a step of the head, a missing warm-up or a sample's delay make more than ten times as much as this.
 */
const TOLERANCE = 1e-3;

/** Collects what the page plays, block by block, whatever else the computer does. */
const CAPTURE = `registerProcessor('capture', class extends AudioWorkletProcessor {
  constructor() {
    super();
    this.blocks = [];
    this.port.onmessage = () => {
      this.port.postMessage(this.blocks);
      this.blocks = [];
    };
  }
  process([input]) {
    if (input.length === 2) this.blocks.push(input.map((ear) => ear.slice()));
    return true;
  }
});`;
let browser;
let program;
let opened;
let recorded; // the same page without its policy, which forbids the script that records
const requests = [];

/** Opens the page as users do: nobody is asked to render in particular. */
const open = (address, options = {}) => openPage(browser, address, { engine: null, ...options });

async function play(page) {
  if (!(await page.evaluate(() => window.earpoint.player?.playing))) await page.click('#play');
  await until(page, () => window.earpoint.player?.playing && window.earpoint.player.played > 0);
}

/** Waits until a voice sounds: between two, and while the server is late, none does. */
const expectVoice = (page, voice) => until(page, (expected) => window.earpoint.player.voice === expected, voice);

const stateOf = (page) => page.evaluate(() => {
  const { voice, playing, isInBrowser, whyServer } = window.earpoint.player;
  return { voice, playing, isInBrowser, whyServer };
});

before(async () => {
  browser = await openBrowser();
  program = await startProgram('serve', CLIP, ...TOLD, '--listeners', '2', '--quiet');
  const { has_engine } = await (await fetch(new URL('/api/clips', program.address))).json();
  if (!has_engine) {
    await browser.close();
    await program.stop();
    // ./dev wasm takes this for a failure: there the engine has been built.
    console.log('skipped: the program was built without the engine for browsers; ./dev wasm builds both');
    process.exit(77);
  }
  opened = await open(program.address);
  recorded = (await open(program.address, { bypassCSP: true })).page;
  opened.page.on('request', (request) => requests.push(new URL(request.url()).pathname));
});

after(async () => {
  await browser?.close();
  await program?.stop();
});

test('the page renders in the browser, and the server nothing', async () => {
  const { page } = opened;
  await play(page);
  const { level_db } = await hear(page, 1);
  assert.ok(Math.min(...level_db) > -80, `${level_db} dB`);
  await expectVoice(page, 'gtf');
  assert.deepEqual(await stateOf(page), { voice: 'gtf', playing: true, isInBrowser: true, whyServer: '' });
  assert.match(await page.textContent('#speed'), /% of real time.*, in this browser$/);
  assert.deepEqual(requests.filter((path) => path.startsWith('/api/listeners')), []);
});

/** What the server gives from a sample on, standing still: left and right. */
async function serverSound(start, samples, method, { x, y, z, yaw_deg }) {
  const ask = async (path, body) => {
    const response = await fetch(new URL(path, program.address), { method: 'POST', body: body && JSON.stringify(body) });
    if (response.status !== 200) throw new Error(`${path}: ${await response.text()}`);
    return response;
  };
  const { listener } = await (await ask('/api/listeners', { clip: 'clip' })).json();
  const ears = [new Float32Array(samples), new Float32Array(samples)];
  const part = 2048;
  for (let at = 0; at < samples; at += part) {
    const body = { start: start + at, samples: Math.min(part, samples - at), method, position_m: [x, y, z], yaw_deg };
    const sound = new Float32Array(await (await ask(`/api/listeners/${listener}/sound`, body)).arrayBuffer());
    for (let i = 0; i < sound.length; ++i) ears[i % 2][at + (i >> 1)] = sound[i];
  }
  await ask(`/api/listeners/${listener}/leave`);
  return ears;
}

/** Starts to record what the page plays. @returns a function that ends it and gives both ears */
async function record(page) {
  await page.evaluate(async (script) => {
    const { context, output } = window.earpoint.player;
    window.captures ??= context.audioWorklet.addModule(`data:text/javascript,${encodeURIComponent(script)}`);
    await window.captures;
    window.capture = new AudioWorkletNode(context, 'capture', { channelCount: 2, channelCountMode: 'explicit' });
    output.connect(window.capture).connect(context.destination);
  }, CAPTURE);
  return async () => {
    const ears = await page.evaluate(async () => {
      const { capture } = window;
      const blocks = await new Promise((resolve) => {
        capture.port.onmessage = ({ data }) => resolve(data);
        capture.port.postMessage('');
      });
      window.earpoint.player.output.disconnect(capture);
      capture.disconnect();
      return [0, 1].map((side) => {
        const bytes = new Uint8Array(Float32Array.from(blocks.flatMap((block) => [...block[side]])).buffer);
        let text = '';
        for (let at = 0; at < bytes.length; at += 8192) text += String.fromCharCode(...bytes.subarray(at, at + 8192));
        return btoa(text);
      });
    });
    return ears.map((base64) => {
      const bytes = Buffer.from(base64, 'base64');
      return new Float32Array(bytes.buffer.slice(bytes.byteOffset, bytes.byteOffset + bytes.byteLength));
    });
  };
}

const firstSound = ([left, right]) => left.findIndex((sample, i) => sample !== 0 || right[i] !== 0);

function largestDifference(a, b, shift, from, to) {
  let largest = 0;
  a.forEach((ear, side) => {
    for (let i = from; i < to; ++i) {
      const difference = Math.abs(ear[i + shift] - b[side][i]);
      if (!(difference <= largest)) largest = difference; // NaN counts as a difference
    }
  });
  return largest;
}

for (const method of ['gtf', 'dsp', 'input']) {
  test(`after a leap, standing still, the page's ${method} is the server's`, async () => {
    const page = recorded;
    const rate_hz = await page.evaluate(() => window.earpoint.clip.sample_rate_hz);
    const pose = { x: 1.1, y: -0.7, z: 0.1, yaw_deg: 35 };
    const start = 2 * rate_hz;
    const samples = Math.round(0.5 * rate_hz);
    await play(page);
    await page.click(`[data-method=${method}]`);
    await settle(page);
    await page.click('#play'); // pause
    await page.evaluate((there) => window.earpoint.map.set(there), pose);
    await page.evaluate((time_s) => window.earpoint.player.leap(time_s), start / rate_hz);
    await page.waitForTimeout(300); // the last sound before has faded
    const finish = await record(page);
    const before_leap = await page.evaluate(() => window.earpoint.player.played);
    await page.click('#play');
    await until(page, (sample) => window.earpoint.player.played > sample, before_leap + samples + rate_hz / 4);
    await expectVoice(page, method);
    const heard = await finish();
    const expected = await serverSound(start, samples, method, pose);
    // The first of the page's samples is that of `start`; sound begins within 5 ms.
    const shift = firstSound(heard);
    assert.ok(shift >= 0, 'silence');
    const from = Math.round(0.006 * rate_hz);
    const difference = largestDifference(heard, expected, shift, from, samples);
    const peak = largestDifference(expected, expected.map((ear) => new Float32Array(ear.length)), 0, from, samples);
    console.log(`largest difference, ${method}: ${difference.toExponential(2)}, peak ${peak.toFixed(3)}`);
    assert.ok(peak > 0.02, `peak ${peak}`);
    assert.ok(difference < TOLERANCE, `${method} differs by ${difference}`);
    // A sample's delay would have been noticed.
    assert.ok(largestDifference(heard, expected, shift + 1, from, samples) > 3 * TOLERANCE);
    await page.click('#play'); // pause
  });
}

test('after a drag the ear on the side of the speaker is the louder one, and the latency is shown', async () => {
  const { page } = opened;
  await page.click('[data-method=gtf]');
  await play(page);
  for (const side of [-1, 1]) {
    // Half a metre behind the speaker and a metre to the right or left of them: they are on the other side.
    await dragTo(page, SPEAKER[0] - 0.5, SPEAKER[1] + side);
    await page.evaluate(() => window.earpoint.map.set({ ...window.earpoint.map.pose, yaw_deg: 0 }));
    await settle(page);
    const { difference_db } = await hear(page, 1.2);
    assert.ok(-side * difference_db > 1, `at y = ${SPEAKER[1] + side} left is ${difference_db} dB louder than right`);
  }
  await until(page, () => window.earpoint.player.latency_s !== undefined);
  await until(page, () => /\d+ ms from move to sound, in this browser$/.test(document.getElementById('speed').textContent));
  await expectVoice(page, 'gtf');
});

const steepest = (ears) => Math.max(...ears.map((ear) => {
  let most = 0;
  for (let i = 1; i < ear.length; ++i) most = Math.max(most, Math.abs(ear[i] - ear[i - 1]));
  return most;
}));

test('moving, pausing, leaping and changes of method make no click', async () => {
  const page = recorded;
  const samples = await page.evaluate(() => window.earpoint.clip.samples);
  const near = { x: 0.4, y: 0, z: 0, yaw_deg: 0 };
  await play(page);
  await page.evaluate((pose) => window.earpoint.map.set(pose), near);
  const during = async (action) => {
    await page.evaluate(() => window.earpoint.player.leap(1));
    await page.waitForTimeout(500);
    const finish = await record(page);
    await action();
    await page.waitForTimeout(1000);
    return steepest(await finish());
  };
  const shake = async () => {
    for (let i = 0; i < 10; ++i) {
      await page.evaluate((y) => window.earpoint.map.moveTo(0.4, y), i % 2 ? 1 : -1);
      await page.waitForTimeout(70);
    }
    await page.evaluate((pose) => window.earpoint.map.set(pose), near);
  };
  const choose = (method) => () => page.click(`[data-method=${method}]`);
  const actions = {
    moves: shake,
    pause: async () => {
      await page.click('#play');
      await page.waitForTimeout(200);
      await page.click('#play');
    },
    leap: () => page.evaluate(() => window.earpoint.player.leap(1.2)),
    dsp: choose('dsp'), input: choose('input'), gtf: choose('gtf'),
  };
  const steps = {};
  for (const [name, action] of Object.entries(actions)) steps[name] = await during(action);
  await page.close();
  // The steepest that the methods have by themselves, in all of the clip: words differ by more than ten decibels.
  const usual = [];
  for (const method of ['gtf', 'dsp', 'input']) usual.push(steepest(await serverSound(0, samples, method, near)));
  const most = Math.max(...usual);
  console.log(`steepest steps: ${JSON.stringify(steps)}, usual ${usual}`);
  // At other places sound is louder by a few decibels. A click is a step as large as the sound, ten times as much.
  for (const [name, step] of Object.entries(steps)) assert.ok(step < 2 * most, `${name}: ${step}, otherwise ${most}`);
});

test('changes between the browser and the server keep the position and the state', async () => {
  const { page } = opened;
  await page.click('[data-method=gtf]');
  await play(page);
  await page.evaluate(() => window.earpoint.player.leap(0.5));
  await settle(page);
  // Where the clip would begin if it had been played without a jump.
  const origin = () => page.evaluate(() => {
    const { player, clip } = window.earpoint;
    return (Math.round(player.time_s * clip.sample_rate_hz) - player.played + 1e6 * clip.samples) % clip.samples;
  });
  const before = await origin();
  for (const [method, voice] of [['vigas', null], ['dsp', 'dsp'], ['vigas', null], ['input', 'input'], ['gtf', 'gtf']]) {
    await page.click(`[data-method=${method}]`);
    await settle(page);
    await hear(page, 0.3);
    await expectVoice(page, voice);
    const { voice: _, ...state } = await stateOf(page);
    assert.deepEqual(state, { playing: true, isInBrowser: voice !== null, whyServer: '' });
    assert.equal(await origin(), before, `${method}: the position has jumped`);
  }
  // The same while it rests.
  await page.click('#play');
  await page.waitForTimeout(200);
  const time_s = await page.evaluate(() => window.earpoint.player.time_s);
  for (const method of ['vigas', 'dsp', 'gtf']) await page.click(`[data-method=${method}]`);
  await page.waitForTimeout(200);
  assert.equal((await stateOf(page)).playing, false);
  assert.equal(await page.evaluate(() => window.earpoint.player.time_s), time_s);
  await page.click('#play');
  await settle(page);
  await expectVoice(page, 'gtf');
});

test('the clip starts again at its end', async () => {
  const { page } = opened;
  await play(page);
  await page.evaluate(() => window.earpoint.player.leap(window.earpoint.clip.duration_s - 0.3));
  await until(page, () => window.earpoint.player.time_s < 2 && window.earpoint.player.time_s > 0.2);
  await expectVoice(page, 'gtf');
  await hear(page, 0.3);
});

test('more pages play than the server has room for listeners', async () => {
  const others = [];
  for (let i = 0; i < 3; ++i) others.push(await open(program.address));
  for (const { page } of others) {
    await play(page);
    await hear(page, 0.2);
    await expectVoice(page, 'gtf');
    await page.click('#play');
  }
  for (const { page, problems } of others) {
    await page.close();
    assert.deepEqual(problems, []);
  }
});

test('a recording of the user is rendered in the browser too', async () => {
  const { page } = await open(program.address);
  const told = page.waitForNavigation();
  await page.setInputFiles('#file', { name: 'mine.mp4', mimeType: 'video/mp4', buffer: readFileSync(CLIP) });
  await told;
  await until(page, () => document.getElementById('name').textContent.startsWith('mine.mp4'));
  await play(page);
  await hear(page, 0.3);
  await expectVoice(page, 'gtf');
  await page.close();
});

test('another computer renders by itself, where browsers have no worklets', async (t) => {
  const shared = await startProgram('serve', CLIP, ...TOLD, '--host', '0.0.0.0', '--quiet');
  try {
    // An address of the network, which a browser does not take for this computer.
    const { port, search } = new URL(shared.address);
    const places = Object.values(networkInterfaces()).flat().filter(({ family, internal }) => family === 'IPv4' && !internal);
    if (places.length === 0) return t.skip('this computer has no network address');
    const { page, problems } = await open(`http://${places[0].address}:${port}/${search}`);
    assert.equal(await page.evaluate(() => window.isSecureContext), false);
    await play(page);
    await dragTo(page, SPEAKER[0] - 0.5, SPEAKER[1] - 1);
    await settle(page);
    assert.ok((await hear(page, 1)).difference_db > 1);
    await expectVoice(page, 'gtf');
    await page.close();
    assert.deepEqual(problems, []);
  } finally {
    await shared.stop();
  }
});

test('the server renders where the engine fails or the address asks for it', async () => {
  const broken = (page) => page.route('**/engine.wasm', (route) => route.fulfill({ status: 404, body: '{}' }));
  // A server of its own: on a busy computer other pages may have gone over to the first one, which has room for two.
  const server = await startProgram('serve', CLIP, ...TOLD, '--quiet');
  try {
    for (const [engine, prepare, why] of [[null, broken, /404/], ['server', undefined, /address/]]) {
      const { page } = await openPage(browser, server.address, { engine, prepare });
      await play(page);
      await hear(page, 0.3);
      await expectVoice(page, null);
      assert.match((await stateOf(page)).whyServer, why);
      await until(page, () => /by the server \(.+\)$/.test(document.getElementById('speed').textContent));
      await page.close();
    }
  } finally {
    await server.stop();
  }
});

test('nobody renders in place of the browser if the address asks for it', async () => {
  const prepare = (page) => page.route('**/engine.wasm', (route) => route.fulfill({ body: 'no engine' }));
  const { page } = await openPage(browser, program.address, { engine: 'browser', prepare });
  await page.click('#play');
  await until(page, () => /engine failed/.test(document.getElementById('problem').textContent));
  await page.waitForTimeout(300);
  assert.equal(await page.evaluate(() => Boolean(window.earpoint.player?.playing)), false);
  await page.close();
});

test('no other host is asked for anything, and nothing fails in the page', () => {
  assert.deepEqual([...opened.hosts], [new URL(program.address).host]);
  assert.deepEqual(opened.problems, []);
});
