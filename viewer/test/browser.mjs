// Looks at a page in Chromium:  node browser.mjs URL [PICTURES]
// Prints what it found as JSON: the link's state, moments, frames a second, how many colours are on the canvas, faults of the page.
// Lines on stdin are steps: "settle", "shot NAME", "dark", "theme", "camera VALUE", "time T", "wait STATE", "quit"; an answer a line.
import { createInterface } from 'node:readline';
import { chromium } from 'playwright-core';

const [url, pictures] = process.argv.slice(2);
const browser = await chromium.launch({
  executablePath: process.env.CHROMIUM ?? '/usr/bin/chromium',
  args: ['--no-sandbox', '--disable-gpu', '--use-angle=swiftshader', '--enable-unsafe-swiftshader', '--disable-background-networking',
    '--disable-component-update', '--disable-sync', '--disable-quic', '--no-first-run'],
});
const faults = [];
try {
  const page = await browser.newPage({ viewport: { width: 1280, height: 720 } });
  page.on('pageerror', (error) => faults.push(error.message));
  page.on('console', (message) => {
    // A connection that is refused while the server is away is what the test is about.
    if (message.type() === 'error' && !/ERR_CONNECTION|favicon|WebSocket/.test(message.text() + message.location().url)) faults.push(message.text());
  });
  await page.goto(url);

  const look = async () => {
    const told = await page.evaluate(async () => {
      const before = { frames: window.sightline.frames, at: performance.now() };
      await new Promise((done) => setTimeout(done, 1000));
      const canvas = document.querySelector('#stage canvas'), small = document.createElement('canvas');
      small.width = 160;
      small.height = 90;
      const context = small.getContext('2d');
      context.drawImage(canvas, 0, 0, 160, 90);
      const bytes = context.getImageData(0, 0, 160, 90).data, found = new Set();
      for (let i = 0; i < bytes.length; i += 4) found.add((bytes[i] >> 4) * 256 + (bytes[i + 1] >> 4) * 16 + (bytes[i + 2] >> 4));
      return { ...window.sightline, fps: (1000 * (window.sightline.frames - before.frames)) / (performance.now() - before.at),
        colours: found.size, curves: document.querySelectorAll('#curves canvas').length, marks: document.querySelectorAll('#marks button').length,
        statuses: document.getElementById('statuses').innerText, overflow: document.documentElement.scrollWidth > innerWidth };
    });
    return { ...told, faults };
  };
  const steps = {
    look,
    shot: async (name) => page.screenshot({ path: `${pictures}/${name}.png` }).then(() => ({})),
    theme: async () => page.click('#theme').then(() => ({})),
    camera: async (...words) => page.selectOption('#camera', words.join(' ')).then(() => ({})),
    time: async (t) => page.evaluate((to) => { const time = document.getElementById('time'); time.value = to; time.dispatchEvent(new Event('input')); }, t).then(() => ({})),
    play: async () => page.click('#play').then(() => ({})),
    wait: async (state) => page.waitForFunction((s) => window.sightline.link === s, state, { timeout: 20000 }).then(() => ({ link: state })),
    moments: async (count) => page.waitForFunction((n) => window.sightline.moments >= n, Number(count), { timeout: 20000 }).then(() => ({})),
  };
  for await (const line of createInterface({ input: process.stdin })) {
    const [step, ...words] = line.trim().split(' ');
    if (step === 'quit') break;
    console.log(JSON.stringify(await steps[step](...words)));
  }
} finally {
  await browser.close();
}
