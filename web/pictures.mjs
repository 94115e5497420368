// Takes pictures of the page: on a desktop, in dark mode, on a phone.
// Usage: node web/pictures.mjs FOLDER EARPOINT_SERVE_ARGUMENT...
import { join } from 'node:path';
import { dragTo, openBrowser, openPage, startProgram } from './test/harness.mjs';

const [folder, ...words] = process.argv.slice(2);
const browser = await openBrowser();
const program = await startProgram('serve', ...words, '--quiet');
try {
  for (const [name, viewport, colorScheme] of [
    ['page-desktop', { width: 1240, height: 1060 }, 'light'],
    ['page-dark', { width: 1240, height: 1060 }, 'dark'],
    ['page-phone', { width: 390, height: 844 }, 'light'],
  ]) {
    const { page } = await openPage(browser, program.address, {
      engine: null, viewport, colorScheme, deviceScaleFactor: 1,
    });
    await page.click('#play');
    await page.waitForTimeout(2000);
    await page.evaluate(() => window.earpoint.map.turn(-30));
    await dragTo(page, 1.1, 1.0);
    await page.waitForTimeout(8000);
    const isPhone = name === 'page-phone';
    await page.evaluate((top) => document.querySelector(top).scrollIntoView(), isPhone ? '.map' : 'header');
    await page.screenshot({ path: join(folder, `${name}.jpg`), type: 'jpeg', quality: 85 });
    await page.close();
  }
} finally {
  await browser.close();
  await program.stop();
}
