// Looks at a page in Chromium:  node browser.mjs URL [PICTURES]
// Prints what it found as JSON: the link's state, moments, frames a second, how many colours are on
// the canvas, faults of the page. Lines on stdin are steps, the names of `steps` with their words,
// and "quit"; an answer a line.
import { readdirSync, readFileSync } from 'node:fs';
import { createInterface } from 'node:readline';
import { chromium } from 'playwright-core';

const [url, pictures] = process.argv.slice(2);
const browser = await chromium.launch({
  executablePath: process.env.CHROMIUM ?? '/usr/bin/chromium',
  args: ['--no-sandbox', '--disable-gpu', '--use-angle=swiftshader', '--enable-unsafe-swiftshader', '--disable-background-networking',
    '--disable-component-update', '--disable-sync', '--disable-quic', '--no-first-run'],
});
// Processor time of the browser's processes by their type [s]: what a busy machine does not change.
const used = () => {
  const all = new Map();
  for (const pid of readdirSync('/proc').filter((name) => /^\d+$/.test(name))) {
    try {
      const rest = readFileSync(`/proc/${pid}/stat`, 'utf8').split(') ')[1].split(' ');
      all.set(Number(pid), { parent: Number(rest[1]), seconds: (Number(rest[11]) + Number(rest[12])) / 100, words: readFileSync(`/proc/${pid}/cmdline`, 'utf8') });
    } catch { /* it has just ended */ }
  }
  const ours = (pid) => pid === process.pid || (all.has(pid) && ours(all.get(pid).parent));
  const sums = {};
  for (const [pid, { seconds, words }] of all) {
    if (pid === process.pid || !ours(pid)) continue;
    const type = /--type=([a-z]+)/.exec(words)?.[1] ?? 'browser';
    sums[type] = (sums[type] ?? 0) + seconds;
  }
  return sums;
};
const faults = [];
try {
  const page = await browser.newPage({ viewport: { width: 1280, height: 720 } });
  page.on('pageerror', (error) => faults.push(error.message));
  page.on('console', (message) => {
    // A connection that is refused while the server is away is what the test is about.
    if (message.type() === 'error' && !/ERR_CONNECTION|favicon|WebSocket/.test(message.text() + message.location().url)) faults.push(message.text());
  });
  await page.goto(url);

  // Pictures a second that the stage drew, over so many seconds, and what is to be seen.
  const look = async (seconds = '1') => {
    const usedBefore = used();
    const told = await page.evaluate(async (wait) => {
      const before = { ...window.sightline, at: performance.now() };
      await new Promise((done) => setTimeout(done, 1000 * wait));
      const perSecond = (key) => (1000 * (window.sightline[key] - before[key])) / (performance.now() - before.at);
      // A picture for each message of a flight, and some of what stands still, as often as the
      // browser lets it.
      const fps = perSecond('frames'), due = Math.min(perSecond('turns'), Math.max(4, perSecond('news')));
      const canvas = document.querySelector('#stage canvas'), small = document.createElement('canvas');
      small.width = 160;
      small.height = 90;
      const context = small.getContext('2d');
      window.sightline.redraw?.();
      context.drawImage(canvas, 0, 0, 160, 90);
      const bytes = context.getImageData(0, 0, 160, 90).data, found = new Set();
      for (let i = 0; i < bytes.length; i += 4) found.add((bytes[i] >> 4) * 256 + (bytes[i + 1] >> 4) * 16 + (bytes[i + 2] >> 4));
      const weight = performance.getEntriesByType('resource').concat(performance.getEntriesByType('navigation'))
        .filter((one) => !/json/.test(one.name)).reduce((sum, one) => sum + one.decodedBodySize, 0);
      return { ...window.sightline, fps, due, weight, pixels: canvas.width / canvas.clientWidth / devicePixelRatio, colours: found.size, curves: document.querySelectorAll('#curves canvas').length,
        marks: document.querySelectorAll('#marks button').length, bands: document.querySelectorAll('#bands i').length,
        undrawn: [...document.querySelectorAll('#undrawn li')].map((item) => item.textContent), link: document.getElementById('link').textContent,
        state: window.sightline.link, statuses: document.getElementById('statuses').innerText, certificate: document.getElementById('certificate').innerText, overflow: document.documentElement.scrollWidth > innerWidth };
    }, Number(seconds));
    const perPicture = {};
    for (const [type, sum] of Object.entries(used())) perPicture[type] = Number(((1000 * (sum - (usedBefore[type] ?? 0))) / (told.fps * Number(seconds))).toFixed(1));
    return { ...told, faults, cpu_ms: perPicture };
  };
  const steps = {
    look,
    shot: async (name) => page.screenshot({ path: `${pictures}/${name}.png` }).then(() => ({})),
    size: async (width, height) => page.setViewportSize({ width: Number(width), height: Number(height) }).then(() => ({})),
    theme: async () => page.click('#theme').then(() => ({})),
    key: async (key) => page.keyboard.press(key).then(() => page.evaluate(() => ({ camera: document.getElementById('camera').value }))),
    camera: async (...words) => page.selectOption('#camera', words.join(' ')).then(() => ({})),
    robot: async (number) => page.selectOption('#robot', number).then(() => ({})),
    scroll: async (pixels) => page.evaluate((by) => { document.querySelector('aside').scrollTop = by; }, Number(pixels)).then(() => ({})),
    time: async (t) => page.evaluate((to) => { const time = document.getElementById('time'); time.value = to; time.dispatchEvent(new Event('input')); }, t).then(() => ({})),
    play: async () => page.click('#play').then(() => ({})),
    newest: async () => page.click('#newest').then(() => ({})),
    pause: async (seconds) => new Promise((done) => setTimeout(() => done({}), 1000 * Number(seconds))),
    // Pages that look on beside this one. They are of this browser, so they share its processor.
    pages: async (count) => {
      const others = await Promise.all(Array.from({ length: Number(count) }, () => browser.newPage({ viewport: { width: 320, height: 240 } })));
      await Promise.all(others.map((other) => other.goto(url, { waitUntil: 'commit' })));
      await Promise.all(others.map((other) => other.waitForFunction(() => window.sightline?.moments > 20, null, { timeout: 30000 })));
      const moments = await Promise.all(others.map((other) => other.evaluate(() => window.sightline.moments)));
      await Promise.all(others.map((other) => other.close()));
      return { moments };
    },
    wait: async (state) => page.waitForFunction((s) => window.sightline?.link === s, state, { timeout: 20000 }).then(() => ({ link: state })),
    slide: async (label, value) => page.evaluate(([of, to]) => {
      const range = [...document.querySelectorAll('#tune input[type=range]')].find((one) => one.ariaLabel === of);
      range.closest('details').open = true;
      range.value = to;
      range.dispatchEvent(new Event('input'));
      return { low: range.min, high: range.max };
    }, [label, value]),
    arrow: async (label, key) => {
      const range = page.locator(`#tune details[open] input[type=range][aria-label="${label}"]`).first();
      await range.focus();
      await range.press(key);
      return { value: await range.inputValue() };
    },
    press: async (...words) => page.click(`#tune button:text-is("${words.join(' ')}")`).then(() => ({})),
    drag: async (handle, dx, dy) => {
      const [x, y] = await page.evaluate((i) => window.sightline.handles()[i], Number(handle));
      await page.mouse.move(x, y);
      await page.mouse.down();
      await page.mouse.move(x + dx / 2, y + dy / 2);
      await page.mouse.move(x + Number(dx), y + Number(dy));
      await page.mouse.up();
      return {};
    },
    answer: async (...words) => page.waitForFunction((w) => document.querySelector('#tune output')?.textContent.includes(w), words.join(' '), { timeout: 20000 })
      .then(async () => ({ answer: await page.textContent('#tune output') })),
    // A report's figures: their titles, and the curves of each panel.
    figures: async () => page.evaluate(() => [...document.querySelectorAll('figure')].map((figure) => ({ title: figure.ariaLabel,
      panels: [...figure.querySelectorAll('.axes')].map((panel) => panel.querySelectorAll('svg svg > path[stroke^="#"]').length) })))
      .then((figures) => ({ figures, faults })),
    // The pointer in a panel, at parts of its width, with the button pressed on the way from the
    // first to the second.
    point: async (panel, from, to) => {
      const axes = page.locator('.axes').nth(Number(panel));
      await axes.scrollIntoViewIfNeeded();
      const { x, y, width, height } = await axes.boundingBox();
      await page.mouse.move(x + Number(from) * width, y + 0.3 * height);
      const readings = await page.locator('.tip:visible').allInnerTexts();
      if (to) {
        await page.mouse.down();
        await page.mouse.move(x + Number(to) * width, y + 0.4 * height);
        await page.mouse.up();
      }
      return { readings, ticks: await axes.locator('> svg > text').allTextContents() };
    },
    print: async () => page.emulateMedia({ media: 'print', colorScheme: 'dark' }).then(() => page.evaluate(() => ({
      paper: getComputedStyle(document.body).backgroundColor, cut: getComputedStyle(document.querySelector('figure')).breakInside }))),
    moments: async (count) => page.waitForFunction((n) => window.sightline?.moments >= n, Number(count), { timeout: 20000 }).then(() => ({})),
  };
  for await (const line of createInterface({ input: process.stdin })) {
    const [step, ...words] = line.trim().split(' ');
    if (step === 'quit') break;
    console.log(JSON.stringify(await steps[step](...words)));
  }
} finally {
  await browser.close();
}
