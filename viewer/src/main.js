import './page.css';
import { Certificate } from './certificate.js';
import { Curves } from './curves.js';
import { Drag } from './drag.js';
import { History } from './history.js';
import { chooseTheme, colours, systemTheme, theme } from './palette.js';
import { Source } from './source.js';
import { Stage } from './stage.js';
import { Statuses } from './statuses.js';
import { Timeline } from './timeline.js';
import { Tune } from './tune.js';
import { Wind } from './wind.js';

const $ = (id) => document.getElementById(id);
const links = { connecting: ['connecting', ''], live: ['live', 'good'], lost: ['connection lost, trying again', 'bad'],
  growing: ['log, still written', 'good'], finished: ['finished log', 'good'], broken: ['log without an end: the run was killed', 'bad'],
  refused: ['token missing: open the address as it was printed', 'bad'] };
const redrawnAfter = 250, tablesEvery = 100; // [ms]

chooseTheme(systemTheme());
const stage = new Stage($('stage'), $('labels'));
const curves = new Curves($('curves'), (t) => seek(t));
const statuses = new Statuses($('statuses'));
const certificate = new Certificate($('certificate'));
const timeline = new Timeline($('marks'), $('bands'), (t) => seek(t));
const wind = new Wind($('wind'));
const tune = new Tune($('tune'), { send: (text) => source.send(text), changed: retune }), drag = new Drag(stage, tune);
let history = null, playing = true, now = 0, following = true, drawn = -1, drawnAt = 0, drawnTables = 0, growing = false;
const counters = { turns: 0, frames: 0, news: 0, moments: 0, link: 'connecting' };
window.sightline = counters; // for tests: how often it could draw, how often it did, how many messages it received, what it has
Object.defineProperty(counters, 'redraw', { value: () => stage.draw(history, history.indexAt(now)) }); // its canvas holds a picture until the task ends
counters.handles = () => drag.places();

const isLog = () => history !== null && !history.scene.live;

function setLink(state, why) {
  counters.link = state;
  growing = state === 'growing' || (growing && state === 'lost');
  const [words, kind] = why ? [why, 'bad'] : links[state];
  $('link').textContent = words;
  $('link').className = kind;
  if (history) $('newest').hidden = !history.scene.live && !growing;
}

function start(scene) {
  history = new History(scene);
  now = 0;
  playing = true;
  following = scene.live;
  drawn = -1;
  document.title = `${scene.name} · sightline`;
  $('name').textContent = scene.name;
  $('newest').hidden = !scene.live;
  $('speed').hidden = scene.live;
  stage.follow(null);
  curves.robot = -1;
  build();
  const camera = $('camera');
  camera.replaceChildren(new Option('orbit', 'orbit'));
  scene.bodies.forEach((body, i) => { if (body.agent) camera.append(new Option(`follow ${body.name}`, `body ${i}`)); });
  scene.pairs.forEach((pair, i) => camera.append(new Option(`sensor of ${scene.bodies[pair.observer].name} at ${scene.bodies[pair.target].name}`, `pair ${i}`)));
  $('robot').replaceChildren(new Option('first robots', '-1'));
  scene.bodies.forEach((body, i) => { if (body.agent) $('robot').append(new Option(body.name, String(i))); });
  tune.begin(scene);
  certificate.begin(scene, history);
  $('undrawn').replaceChildren(...scene.undrawn.map((words) => {
    const item = document.createElement('li');
    item.textContent = words;
    return item;
  }));
}

function build() {
  const { scene } = history, c = colours();
  stage.build(scene);
  curves.build(scene);
  statuses.build(scene);
  timeline.forget();
  wind.build(scene.wind);
  drag.build(scene, tune.tunables);
  const legend = [['in view', c.good, ''], ['out of view', c.bad, 'dashed'], ['predicted', c.grey, 'dashed']];
  if (scene.bodies.some((body) => body.localized)) legend.push(['estimate, 3 sigma', c.grey, 'filled']);
  $('legend').replaceChildren(...legend.map(([words, colour, kind]) => {
    const item = document.createElement('li'), mark = document.createElement('i');
    mark.className = kind;
    mark.style.borderColor = colour;
    item.append(mark, words);
    return item;
  }));
  drawn = -1;
}

// What may be tuned is another: goals, and cones by their angles.
function retune(tunables) {
  let cones = false;
  for (const pair of history.scene.pairs) {
    const names = [history.scene.bodies[pair.observer].name, history.scene.bodies[pair.target].name];
    const alpha = tunables.terms.find((term) => term.alpha !== null && term.agents.join() === names.join())?.alpha;
    if (alpha === undefined || alpha === pair.alpha) continue;
    pair.alpha = alpha;
    cones = true;
  }
  if (cones) build();
  else drag.build(history.scene, tunables);
}

function take(moments) {
  if (history.moments.length === 0 && moments.length > 0) stage.frame(moments[0]);
  for (const moment of moments) {
    if (history.add(moment)) certificate.add(moment);
    if (history.scene.live) tune.hear(moment);
  }
  tune.seen = moments.at(-1);
  counters.news += 1;
  counters.moments = history.moments.length;
}

function seek(t) {
  following = false;
  now = Math.min(history.end, Math.max(history.begin, t));
  if (history.scene.live) playing = false;
}

let before = performance.now();
function frame(wall) {
  requestAnimationFrame(frame);
  counters.turns += 1;
  const turn = wall - before, passed = Math.min(0.25, turn / 1000);
  before = wall;
  if (history === null || history.moments.length === 0) return;
  if (isLog() && playing) {
    now = Math.min(history.end, Math.max(history.begin, now) + passed * Number($('speed').value));
    if (now >= history.end && !growing) playing = false;
  }
  if (following) now = history.end;
  const index = history.indexAt(now), moment = history.moments[index];
  counters.t = moment.t;
  stage.pace(turn, index === drawn && !stage.changed);
  // A picture that would be the same is not drawn again, but for now and then.
  if (index !== drawn || stage.changed || wall - drawnAt > redrawnAfter) {
    drawnAt = wall;
    counters.frames += 1;
    stage.draw(history, index);
    wind.draw(stage.camera);
  }
  const label = playing && (isLog() || following) ? 'Pause' : 'Play';
  if ($('play').textContent !== label) $('play').textContent = label;
  drawn = index;
  if (wall - drawnTables < tablesEvery) return;
  drawnTables = wall;
  $('clock').textContent = `${moment.t.toFixed(2)} s`;
  const time = $('time');
  time.min = history.begin;
  time.max = history.end;
  if (document.activeElement !== time || playing) time.value = moment.t;
  timeline.draw(history);
  statuses.draw(moment);
  certificate.draw();
  curves.draw(history, index, isLog());
  const event = history.events.findLast(([, t]) => t <= moment.t + 1e-6);
  $('event').textContent = event ? `${event[1].toFixed(2)} s  ${event[2]}` : '';
}

function togglePlay() {
  if (isLog()) {
    if (!playing && now >= history.end && !growing) now = history.begin;
    playing = !playing;
    following = false;
  } else {
    following = !following;
    playing = following;
  }
}

function toNewest() {
  now = history.end;
  following = history.scene.live || growing;
  playing = following;
}

// The event before the present time, or the one after it.
function toEvent(step) {
  const others = history.events.filter(([, t]) => (step < 0 ? t < now - 0.02 : t > now + 0.02));
  const event = step < 0 ? others.at(-1) : others[0];
  if (event) seek(event[1]);
}

function choose(select, step) {
  const { length } = select.options;
  select.selectedIndex = (select.selectedIndex + step + length) % length;
  select.dispatchEvent(new Event('change'));
}

function faster(step) {
  const speed = $('speed');
  speed.selectedIndex = Math.min(speed.options.length - 1, Math.max(0, speed.selectedIndex + step));
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
  stage.follow(kind === 'orbit' ? null : kind === 'pair' ? { body: pair.observer, sensor: { ...pair.mount, alpha: pair.alpha } } : { body: Number(number) });
};
$('robot').onchange = (event) => { curves.robot = Number(event.target.value); curves.build(history.scene); };
$('window').onchange = (event) => { curves.window = Number(event.target.value); };
$('help').onclick = () => { $('keys').hidden = !$('keys').hidden; };
// Whether a key means something to what has the focus.
function takesKey({ tagName, type }, key) {
  if (tagName === 'BUTTON') return key === ' ' || key === 'Enter';
  if (tagName === 'INPUT' && type === 'range') return /^(Arrow|Page|Home|End)/.test(key);
  return /INPUT|SELECT|TEXTAREA/.test(tagName);
}

addEventListener('keydown', (event) => {
  if (history === null || event.ctrlKey || event.metaKey || event.altKey || takesKey(event.target, event.key)) return;
  const step = event.shiftKey ? 1 : 0.1;
  if (event.key === ' ') togglePlay();
  else if (event.key === 'ArrowLeft') { seek(now - step); playing = false; }
  else if (event.key === 'ArrowRight') { seek(now + step); playing = false; }
  else if (event.key === 'Home') seek(history.begin);
  else if (event.key === 'End') toNewest();
  else if (event.key === 'd') toggleTheme();
  else if (event.key === 'c') choose($('camera'), 1);
  else if (event.key === 'C') choose($('camera'), -1);
  else if (event.key === 'r') choose($('robot'), 1);
  else if (event.key === 'p') toEvent(-1);
  else if (event.key === 'n') toEvent(1);
  else if (event.key === '+') faster(1);
  else if (event.key === '-') faster(-1);
  else if (event.key === '?') $('help').click();
  else return;
  event.preventDefault();
});
matchMedia('(prefers-color-scheme: dark)').addEventListener('change', () => { chooseTheme(systemTheme()); if (history) build(); });
const source = new Source({ scene: start, moments: take, link: setLink });
requestAnimationFrame(frame);
