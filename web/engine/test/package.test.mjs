// The package as somebody gets it: installed from its tarball, typed, and used as its README shows.
import assert from 'node:assert/strict';
import { execFileSync } from 'node:child_process';
import { mkdtempSync, rmSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { after, before, test } from 'node:test';

const TARBALL = process.env.EARPOINT_TARBALL;
const TYPE_CHECKER = new URL('../../node_modules/typescript/bin/tsc', import.meta.url).pathname;

let folder;

before(() => {
  folder = mkdtempSync(join(tmpdir(), 'earpoint-engine-'));
  writeFileSync(join(folder, 'package.json'), '{"private": true, "type": "module"}');
  // It depends on nothing, so nothing is fetched.
  execFileSync('npm', ['install', '--offline', '--no-audit', '--no-fund', '--silent', TARBALL], { cwd: folder });
});

after(() => rmSync(folder, { recursive: true, force: true }));

const PROGRAM = `
import { readFileSync } from 'node:fs';
import { createRequire } from 'node:module';
import { Engine } from 'earpoint-engine';

const fileOf = (name) => readFileSync(createRequire(import.meta.url).resolve('earpoint-engine/' + name));
const engine = await Engine.load(fileOf('engine.wasm'), fileOf('gtf.safetensors'));
const stream = engine.stream({ sampleRate: 48000 });
stream.moveTo({ x: 1, y: -0.5, z: 0, yawDeg: 90 });
const ears = [0, 1].map(() => Float32Array.from({ length: 9600 }, (_, i) => 0.1 * Math.sin(i / 20)));
stream.process(ears, ears);
console.log(JSON.stringify({ latency: stream.latency, peak: Math.max(...ears[0]) }));
`;

test('the installed package renders', () => {
  writeFileSync(join(folder, 'program.js'), PROGRAM);
  const { latency, peak } = JSON.parse(execFileSync('node', ['program.js'], { cwd: folder }));
  assert.ok(latency > 0 && peak > 0.01, `latency ${latency}, peak ${peak}`);
});

/** @returns what the type checker complains of */
function complaints(program) {
  writeFileSync(join(folder, 'program.ts'), program);
  const flags = ['--noEmit', '--strict', '--target', 'es2022', '--module', 'esnext', '--moduleResolution', 'bundler'];
  try {
    execFileSync('node', [TYPE_CHECKER, ...flags, 'program.ts'], { cwd: folder });
    return '';
  } catch (error) {
    return String(error.stdout);
  }
}

test('its types accept what it takes and refuse what it does not', () => {
  const head = `import { Engine, EarpointNode, Stream } from 'earpoint-engine';
    declare const engine: Engine; declare const node: EarpointNode; declare const ears: Float32Array[];
    const stream: Stream = engine.stream({ sampleRate: 48000 });`;
  const good = 'stream.moveTo({ x: 1, y: 0, z: 0 }); stream.process(ears, ears); node.placeSpeaker([1, 0, 0]);';
  assert.equal(complaints(`${head} ${good}`), '');
  assert.match(complaints(`${head} stream.moveTo({ x: 1, y: 0 });`), /'z'/);
  assert.match(complaints(`${head} engine.stream({});`), /sampleRate/);
});
