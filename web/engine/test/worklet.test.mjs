// The engine in the audio worklet of a real browser, held against the native stream.
import assert from 'node:assert/strict';
import { createReadStream, existsSync } from 'node:fs';
import { createServer } from 'node:http';
import { extname, join } from 'node:path';
import { after, before, test } from 'node:test';
import { openBrowser } from '../../test/harness.mjs';
import { TOLERANCE, largestDifference, peak, readRecording } from './recording.mjs';

const DIST = process.env.EARPOINT_ENGINE;
const FOLDERS = process.env.EARPOINT_RECORDINGS.split(':');
const TYPES = { '.js': 'text/javascript', '.wasm': 'application/wasm', '.html': 'text/html' };

let browser;
let server;
let page;

before(async () => {
  server = createServer(({ url }, response) => {
    const path = join(DIST, url);
    if (url === '/' || !existsSync(path)) {
      response.writeHead(url === '/' ? 200 : 404, { 'Content-Type': 'text/html' }).end('<!doctype html><title>engine</title>');
      return;
    }
    response.writeHead(200, { 'Content-Type': TYPES[extname(path)] ?? 'application/octet-stream' });
    createReadStream(path).pipe(response);
  });
  await new Promise((resolve) => server.listen(0, '127.0.0.1', resolve));
  browser = await openBrowser();
  page = await browser.newPage();
  await page.goto(`http://127.0.0.1:${server.address().port}/`);
});

after(async () => {
  await browser?.close();
  server?.close();
});

/** Renders the recording in the page. Arrays travel as text of their bytes. */
function renderInPage(recording) {
  const text = (array) => Buffer.from(array.buffer, array.byteOffset, array.byteLength).toString('base64');
  return page.evaluate(async ({ model, rate, samples, block, sound, places, picture, speaker, speakerBox }) => {
    const bytes = (base64) => Uint8Array.from(atob(base64), (c) => c.charCodeAt(0));
    const floats = (base64) => new Float32Array(bytes(base64).buffer);
    const { EarpointNode } = await import('/index.js');
    const context = new OfflineAudioContext(2, samples, rate);
    const earpoint = await EarpointNode.create(context, {
      wasm: '/engine.wasm', weights: `/${model}`, processor: '/processor.js',
      picture: { ...picture, data: bytes(picture.data) }, speaker, speakerBox,
    });
    const problems = [];
    earpoint.onproblem = (what) => problems.push(what);
    const walk = floats(places);
    ['x', 'y', 'z', 'yaw', 'pitch', 'roll'].forEach((name, column) => {
      const parameter = earpoint.parameter(name);
      for (let i = 0; i < samples / block; ++i) {
        // A little before the block begins: times are rounded.
        parameter.setValueAtTime(walk[6 * i + column], Math.max(0, ((i - 0.25) * block) / rate));
      }
    });
    const source = new AudioBufferSourceNode(context, { buffer: new AudioBuffer({ length: samples, numberOfChannels: 2, sampleRate: rate }) });
    sound.forEach((ear, index) => source.buffer.copyToChannel(floats(ear), index));
    source.connect(earpoint.node).connect(context.destination);
    source.start();
    const began = performance.now();
    const heard = await context.startRendering();
    const took_s = (performance.now() - began) / 1000;
    const base64 = (array) => {
      const all = new Uint8Array(array.buffer);
      let text = '';
      for (let at = 0; at < all.length; at += 8192) text += String.fromCharCode(...all.subarray(at, at + 8192));
      return btoa(text);
    };
    return {
      heard: [0, 1].map((ear) => base64(heard.getChannelData(ear).slice())),
      latency: earpoint.latency, problems, realTimeShare: (took_s * rate) / samples,
    };
  }, {
    model: recording.model, rate: recording.sampleRate, samples: recording.samples, block: recording.block,
    sound: recording.sound.map(text), places: text(recording.places),
    picture: { ...recording.picture, data: text(recording.picture.data) },
    speaker: recording.speaker, speakerBox: recording.speakerBox,
  });
}

for (const folder of FOLDERS) {
  const recording = readRecording(folder);

  const name = `${recording.model} at ${recording.sampleRate} Hz`;

  test(`the worklet's sound is that of the native library: ${name}`, async () => {
    const { heard, latency, problems } = await renderInPage(recording);
    assert.deepEqual(problems, []);
    assert.equal(latency, recording.latency);
    const ears = heard.map((base64) => {
      const bytes = Buffer.from(base64, 'base64');
      return new Float32Array(bytes.buffer.slice(bytes.byteOffset, bytes.byteOffset + bytes.byteLength));
    });
    const difference = largestDifference(ears, recording.heard);
    console.log(`largest difference, ${name}: ${difference.toExponential(2)}`);
    assert.ok(difference < TOLERANCE, `differs by ${difference}`);
    assert.ok(peak(ears) > 0.05);
  });
}

test('moves and speakers that are told while it plays are heard', async () => {
  const recording = readRecording(FOLDERS[0]);
  const heard = await page.evaluate(async ({ model, rate, speaker }) => {
    const { EarpointNode } = await import('/index.js');
    const samples = rate;
    /** A second of a pulse train; half a second later the earpoint turns to the right, if it does. */
    const render = async (turns, mouth) => {
      const context = new OfflineAudioContext(2, samples, rate);
      const earpoint = await EarpointNode.create(context, {
        wasm: '/engine.wasm', weights: `/${model}`, processor: '/processor.js', speaker,
      });
      earpoint.placeSpeaker(mouth);
      const buffer = new AudioBuffer({ length: samples, numberOfChannels: 2, sampleRate: rate });
      for (const ear of [0, 1]) for (let i = 0; i < samples; i += 400) buffer.getChannelData(ear)[i] = 0.5;
      const source = new AudioBufferSourceNode(context, { buffer });
      source.connect(earpoint.node).connect(context.destination);
      source.start();
      void context.suspend(0.5).then(() => {
        if (turns) earpoint.moveTo({ x: 0, y: 0, z: 0, yawDeg: -90 });
        return context.resume();
      });
      const sound = await context.startRendering();
      await new Promise((resolve) => setTimeout(resolve, 100)); // the last report is on its way
      const levels = [0, 1].map((half) => [0, 1].map((ear) => {
        // Not the tenth of a second in which the turn becomes audible.
        const part = sound.getChannelData(ear).subarray((half * samples) / 2 + samples / 10, ((half + 1) * samples) / 2);
        return 10 * Math.log10(part.reduce((sum, value) => sum + value * value, 1e-12));
      }));
      return { differences_db: levels.map(([left, right]) => left - right), speaker: earpoint.speaker };
    };
    return [await render(true, [2, 0, 0]), await render(false, [2, 0, 0]), await render(false, [0, 2, 0])];
  }, { model: 'kemar.safetensors', rate: recording.sampleRate, speaker: recording.speaker });
  const [turned, still, moved] = heard;
  // Turned to the right, one who was in front is on the left.
  assert.ok(Math.abs(turned.differences_db[0]) < 1 && turned.differences_db[1] > 6, `${turned.differences_db} dB`);
  assert.ok(Math.abs(still.differences_db[1]) < 1, `${still.differences_db} dB`);
  assert.deepEqual([still.speaker, moved.speaker], [[2, 0, 0], [0, 2, 0]]);
});

test('a wrong weight file is refused before the node is made', async () => {
  const message = await page.evaluate(async () => {
    const { EarpointNode, InputError } = await import('/index.js');
    const context = new OfflineAudioContext(2, 128, 48000);
    return EarpointNode.create(context, { wasm: '/engine.wasm', weights: new Uint8Array(100), processor: '/processor.js' })
      .then(() => 'made', (error) => `${error instanceof InputError}: ${error.message}`);
  });
  assert.match(message, /^true: weights/);
});
