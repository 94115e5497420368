// Measures the time from a drag until its sound begins to change, and the load, for each method: rendered by the server, and by
// the page's engine where the program has one.
// Usage: node web/measure.mjs EARPOINT_SERVE_ARGUMENT...    One JSON object a line.
import { dragTo, openBrowser, openPage, settle, startProgram, until } from './test/harness.mjs';

const DRAGS = 20;
const browser = await openBrowser();
const program = await startProgram('serve', ...process.argv.slice(2), '--quiet');
const at = (sorted, share) => sorted[Math.min(sorted.length - 1, Math.floor(share * sorted.length))];

async function measure(engine, methods) {
  const { page } = await openPage(browser, program.address, { engine });
  await page.click('#play');
  await until(page, () => window.earpoint.player?.playing);
  for (const method of methods) {
    await page.click(`[data-method=${method}]`);
    await settle(page);
    const latencies_ms = [];
    for (let i = 0; i < DRAGS; ++i) {
      await page.evaluate(() => (window.earpoint.player.latency_s = undefined));
      await dragTo(page, 0.5, i % 2 ? 1 : -1);
      await until(page, () => window.earpoint.player.latency_s !== undefined);
      latencies_ms.push(1000 * (await page.evaluate(() => window.earpoint.player.latency_s)));
    }
    latencies_ms.sort((a, b) => a - b);
    const load = await page.evaluate(() => window.earpoint.player.load);
    console.log(JSON.stringify({
      method: engine === 'browser' ? `${method}, in the browser` : method, drags: DRAGS, median_ms: Math.round(at(latencies_ms, 0.5)), p95_ms: Math.round(at(latencies_ms, 0.95)),
      real_time_share: Number(load.toFixed(3)),
    }));
  }
  await page.close();
}

try {
  await measure('server', ['gtf', 'dsp', 'vigas']);
  const { has_engine } = await (await fetch(new URL('/api/clips', program.address))).json();
  if (has_engine) await measure('browser', ['gtf', 'dsp']);
} finally {
  await browser.close();
  await program.stop();
}
