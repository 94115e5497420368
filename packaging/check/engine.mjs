// The engine for browsers in the Node of Debian: renders a sound block by block.
// usage: node engine.mjs IN.raw OUT.raw   (32-bit floats, two ears, interleaved, 48 kHz)
import { readFileSync, writeFileSync } from 'node:fs';
import { createRequire } from 'node:module';
import { Engine } from 'earpoint-engine';

const [input, output] = process.argv.slice(2);
const bytes = readFileSync(input);
const samples = new Float32Array(bytes.buffer, bytes.byteOffset, bytes.length / 4);
const ears = [0, 1].map((ear) => Float32Array.from({ length: samples.length / 2 }, (_, i) => samples[2 * i + ear]));

const fileOf = (name) => readFileSync(createRequire(import.meta.url).resolve('earpoint-engine/' + name));
const engine = await Engine.load(fileOf('engine.wasm'), fileOf('gtf.safetensors'));
const stream = engine.stream({ sampleRate: 48000 });
stream.placeSpeaker([2, 0.25, 0.125]);
stream.moveTo({ x: 1, y: -0.5, z: 0, yawDeg: 90 });
const start = performance.now();
for (let at = 0; at < ears[0].length; at += 128) {
  const block = ears.map((ear) => ear.subarray(at, at + 128));
  stream.process(block, block);
}
const share = (performance.now() - start) / 1000 / (ears[0].length / 48000);
for (let i = 0; i < ears[0].length; ++i) for (const ear of [0, 1]) samples[2 * i + ear] = ears[ear][i];
writeFileSync(output, Buffer.from(samples.buffer, samples.byteOffset, samples.byteLength));
console.log(`rendered by Node ${process.versions.node} in ${share.toFixed(2)} of the sound's duration`);
