// The panel that tunes a flight: what tune.json says may be changed, sent by the page's WebSocket, and the answers.
import { get, queryOf } from './source.js';

const interval = 200; // between two messages [ms]; the server takes 20 a second
const make = (tag, properties = {}, ...children) => {
  const element = Object.assign(document.createElement(tag), properties);
  element.append(...children);
  return element;
};
const rounded = (v) => Number(v.toPrecision(6));

// The numbers that a slider spans: the part's bounds where it has them, else as far as four times what it is.
export function span({ value, low, high }) {
  const far = Math.max(1, 4 * Math.abs(value));
  return [low ?? -far, high ?? far];
}

export class Tune {
  // on: {send(text) -> whether it was, changed(tunables)}
  constructor(element, on) {
    this.element = element;
    this.on = on;
    this.waiting = new Map(); // what is to be sent, the newest of each thing
    this.requests = 0;
    this.own = new Map(); // id -> what it was about
    this.spans = new Map(); // of each slider, as it was at first
    this.heard = -1;
    this.me = Math.random().toString(36).slice(2, 8);
    this.scene = null;
    setInterval(() => this.sendNext(), interval);
  }

  // Another flight, or the same one seen again.
  async begin(scene) {
    this.scene = scene;
    this.heard = -1;
    this.waiting.clear();
    this.spans.clear();
    this.element.replaceChildren();
    this.element.hidden = true;
    if (!scene.live) return;
    await this.load();
  }

  async load() {
    const scene = this.scene;
    const tunables = await get('tune.json').catch(() => ({ tune: false }));
    if (scene !== this.scene) return;
    this.tunables = tunables;
    this.element.hidden = !tunables.tune;
    if (!tunables.tune) return;
    this.on.changed(tunables);
    if (this.element.contains(document.activeElement)) return; // not under the hand
    const open = new Set([...this.element.querySelectorAll('details[open]')].map((one) => one.dataset.key));
    const first = this.element.childElementCount === 0;
    this.build();
    if (!first) for (const one of this.element.querySelectorAll('details')) one.open = open.has(one.dataset.key);
  }

  request(key, message) {
    this.waiting.set(key, message);
  }

  sendNext() {
    const [next] = this.waiting;
    if (next === undefined) return;
    const id = `${this.me}-${this.requests++}`;
    if (!this.on.send(JSON.stringify({ id, ...next[1] }))) return;
    this.waiting.delete(next[0]);
    this.own.set(id, next[0]);
    if (this.own.size > 100) this.own.delete(this.own.keys().next().value);
  }

  hear(moment) {
    if (moment.paused !== undefined && this.pause) this.pause.textContent = moment.paused ? 'Fly on' : 'Pause flight';
    if (this.step) this.step.disabled = !moment.paused;
    this.paused = moment.paused;
    let news = false;
    for (const [number, id, accepted, sentence] of moment.answers ?? []) {
      if (number <= this.heard) continue;
      this.heard = number;
      news = true;
      const own = this.own.has(id);
      if (this.answer && (own || accepted)) {
        this.answer.textContent = accepted ? sentence : `refused: ${sentence}`;
        this.answer.className = accepted ? '' : 'bad';
      }
    }
    if (!news) return;
    clearTimeout(this.reload);
    this.reload = setTimeout(() => this.load(), 300);
  }

  // A row of a slider and its number.
  slider(key, words, entry, title, change) {
    if (!this.spans.has(key)) this.spans.set(key, span(entry));
    const [low, high] = this.spans.get(key), step = 'any';
    const range = make('input', { type: 'range', min: low, max: high, step, value: entry.value, title });
    const number = make('input', { type: 'number', step, value: rounded(entry.value), title });
    range.setAttribute('aria-label', words);
    number.setAttribute('aria-label', `${words}, number`);
    range.oninput = () => { number.value = rounded(Number(range.value)); change(rounded(Number(range.value))); };
    number.onchange = () => {
      const v = Number(number.value);
      if (v > Number(range.max)) range.max = v;
      if (v < Number(range.min)) range.min = v;
      range.value = v;
      change(v);
    };
    // Arrows move a slider by a hundredth of what it spans.
    range.onkeydown = (event) => {
      const way = { ArrowLeft: -1, ArrowDown: -1, ArrowRight: 1, ArrowUp: 1 }[event.key];
      if (way === undefined) return;
      event.preventDefault();
      range.value = Number(range.value) + (way * (range.max - range.min)) / 100;
      range.oninput();
    };
    return make('div', { className: 'row' }, make('span', { textContent: words, title }), range, number);
  }

  // Three numbers of a place.
  place(words, p, change) {
    const inputs = p.map((v, k) => {
      const input = make('input', { type: 'number', step: '0.1', value: rounded(v) });
      input.setAttribute('aria-label', `${words} ${'xyz'[k]}`);
      input.onchange = () => change(inputs.map((one) => Number(one.value)));
      return input;
    });
    return make('div', { className: 'row' }, make('span', { textContent: words }), ...inputs);
  }

  group(key, title, rows, open) {
    const details = make('details', { open }, make('summary', { textContent: title }), ...rows);
    details.dataset.key = key;
    return details;
  }

  retune(term, what) {
    this.request(`${term.kind} ${term.name} ${Object.keys(what)[0]}`, { event: { retune: { [term.kind]: term.name, ...what } } });
  }

  termRows(term) {
    const weight = { value: term.weight, low: 0, high: null };
    const rows = [this.slider(`${term.kind} ${term.name}`, 'weight', weight, '>= 0', (v) => this.retune(term, { weight: v }))];
    for (const p of term.parameters) {
      const about = `${p.meaning}; ${p.range} ${p.unit}`;
      rows.push(this.slider(`${term.kind} ${term.name} ${p.key}`, p.unit ? `${p.key} [${p.unit}]` : p.key, p, about, (v) => {
        p.value = v;
        const all = Object.fromEntries(term.parameters.map((one) => [one.key, one.value]));
        this.retune(term, { potential: { [term.potential]: all } });
      }));
    }
    return rows;
  }

  // The reference of a robot with its goal somewhere else.
  moveGoal(reference, p) {
    const value = structuredClone(reference.value);
    if (reference.kind === 'constant') value.p = p;
    else if (reference.kind === 'circle') value.centre = p;
    else reference.places.forEach((place, k) => { value[place] = p[k]; });
    reference.value = value;
    reference.goal = p;
    this.request(`reference ${reference.agent}`, { event: { reference: { agent: reference.agent, reference: { [reference.kind]: value } } } });
  }

  moveBody(body, p) {
    this.request(`move ${body.name}`, { event: { move: { [body.kind]: body.name, p } } });
  }

  referenceRows(reference) {
    const rows = reference.goal ? [this.place('goal [m]', reference.goal, (p) => this.moveGoal(reference, p))] : [];
    for (const p of reference.parameters) {
      rows.push(this.slider(`reference ${reference.agent} ${p.key}`, p.unit ? `${p.key} [${p.unit}]` : p.key, p, `${p.meaning}; ${p.range}`, (v) => {
        reference.value = { ...reference.value, [p.key]: v };
        this.request(`reference ${reference.agent}`, { event: { reference: { agent: reference.agent, reference: { [reference.kind]: reference.value } } } });
      }));
    }
    return rows;
  }

  buttons() {
    const { can_pause: canPause, can_restart: canRestart } = this.tunables, row = make('div', { className: 'row buttons' });
    const button = (words, act) => make('button', { type: 'button', textContent: words, onclick: act });
    if (canPause) {
      this.pause = button(this.paused ? 'Fly on' : 'Pause flight', () => this.request('pause', { pause: !this.paused }));
      this.step = button('Step', () => this.request('step', { step: 1 }));
      this.step.disabled = !this.paused;
      row.append(this.pause, this.step);
    }
    if (canRestart) {
      const seed = make('input', { type: 'number', min: 0, step: 1, value: 2 });
      seed.setAttribute('aria-label', 'Seed');
      row.append(make('label', {}, 'Seed ', seed), button('Begin anew', () => this.request('seed', { seed: Math.trunc(Number(seed.value)) })));
    }
    return row;
  }

  write() {
    const link = (words, file, title) => make('a', { href: `${file}${queryOf()}`, download: `${this.scene.name}_${file}`, textContent: words, title });
    const links = [link('whole flight', 'tuned.toml', 'The scenario with each change at its time: flown again, the same commands')];
    if (this.tunables.no_final) links.push(make('span', { className: 'faint', textContent: 'no final values', title: this.tunables.no_final }));
    else links.push(link('final values', 'final.toml', 'The scenario with the values that were tuned last'));
    return make('div', { className: 'row write' }, make('span', { textContent: 'Write' }), ...links);
  }

  faults() {
    const { faults } = this.tunables, option = (text) => make('option', { textContent: text });
    const kind = make('select', {}, ...faults.map(option)), body = make('select', {}, ...this.scene.bodies.map((one) => option(one.name)));
    const lasts = make('input', { type: 'number', min: 0, step: 0.1, value: 0.5 });
    kind.setAttribute('aria-label', 'Fault');
    body.setAttribute('aria-label', 'Body');
    lasts.setAttribute('aria-label', 'Seconds');
    const begin = make('button', { type: 'button', textContent: 'Inject', onclick: () => {
      const fault = { kind: kind.value, body: body.value, for: Number(lasts.value) };
      if (fault.kind === 'jump') fault.offset = [0.5, 0, 0];
      this.request('fault', { event: { fault } });
    } });
    return make('div', { className: 'row' }, kind, body, lasts, make('span', { textContent: 's' }), begin);
  }

  build() {
    const { terms, references, bodies, wind, faults } = this.tunables, few = terms.length <= 4;
    this.answer = make('output', { className: this.answer?.className ?? '', textContent: this.answer?.textContent ?? '' });
    this.answer.setAttribute('role', 'status');
    const groups = terms.map((term, i) => this.group(`term ${i}`, `${term.potential ?? 'potential'} ${term.agents.join(' › ')}`, this.termRows(term), few && i === 0));
    for (const reference of references) {
      const rows = this.referenceRows(reference);
      if (rows.length > 0) groups.push(this.group(`reference ${reference.agent}`, `reference ${reference.agent}: ${reference.kind}`, rows, false));
    }
    if (bodies.length > 0) {
      groups.push(this.group('bodies', 'targets and obstacles', bodies.map((body) => {
        const i = this.scene.bodies.findIndex((one) => one.name === body.name), seen = this.seen?.b[i] ?? [0, 0, 0];
        return this.place(`${body.name} [m]`, seen.slice(0, 3), (p) => this.moveBody(body, p));
      }), false));
    }
    if (wind) { // of a simulated world alone
      const blow = [...wind];
      groups.push(this.group('wind', 'wind', blow.map((v, k) => this.slider(`wind ${k}`, `${'xyz'[k]} [m/s²]`, { value: v, low: -2, high: 2 }, 'acceleration of all robots', (to) => {
        blow[k] = to;
        this.request('wind', { event: { wind: { acceleration: [...blow] } } });
      })), false));
    }
    if (faults.length > 0) groups.push(this.group('faults', 'faults of measurements', [this.faults()], false));
    this.element.replaceChildren(make('h2', { textContent: 'Tune' }), this.buttons(), this.write(), this.answer, ...groups);
  }
}
