// The listening study's page in a real browser, on a small study of synthetic sounds.
import assert from 'node:assert/strict';
import { createHash } from 'node:crypto';
import { mkdirSync, mkdtempSync, readFileSync, rmSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { after, before, test } from 'node:test';
import { SOURCE_DIR, openBrowser, runProgram, startProgram, until } from './harness.mjs';

const RATE = 16000;
const METHODS = ['input', 'dsp', 'gtf'];

/** A WAV file of 16 bits. */
function wav(samples) {
  const bytes = Buffer.alloc(44 + 4 * samples.length);
  bytes.write('RIFF', 0);
  bytes.writeUInt32LE(36 + 4 * samples.length, 4);
  bytes.write('WAVEfmt ', 8);
  [16, RATE, 4 * RATE].forEach((value, i) => bytes.writeUInt32LE(value, [16, 24, 28][i]));
  [1, 2, 4, 16].forEach((value, i) => bytes.writeUInt16LE(value, [20, 22, 32, 34][i]));
  bytes.write('data', 36);
  bytes.writeUInt32LE(4 * samples.length, 40);
  samples.forEach((pair, i) => pair.forEach((value, ear) => bytes.writeInt16LE(Math.round(32767 * value), 44 + 4 * i + 2 * ear)));
  return bytes;
}

/** A short tone with different ears, so that all files differ. */
function tone(frequency_hz, left, right) {
  return wav(Array.from({ length: 0.3 * RATE }, (_, i) => {
    const value = 0.3 * Math.sin((2 * Math.PI * frequency_hz * i) / RATE);
    return [left * value, right * value];
  }));
}

/** Writes a study of that many clips. @returns what each file is, by its hash */
function writeStudy(folder, design, count) {
  const known = new Map();
  const put = (name, bytes, what) => {
    mkdirSync(join(folder, name, '..'), { recursive: true });
    writeFileSync(join(folder, name), bytes);
    known.set(createHash('sha256').update(bytes).digest('hex'), what);
    return name;
  };
  const picture = readFileSync(`${SOURCE_DIR}/web/test/study-picture.png`);
  const clip = (id, pitch) => ({
    id, pair: `pair ${id}`, scene: 'home', control: false,
    picture: put(`clips/${id}/picture.png`, picture, 'picture'),
    reference: put(`clips/${id}/reference.wav`, tone(pitch, 0.9, 0.3), 'reference'),
    sounds: METHODS.concat(design === 'mushra' ? ['truth', 'mono', 'swapped'] : []).map((condition, m) => ({
      condition, file: put(`clips/${id}/${condition}.wav`, tone(pitch, 0.8 - 0.1 * m, 0.3), condition), gain_db: 0, mag: 0,
    })),
  });
  const study = {
    format: 'earpoint-study-1', design, title: 'A study', data: 'synthetic', split: 'test', pairs: 'none', seed: 1,
    duration_s: 0.3, loudness: 'matched',
    methods: METHODS.map((name) => ({ name, what: name, baseline: name !== 'gtf' })),
    clips: Array.from({ length: count }, (_, i) => clip(`0${i}`, 300 + 50 * i)),
    training: clip('training', 900),
    headphones: Array.from({ length: 6 }, (_, i) => (
      { file: put(`headphones/${i}.wav`, tone(200 + i, 1, 1), i % 3), quietest: i % 3 })),
  };
  writeFileSync(join(folder, 'study.json'), JSON.stringify(study));
  return known;
}

/** A participant at the page who knows which sound is which. */
class Visitor {
  constructor(page, known) {
    this.page = page;
    this.known = known;
    this.served = new Map(); // by address
    this.hosts = new Set();
    this.problems = [];
    page.on('request', (request) => {
      if (request.url().startsWith('http')) this.hosts.add(new URL(request.url()).hostname);
    });
    page.on('pageerror', (error) => this.problems.push(error.message));
  }

  async heading() {
    return this.page.textContent('#page h2');
  }
  async question() {
    return this.page.textContent('#progress-text');
  }

  /** Which sound the page plays under a name. */
  async soundAt(step, name) {
    const participant = await this.page.evaluate(() => localStorage.getItem('earpoint-study-participant'));
    const path = `/api/participants/${participant}/steps/${step}/sounds/${name}`;
    const bytes = await this.page.evaluate(async (address) => [...new Uint8Array(await (await fetch(address)).arrayBuffer())], path);
    return this.known.get(createHash('sha256').update(Buffer.from(bytes)).digest('hex'));
  }

  /** Plays everything on the page to its end. */
  async listen() {
    await until(this.page, () => document.querySelectorAll('.play').length > 0);
    for (const button of await this.page.locator('.play').all()) {
      await until(this.page, () => !document.querySelector('.playing'));
      await button.click();
      await until(this.page, (text) => [...document.querySelectorAll('.play.heard')].some((b) => b.textContent === text),
        await button.textContent());
    }
  }

  async next(step) {
    const before = await this.question();
    await until(this.page, () => !document.getElementById('next').disabled);
    await this.page.click('#next');
    if (step !== undefined) await until(this.page, (old) => document.getElementById('progress-text').textContent !== old, before);
  }

  async passHeadphones() {
    for (let step = 0; step < 6; ++step) {
      await this.listen();
      await this.page.locator('input[name=tone]').nth(await this.soundAt(step, '0')).check();
      await this.next(step);
    }
  }

  async choose(step, condition) {
    await this.listen();
    for (let place = 0; place < METHODS.length; ++place) {
      if (await this.soundAt(step, String(place)) === condition) await this.page.locator('input[name=closest]').nth(place).check();
    }
  }
}

let browser;
let folder;
let program;
let known;

async function visit(options = {}) {
  const context = await browser.newContext({ viewport: { width: 900, height: 1000 }, ...options });
  const page = await context.newPage();
  const visitor = new Visitor(page, known);
  await page.goto(program.address);
  return visitor;
}

/** Serves a study until the test has ended. */
async function serve(context, design, count) {
  folder = mkdtempSync(join(tmpdir(), 'earpoint-study-'));
  known = writeStudy(folder, design, count);
  program = await startProgram('study', 'serve', folder);
  context.after(async () => {
    await program.stop();
    rmSync(folder, { recursive: true, force: true });
  });
}

before(async () => { browser = await openBrowser(); });
after(async () => { await browser?.close(); });

test('a participant goes through the forced choice, back, through a reload and a second tab', async (context) => {
  await serve(context, 'choice', 3);
  const visitor = await visit();
  const { page } = visitor;
  await page.fill('#label', 'somebody');
  await page.click('#start');
  await until(page, () => document.getElementById('progress-text').textContent === 'Headphone check 1');
  assert.equal(await page.isDisabled('#next'), true);
  await visitor.passHeadphones();
  assert.match(await visitor.question(), /Practice/);
  await visitor.choose(6, 'dsp');
  await visitor.next(6);
  assert.equal(await visitor.question(), 'Question 1 of 3');
  await visitor.choose(7, 'input');
  await visitor.next(7);

  // Back, another answer, and on.
  await page.click('#back');
  await until(page, () => document.getElementById('progress-text').textContent === 'Question 1 of 3');
  assert.equal(await page.locator('input[name=closest]:checked').count(), 1);
  await visitor.choose(7, 'gtf');
  await visitor.next(7);

  // A reload goes on at the same question.
  assert.equal(await visitor.question(), 'Question 2 of 3');
  await page.reload();
  await until(page, () => document.getElementById('progress-text').textContent === 'Question 2 of 3');

  // The same question in a second tab: the later answer is refused, and the tab goes to the next question.
  const other = new Visitor(await page.context().newPage(), known);
  await other.page.goto(program.address);
  await until(other.page, () => document.getElementById('progress-text').textContent === 'Question 2 of 3');
  await visitor.choose(8, 'gtf');
  await visitor.next(8);
  await other.choose(8, 'input');
  await other.page.click('#next');
  await until(other.page, () => document.getElementById('progress-text').textContent === 'Question 3 of 3');
  await until(other.page, () => document.getElementById('problem').textContent.includes('already'));
  await other.page.close();

  await visitor.choose(9, 'gtf');
  await visitor.next(9);
  await page.fill('#comment', 'fine');
  await page.click('#finish');
  await until(page, () => document.querySelector('#page h2').textContent === 'Thank you');
  assert.deepEqual([...visitor.hosts], ['127.0.0.1']);
  assert.deepEqual(visitor.problems, []);

  const report = JSON.parse(await runProgram('study', 'report', folder, '--json'));
  assert.equal(report.groups.length, 1);
  assert.equal(report.groups[0].name, 'people');
  const shares = report.groups[0].rows.map((row) => row.value.value);
  assert.deepEqual(shares, [0, 0, 1]);
  assert.equal(report.groups[0].participants[0].label, 'somebody');
  assert.equal(report.groups[0].participants[0].comment, 'fine');
});

test('a participant who misses the tones is asked to put headphones on', async (context) => {
  await serve(context, 'choice', 1);
  const { page } = await visit();
  const visitor = new Visitor(page, known);
  await page.click('#start');
  for (let step = 0; step < 6; ++step) {
    await visitor.listen();
    await page.locator('input[name=tone]').nth((await visitor.soundAt(step, '0') + 1) % 3).check();
    await visitor.next();
    if (step < 5) await until(page, (n) => document.getElementById('progress-text').textContent === `Headphone check ${n}`, step + 2);
  }
  await until(page, () => document.querySelector('#page h2').textContent.startsWith('The headphone check did not work'));
});

test('ratings are taken by sliders, and keys play sounds', async (context) => {
  await serve(context, 'mushra', 1);
  const visitor = await visit({ viewport: { width: 390, height: 844 }, colorScheme: 'dark' });
  const { page } = visitor;
  await page.click('#start');
  await until(page, () => document.getElementById('progress-text').textContent === 'Headphone check 1');
  await visitor.passHeadphones();
  for (let step = 6; step < 10; ++step) {
    await until(page, () => document.querySelectorAll('input[type=range]').length === 6);
    await visitor.listen();
    assert.equal(await page.isDisabled('#next'), true);
    await page.keyboard.press('r');
    await until(page, () => document.querySelector('.playing')?.textContent === 'Play reference');
    await page.keyboard.press('b');
    await until(page, () => document.querySelector('.playing')?.textContent === 'Play B');
    for (let place = 0; place < 6; ++place) {
      const rating = await visitor.soundAt(step, String(place)) === 'truth' ? 100 : 10 * place;
      await page.locator('input[type=range]').nth(place).fill(String(rating === 50 ? 51 : rating));
    }
    await visitor.next(step < 9 ? step : undefined);
  }
  await page.click('#finish');
  await until(page, () => document.querySelector('#page h2').textContent === 'Thank you');
  const overflow = await page.evaluate(() => document.documentElement.scrollWidth - window.innerWidth);
  assert.ok(overflow <= 0, `${overflow} pixels wider than a phone`);
  const report = JSON.parse(await runProgram('study', 'report', folder, '--json'));
  const truth = report.groups[0].rows.filter((row) => row.condition === 'truth').map((row) => row.value.value);
  assert.deepEqual(truth, [100, 100]);
});
