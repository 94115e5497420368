// The WebAssembly stream held against the native one, in Node.
import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import { join } from 'node:path';
import { before, test } from 'node:test';
import { TOLERANCE, largestDifference, openStream, peak, readRecording, walk } from './recording.mjs';

const DIST = process.env.EARPOINT_ENGINE; // the built package's dist/
const RECORDINGS = process.env.EARPOINT_RECORDINGS.split(':'); // folders that engine_reference wrote
const { Engine, InputError } = await import(join(DIST, 'index.js'));

let module;
let engine;
const weightsOf = (model) => readFileSync(join(DIST, model));

before(async () => {
  module = await WebAssembly.compile(readFileSync(join(DIST, 'engine.wasm')));
  engine = await Engine.load(module, weightsOf('gtf.safetensors'));
});

for (const folder of RECORDINGS) {
  const recording = readRecording(folder);
  const name = `${recording.model} at ${recording.sampleRate} Hz`;

  test(`a moving earpoint sounds as from the native library: ${name}`, async () => {
    const stream = openStream(await Engine.load(module, weightsOf(recording.model)), recording);
    assert.equal(stream.latency, recording.latency);
    const heard = walk(stream, recording);
    const difference = largestDifference(heard, recording.heard);
    console.log(`largest difference, ${name}: ${difference.toExponential(2)}`);
    assert.ok(difference < TOLERANCE, `differs by ${difference}`);
    // The walk is heard: neither silence, nor the source, nor the sound of standing still.
    assert.ok(peak(heard) > 0.05);
    assert.ok(largestDifference(heard, recording.sound) > 100 * TOLERANCE);
    stream.reset();
    const still = walk(stream, recording, () => ({ x: 0, y: 0, z: 0 }));
    assert.ok(largestDifference(heard, still) > 100 * TOLERANCE);
    stream.close();
  });
}

const recording = readRecording(RECORDINGS[0]);
const start = (samples) => recording.sound.map((ear) => ear.slice(0, samples));

test('blocks of any length give the same sound', () => {
  const whole = start(24000);
  openStream(engine, recording).process(whole, whole);
  const parts = start(24000);
  const stream = openStream(engine, recording);
  for (let at = 0, length = 1; at < 24000; at += length, length = (7 * length) % 1999) {
    const part = parts.map((ear) => ear.subarray(at, at + length));
    stream.process(part, part);
  }
  assert.equal(largestDifference(whole, parts), 0);
  assert.ok(peak(whole) > 0.01);
});

test('without a told position the network locates the speaker, and tells where', () => {
  const stream = engine.stream({ sampleRate: recording.sampleRate });
  assert.equal(stream.speaker, null);
  stream.see(recording.picture, recording.speakerBox);
  const sound = start(96000);
  stream.process(sound, sound);
  const [x, y] = stream.speaker;
  const off = Math.atan2(y, x) - Math.atan2(recording.speaker[1], recording.speaker[0]);
  assert.ok(Math.abs(off) < 0.2, `${off} rad beside the speaker`); // the box alone tells the direction
});

test('RGBA pixels give the sound of the same RGB ones', () => {
  const { width, height, data } = recording.picture;
  const rgba = new Uint8ClampedArray(4 * width * height);
  for (let i = 0; i < width * height; ++i) rgba.set([...data.subarray(3 * i, 3 * i + 3), 255], 4 * i);
  const [rgb, same, none] = [0, 1, 2].map((which) => {
    const stream = engine.stream({ sampleRate: recording.sampleRate });
    if (which < 2) stream.see(which === 0 ? recording.picture : { width, height, data: rgba }, recording.speakerBox);
    stream.moveTo({ x: 1, y: -1, z: 0, yawDeg: 40 });
    const sound = start(24000);
    stream.process(sound, sound);
    return sound;
  });
  assert.equal(largestDifference(rgb, same), 0);
  assert.ok(largestDifference(rgb, none) > TOLERANCE); // the picture matters
});

test('what does not fit is refused with a message, and the stream goes on', () => {
  assert.throws(() => engine.stream({ sampleRate: 12345 }), (error) =>
    error instanceof InputError && /12345 Hz is not supported/.test(error.message));
  assert.throws(() => Engine.fromModule(module, weightsOf('gtf.safetensors').subarray(0, 1000)), InputError);
  const stream = openStream(engine, recording);
  assert.throws(() => stream.moveTo({ x: NaN, y: 0, z: 0 }), InputError);
  assert.throws(() => stream.moveTo({ x: 1e6, y: 0, z: 0 }), InputError);
  assert.throws(() => stream.see(recording.picture, [0.5, 0.5, 0.2, 0.9]), InputError);
  assert.throws(() => stream.see({ width: 3, height: 3, data: new Uint8Array(5) }), InputError);
  assert.throws(() => stream.process(start(128), start(64)), RangeError);
  const sound = start(24000);
  stream.process(sound, sound);
  assert.ok(peak(sound) > 0.01);
});

test('the package has the version of the project', () => {
  const { version } = JSON.parse(readFileSync(join(DIST, '../package.json')));
  const project = readFileSync(new URL('../../../CMakeLists.txt', import.meta.url), 'utf8');
  assert.equal(version, /project\(earpoint VERSION ([\d.]+)/.exec(project)[1]);
});
