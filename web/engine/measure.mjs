// The share of one core that a moving earpoint takes: WebAssembly in Node, whose engine is Chromium's, blocks of 128 samples.
// Usage: node web/engine/measure.mjs DIST RECORDING...    One JSON object a line; RECORDING is what engine_reference wrote.
import { readFileSync } from 'node:fs';
import { join, resolve } from 'node:path';
import { openStream, readRecording, walk } from './test/recording.mjs';

const ROUNDS = 5;
const [dist, ...folders] = process.argv.slice(2);
const { Engine } = await import(resolve(dist, 'index.js'));
const module = await WebAssembly.compile(readFileSync(join(dist, 'engine.wasm')));

for (const folder of folders) {
  const recording = readRecording(folder);
  const engine = await Engine.load(module, readFileSync(join(dist, recording.model)));
  const stream = openStream(engine, recording);
  const shares = [];
  for (let round = 0; round <= ROUNDS; ++round) {
    stream.reset();
    const before = process.cpuUsage();
    walk(stream, recording);
    const { user, system } = process.cpuUsage(before);
    // The first round compiles.
    if (round > 0) shares.push((user + system) / 1e6 / (recording.samples / recording.sampleRate));
  }
  const began = performance.now();
  stream.see(recording.picture, recording.speakerBox);
  const picture_ms = performance.now() - began;
  shares.sort((a, b) => a - b);
  console.log(JSON.stringify({
    model: recording.model, sample_rate_hz: recording.sampleRate, block: recording.block, rounds: ROUNDS,
    core_share_median: Number(shares[ROUNDS >> 1].toFixed(4)), core_share_least: Number(shares[0].toFixed(4)),
    picture_ms: Number(picture_ms.toFixed(1)),
  }));
  stream.close();
}
