// What the page plays, sample by sample, without a browser: leaps, changes of the voice, and the server's parts.
import assert from 'node:assert/strict';
import { execFileSync } from 'node:child_process';
import { mkdtempSync, rmSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { test } from 'node:test';
import { SOURCE_DIR } from './harness.mjs';

const RATE_HZ = 16000;
const SAMPLES = 2 * RATE_HZ; // of the clip
const BLOCK = 128;
const RAMP = 0.005 * RATE_HZ;
const FADE = 0.02 * RATE_HZ;

async function load(name) {
  const folder = mkdtempSync(join(tmpdir(), 'earpoint-page-'));
  const path = join(folder, `${name}.mjs`);
  try {
    execFileSync('esbuild', [`${SOURCE_DIR}/web/src/${name}.ts`, '--bundle', '--format=esm', '--log-level=error', `--outfile=${path}`]);
    return await import(path);
  } finally {
    rmSync(folder, { recursive: true });
  }
}
const { Playback } = await load('playback');
const { EngineVoice } = await load('voices');
const { LevelMatch } = await load('level_match');

/** Sample i of the clip is i + 1, of the right ear negative: it tells where it is from. */
const clip = [1, -1].map((sign) => Float32Array.from({ length: SAMPLES }, (_, i) => sign * (i + 1)));

/** The server's sound is the clip plus a million. */
function partOf(start, samples) {
  return { start, part: Float32Array.from({ length: 2 * samples }, (_, i) => 1e6 + start + (i >> 1) + 1) };
}

function openPlayback() {
  const reports = [];
  const playback = new Playback(SAMPLES, RATE_HZ, (report) => reports.push(report));
  playback.obey({ sound: clip });
  playback.obey({ open: 'input' });
  return { playback, reports, last: () => reports[reports.length - 1] };
}

/** Plays so many samples. @returns the left ear */
function run(playback, samples) {
  const heard = new Float32Array(samples);
  for (let at = 0; at < samples; at += BLOCK) {
    playback.fill(heard.subarray(at, at + BLOCK), new Float32Array(BLOCK));
  }
  return heard;
}

test('the recording plays from where it was told, and begins without a click', () => {
  const { playback, last } = openPlayback();
  playback.obey({ voice: 'input' });
  playback.obey({ leap: 1000 });
  assert.ok(run(playback, 10 * BLOCK).every((sample) => sample === 0)); // it rests
  playback.obey({ playing: true });
  const heard = run(playback, 20 * BLOCK);
  heard.forEach((sample, i) => {
    const gain = Math.min(1, (i + 1) / RAMP);
    assert.ok(Math.abs(sample - gain * (1001 + i)) < 1e-2, `${sample} at ${i}`);
  });
  assert.equal(last().voice, 'input');
  assert.ok(last().at > 1000 + 18 * BLOCK && last().at <= 1000 + 20 * BLOCK);
});

test('a pause fades, and goes on where it was', () => {
  const { playback } = openPlayback();
  playback.obey({ voice: 'input' });
  playback.obey({ playing: true });
  run(playback, 10 * BLOCK);
  playback.obey({ playing: false });
  const fading = run(playback, 10 * BLOCK);
  assert.ok(fading[0] > 0.9 * 10 * BLOCK, 'cut off');
  const end = fading.findIndex((sample) => sample === 0);
  assert.ok(Math.abs(end - RAMP) <= 1, `${end} samples`);
  playback.obey({ playing: true });
  const again = run(playback, 10 * BLOCK);
  const at = again[again.length - 1] - again.length; // of its first sample
  assert.ok(at >= 10 * BLOCK + end && at <= 12 * BLOCK, `went on at ${at}`);
});

test('a leap lands exactly, and reports of before are told apart', () => {
  const { playback, reports } = openPlayback();
  playback.obey({ voice: 'input' });
  playback.obey({ playing: true });
  run(playback, 10 * BLOCK);
  playback.obey({ leap: 20000 });
  playback.obey({ leap: 10000 });
  const heard = run(playback, 20 * BLOCK);
  const first = heard.findIndex((sample) => sample > 5000);
  assert.ok(first > 0 && first < 3 * BLOCK + RAMP);
  const value = heard[heard.length - 1];
  assert.equal(reports[0].leaps, 0);
  const last = reports[reports.length - 1];
  assert.equal(last.leaps, 2);
  assert.ok(value > 10000 && value < 10000 + 20 * BLOCK + 1 && Math.abs(last.at - value) < 2 * BLOCK);
});

test('the end is reported, and the beginning follows', () => {
  const { playback, reports } = openPlayback();
  playback.obey({ voice: 'input' });
  playback.obey({ leap: SAMPLES - 1000 });
  playback.obey({ playing: true });
  const heard = run(playback, 20 * BLOCK);
  assert.equal(heard[999], SAMPLES);
  assert.equal(heard[1000], 1);
  assert.equal(reports.filter(({ ended }) => ended).length, 1);
});

test('the server takes over at the sample where its parts begin, with a fade', () => {
  const { playback, last } = openPlayback();
  playback.obey({ voice: 'input' });
  playback.obey({ playing: true });
  run(playback, 10 * BLOCK);
  playback.obey({ voice: null });
  for (let start = 1500; start < 6000; start += 500) playback.obey(partOf(start, 500));
  const heard = run(playback, 20 * BLOCK);
  heard.forEach((sample, i) => {
    const place = 10 * BLOCK + i + 1;
    const server = sample - place; // of the server: up to a million
    assert.ok(server > -1 && server < 1e6 + 1, `${sample} at ${i}`);
    if (place < 1500) assert.ok(server < 1);
    if (place > 1500 + BLOCK + FADE) assert.ok(server > 1e6 - 1, `${sample} at ${place}`);
  });
  assert.equal(last().voice, null);
  // Back again: the place is kept.
  playback.obey({ voice: 'input' });
  run(playback, 10 * BLOCK);
  assert.equal(run(playback, BLOCK)[0], 40 * BLOCK + 1);
});

test('parts that come too late are left out, and without parts it waits', () => {
  const { playback, last } = openPlayback();
  playback.obey({ playing: true });
  assert.ok(run(playback, 5 * BLOCK).every((sample) => sample === 0));
  playback.obey(partOf(0, 300));
  playback.obey(partOf(300, 300));
  const heard = run(playback, 10 * BLOCK);
  assert.equal(heard[599], 1e6 + 600);
  assert.ok(heard.subarray(600).every((sample) => sample === 0));
  assert.deepEqual([last().at, last().queued, last().parts], [600, 0, 2]);
  playback.obey(partOf(200, 300));
  playback.obey(partOf(500, 300));
  const more = run(playback, 10 * BLOCK);
  assert.equal(more.findIndex((sample) => sample > 0), 0);
  assert.equal(more[199], 1e6 + 800);
  assert.equal(last().at, 800);
});

test('the old voice does not sound forever if the new one does not come', () => {
  const { playback, last } = openPlayback();
  playback.obey({ voice: 'input' });
  playback.obey({ playing: true });
  run(playback, 10 * BLOCK);
  playback.obey({ voice: null });
  run(playback, 1.1 * RATE_HZ);
  const { at } = last();
  playback.obey(partOf(at, 5000));
  const heard = run(playback, 5 * BLOCK);
  assert.ok(heard[heard.length - 1] > 1e6);
  assert.equal(last().voice, null);
});

test('a stream is warmed up by half a second, fed ahead, and heard without its latency', () => {
  const latency = 700;
  let fed = [];
  let sinceReset = 0;
  const stream = {
    latency,
    reset: () => {
      fed = [];
      sinceReset = 0;
    },
    process: (input, output) => {
      fed.push(...input[0]);
      for (let i = 0; i < input[0].length; ++i) {
        output[0][i] = fed[sinceReset - latency] ?? 0;
        output[1][i] = -output[0][i];
        ++sinceReset;
      }
    },
  };
  const voice = new EngineVoice(stream, clip, RATE_HZ);
  voice.start(9000);
  let rounds = 1;
  while (!voice.prepare(9000, 1000)) ++rounds;
  assert.equal(rounds, Math.ceil((RATE_HZ / 2 + latency) / 1000));
  assert.equal(sinceReset, RATE_HZ / 2 + latency);
  assert.equal(fed[0], 9001 - RATE_HZ / 2);
  const ears = [new Float32Array(BLOCK), new Float32Array(BLOCK)];
  assert.equal(voice.fill(9000, ears), BLOCK);
  assert.deepEqual([...ears[0].subarray(0, 3)], [9001, 9002, 9003]);
  // Once more from the beginning: before it there is silence.
  while (!voice.prepare(0, 1e6));
  voice.fill(0, ears);
  assert.deepEqual([fed[0], ears[0][0], ears[1][1]], [0, 1, -2]);
});

test('levels are matched as the server matches them', () => {
  const match = new LevelMatch(RATE_HZ);
  const sound = (level) => [0, 1].map(() => new Float32Array(BLOCK).fill(level));
  const hear = (blocks) => {
    let ears;
    for (let i = 0; i < blocks; ++i) {
      ears = sound(0.02);
      match.apply(sound(0.1), ears);
    }
    return ears[0][BLOCK - 1];
  };
  assert.ok(Math.abs(hear(50) - 0.02) < 1e-6);
  match.matches = true;
  assert.ok(Math.abs(hear(50) - 0.1) < 1e-3);
  match.matches = false;
  assert.ok(Math.abs(hear(50) - 0.02) < 1e-6);
});
