// The panel of a campaign's bounds: certificate.json, and what this flight shows of each event, over all moments that are known.
import { get } from './source.js';

const lostAfter = 0.5; // [s]
const rounding = 2e-3; // of distances: positions are sent in millimetres [m]
const make = (tag, words, kind = '') => Object.assign(document.createElement(tag), { textContent: words, className: kind });
const probability = (p) => (p === 0 ? '0' : p.toPrecision(2));

// Longest times out of view, least distances and landings of a flight, from its moments.
export class FlightFigures {
  constructor(scene, viewWithin) {
    this.scene = scene;
    this.viewWithin = viewWithin;
    this.views = scene.pairs.map(() => ({ since: null, seen: false, lost: null }));
    this.outOfView = null; // longest [s]; null: no view was required
    this.margin = null; // least distance beyond the hard one [m]; null: none was required
    this.distance = null; // that distance [m]
    this.landed = new Set(); // names
  }

  add({ t, p, b, levels }) {
    this.views.forEach((view, k) => {
      if (!p[k]) Object.assign(view, { since: null, seen: false, lost: null });
      else {
        view.since ??= t;
        if (p[k][0]) Object.assign(view, { seen: true, lost: null });
        else view.lost ??= t;
        // As in a campaign, a target that is not seen in time counts from then on. What is between two moments that are
        // known does not count.
        const begin = !view.seen ? view.since + this.viewWithin : view.lost === null ? t : view.lost - this.scene.period;
        if (t >= begin) this.outOfView = Math.max(this.outOfView ?? 0, t - begin);
      }
    });
    const { bodies } = this.scene;
    for (let i = 0; i < bodies.length && bodies[i].agent; ++i) {
      if (!b[i]) continue;
      if (levels?.[i] === 'land' || levels?.[i] === 'grounded') this.landed.add(bodies[i].name);
      for (let j = i + 1; j < bodies.length; ++j) {
        if (!b[j] || !(bodies[j].hard > 0)) continue;
        const distance = Math.hypot(b[i][0] - b[j][0], b[i][1] - b[j][1], b[i][2] - b[j][2]), margin = distance - bodies[j].hard;
        if (this.margin === null || margin < this.margin) [this.margin, this.distance] = [margin, distance];
      }
    }
  }

  // Of an event of the certificate: [words, whether it occurred]; null: the flight has no such figure.
  of(event) {
    if (event.startsWith('view lost') && this.outOfView !== null) return [`longest ${this.outOfView.toFixed(2)} s`, this.outOfView > (Math.round(lostAfter / this.scene.period) + 0.5) * this.scene.period];
    if (event.startsWith('distance') && this.margin !== null) return [`least ${this.distance.toFixed(2)} m, ${Math.abs(this.margin).toFixed(2)} m ${this.margin < 0 ? 'below' : 'above'}`, this.margin < -rounding];
    if (event.startsWith('landed')) return [[...this.landed].join(', ') || 'none', this.landed.size > 0];
    return null;
  }
}

export class Certificate {
  constructor(element) {
    this.element = element;
  }

  async begin(scene, history) {
    this.scene = scene;
    this.figures = null;
    this.element.hidden = true;
    const certificate = await get('certificate.json').catch(() => null);
    if (certificate === null || scene !== this.scene || certificate.scenario !== scene.name) return; // another run in the folder
    this.events = certificate.events;
    const table = document.createElement('table'), head = table.createTHead().insertRow();
    head.append(make('th', `Bounds, ${100 * certificate.confidence} %`), make('th', 'probability'), make('th', 'this flight, at the moments shown'), make('th', ''));
    this.cells = this.events.map((event) => {
      const row = table.insertRow(), { independent, importance_sampling: rare } = event;
      row.insertCell().textContent = event.event;
      const bound = row.insertCell();
      bound.append(make('div', `≤ ${probability(independent.high)}: ${independent.seen} of ${independent.runs} runs`));
      if (rare) bound.append(make('div', rare.seen === 0 ? `rare: not seen in ${rare.runs} runs` : `rare: ${probability(rare.probability)}, ≤ ${probability(rare.high)}`));
      return [row.insertCell(), row.insertCell()];
    });
    const premises = document.createElement('details'), list = document.createElement('ul');
    list.append(...certificate.premises.map((premise) => make('li', premise)));
    premises.append(make('summary', 'Premises'), list);
    this.element.replaceChildren(table, premises);
    this.element.hidden = false;
    this.figures = new FlightFigures(scene, certificate.view_within);
    history.moments.forEach((moment) => this.figures.add(moment)); // that came meanwhile
  }

  add(moment) {
    this.figures?.add(moment);
  }

  draw() {
    if (this.figures === null) return;
    this.events.forEach(({ event }, i) => {
      const [words, occurred] = this.figures.of(event) ?? ['not judged', null];
      const judged = occurred === null ? ['', ''] : occurred ? ['outside', 'bad'] : ['inside', 'good'];
      [[words, ''], judged].forEach(([text, kind], k) => {
        const cell = this.cells[i][k];
        if (cell.textContent !== text) cell.textContent = text;
        if (cell.className !== kind) cell.className = kind;
      });
    });
  }
}
