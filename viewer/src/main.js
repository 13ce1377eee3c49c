import './page.css';
import { Curves } from './curves.js';
import { History } from './history.js';
import { chooseTheme, colours, robotColour, systemTheme, theme } from './palette.js';
import { Source } from './source.js';
import { Stage } from './stage.js';

const $ = (id) => document.getElementById(id);
const links = { connecting: ['connecting', ''], live: ['live', 'good'], lost: ['connection lost, trying again', 'bad'],
  log: ['finished log', 'good'], refused: ['token missing: open the address as it was printed', 'bad'] };
const bad = /conflict|refused|land|missed|late|dropped|deadline|not_finite|ignored|search/;

chooseTheme(systemTheme());
const stage = new Stage($('stage'), $('labels'));
const curves = new Curves($('curves'), (t) => seek(t));
let history = null, playing = true, now = 0, following = true, marked = -1, marksEnd = 0, drawn = -1, drawnCurves = 0;
const counters = { frames: 0, moments: 0, link: 'connecting' };
window.sightline = counters; // for tests: how often it drew, what it has

const isLog = () => history !== null && !history.scene.live;

function setLink(state) {
  counters.link = state;
  const [words, kind] = links[state];
  $('link').textContent = words;
  $('link').className = kind;
}

function start(scene) {
  history = new History(scene);
  now = 0;
  playing = true;
  following = scene.live;
  marked = -1;
  drawn = -1;
  document.title = `${scene.name} · sightline`;
  $('name').textContent = scene.name;
  $('newest').hidden = !scene.live;
  $('speed').hidden = scene.live;
  build();
  const camera = $('camera');
  camera.replaceChildren(new Option('orbit', 'orbit'));
  scene.bodies.forEach((body, i) => { if (body.agent) camera.append(new Option(`follow ${body.name}`, `body ${i}`)); });
  scene.pairs.forEach((pair, i) => camera.append(new Option(`sensor of ${scene.bodies[pair.observer].name}`, `pair ${i}`)));
}

function build() {
  stage.build(history.scene);
  curves.build(history.scene);
  const c = colours(), legend = [['in view', c.good, ''], ['out of view', c.bad, 'dashed'], ['predicted', c.grey, 'dashed']];
  $('legend').replaceChildren(...legend.map(([words, colour, kind]) => {
    const item = document.createElement('li'), mark = document.createElement('i');
    mark.className = kind;
    mark.style.borderColor = colour;
    item.append(mark, words);
    return item;
  }));
  drawn = -1;
}

function take(moments) {
  if (history.moments.length === 0 && moments.length > 0) stage.frame(moments[0]);
  for (const moment of moments) history.add(moment);
  counters.moments = history.moments.length;
}

function seek(t) {
  following = false;
  now = Math.min(history.end, Math.max(history.begin, t));
  if (history.scene.live) playing = false;
}

function cell(row, words, kind = '') {
  const one = row.insertCell();
  one.textContent = words;
  one.className = kind;
  return one;
}

function table(heads, rows) {
  const made = document.createElement('table'), head = made.createTHead().insertRow();
  for (const [words, kind] of heads) {
    const one = document.createElement('th');
    one.textContent = words;
    one.className = kind;
    head.append(one);
  }
  const body = made.createTBody();
  rows.forEach((fill) => fill(body.insertRow()));
  return made;
}

function drawStatuses(moment) {
  const { bodies, pairs } = history.scene;
  let agent = -1;
  const robots = table([['Robot', ''], ['level', ''], ['barrier', ''], ['z [m]', 'number'], ['|u| / limit', 'number']],
    bodies.flatMap((body, i) => {
      if (!body.agent) return [];
      agent += 1;
      const u = moment.u[agent] ?? [], acts = moment.barrier?.[agent];
      const share = Math.max(...u.map((v, j) => Math.abs(v) / Math.max(Math.abs(body.u_min[j]), Math.abs(body.u_max[j]))));
      const level = moment.b[i] === null ? 'not there' : moment.levels?.[i] ?? '';
      return [(row) => {
        const name = cell(row, body.name), swatch = document.createElement('span');
        swatch.className = 'swatch';
        swatch.style.background = robotColour(i);
        name.prepend(swatch);
        cell(row, level, level === '' || level === 'valid' ? '' : 'bad');
        cell(row, acts === undefined ? '' : acts ? 'active' : 'idle', acts ? 'bad' : '');
        cell(row, moment.b[i]?.[2].toFixed(2) ?? '', 'number');
        cell(row, Number.isFinite(share) ? `${(100 * share).toFixed(0)} %` : '', 'number');
      }];
    }));
  const views = table([['View', ''], ['', ''], ['distance', 'number'], ['angle', 'number']], pairs.map((pair, i) => (row) => {
    const told = moment.p[i];
    cell(row, `${bodies[pair.observer].name} › ${bodies[pair.target].name}`);
    if (told === null) return cell(row, 'not asked for');
    cell(row, told[0] ? '● in view' : '○ out of view', told[0] ? 'good' : 'bad');
    cell(row, `${told[1].toFixed(2)} m`, 'number');
    cell(row, told[2] === null ? '' : `${((180 / Math.PI) * told[2]).toFixed(1)}°`, 'number');
  }));
  const solver = table([['Solver', ''], ['status', ''], ['residual', 'number'], ['steps', 'number'], ['time', 'number']], [(row) => {
    cell(row, history.scene.solver);
    cell(row, moment.status, /converged|stepped/.test(moment.status) ? 'good' : 'bad');
    cell(row, moment.residual === null ? '' : moment.residual.toExponential(1), 'number');
    cell(row, moment.it, 'number');
    cell(row, moment.us === null ? '' : `${moment.us.toFixed(0)} µs`, 'number');
  }]);
  $('statuses').replaceChildren(robots, ...(pairs.length > 0 ? [views] : []), solver);
}

function drawMarks() {
  const { events, begin, end } = history, last = events.at(-1)?.[0] ?? -1;
  if (marked === last && (isLog() || end - marksEnd < 1)) return;
  marked = last;
  marksEnd = end;
  $('marks').replaceChildren(...events.slice(-300).map(([, t, words]) => {
    const mark = document.createElement('button');
    mark.type = 'button';
    mark.title = `${t.toFixed(2)} s: ${words}`;
    mark.tabIndex = -1;
    if (bad.test(words)) mark.className = 'bad';
    mark.style.left = `${(100 * (t - begin)) / Math.max(end - begin, 1e-6)}%`;
    mark.onclick = () => seek(t);
    return mark;
  }));
}

let before = performance.now();
function frame(wall) {
  requestAnimationFrame(frame);
  const passed = Math.min(0.25, (wall - before) / 1000);
  before = wall;
  counters.frames += 1;
  if (history === null || history.moments.length === 0) return;
  if (isLog() && playing) {
    now = Math.min(history.end, Math.max(history.begin, now) + passed * Number($('speed').value));
    if (now >= history.end) playing = false;
  } else if (following) {
    now = history.end;
  }
  const index = history.indexAt(now), moment = history.moments[index];
  counters.t = moment.t;
  stage.draw(history, index);
  const label = playing && (isLog() || following) ? 'Pause' : 'Play';
  if ($('play').textContent !== label) $('play').textContent = label;
  if (index === drawn && wall - drawnCurves < 1000) return;
  $('clock').textContent = `${moment.t.toFixed(2)} s`;
  const time = $('time');
  time.min = history.begin;
  time.max = history.end;
  if (document.activeElement !== time || playing) time.value = moment.t;
  if (wall - drawnCurves < 100) return;
  drawnCurves = wall;
  drawn = index;
  drawMarks();
  drawStatuses(moment);
  curves.draw(history, index, isLog());
  const event = history.events.findLast(([, t]) => t <= moment.t + 1e-6);
  $('event').textContent = event ? `${event[1].toFixed(2)} s  ${event[2]}` : '';
}

function togglePlay() {
  if (isLog()) {
    if (!playing && now >= history.end) now = history.begin;
    playing = !playing;
  } else {
    following = !following;
    playing = following;
  }
}

function toNewest() {
  now = history.end;
  following = history.scene.live;
  playing = following;
}

function toggleTheme() {
  chooseTheme(theme() === 'dark' ? 'light' : 'dark');
  if (history) build();
}

$('play').onclick = togglePlay;
$('newest').onclick = toNewest;
$('theme').onclick = toggleTheme;
$('time').oninput = (event) => { seek(Number(event.target.value)); playing = false; };
$('camera').onchange = (event) => {
  const [kind, number] = event.target.value.split(' ');
  const pair = history.scene.pairs[Number(number)];
  stage.follow(kind === 'orbit' ? null : kind === 'pair' ? { body: pair.observer, sensor: pair } : { body: Number(number) });
};
addEventListener('keydown', (event) => {
  if (history === null || /INPUT|SELECT|BUTTON/.test(event.target.tagName)) return;
  const step = event.shiftKey ? 1 : 0.1;
  if (event.key === ' ') togglePlay();
  else if (event.key === 'ArrowLeft') { seek(now - step); playing = false; }
  else if (event.key === 'ArrowRight') { seek(now + step); playing = false; }
  else if (event.key === 'Home') seek(history.begin);
  else if (event.key === 'End') toNewest();
  else if (event.key === 'd') toggleTheme();
  else return;
  event.preventDefault();
});
matchMedia('(prefers-color-scheme: dark)').addEventListener('change', () => { chooseTheme(systemTheme()); if (history) build(); });
addEventListener('resize', () => curves.resize());
new Source({ scene: start, moments: take, link: setLink });
requestAnimationFrame(frame);
