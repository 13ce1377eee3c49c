// The figures of a report page: SVG from the JSON in each <figure>, with zoom, readings at the pointer and legends that hide curves.
import { readCurves, readPlane } from './readings.js';
import { drawSpace } from './space.js';
import { curvePath, element, ends, grey, shade, strokes, svg, words } from './svg.js';
import { linearTicks, logTicks } from './ticks.js';

const wide = 900, top = 8, axis = 46, bare = 10; // [px]
const tickWidth = 75, tickHeight = 32; // least distance of two ticks [px]
const upright = { turn: 35, tilt: 58 }; // view of a surface [deg]

// A scale from [low, high] to [0, size], and back.
function scaleOf([low, high], size, apart, log) {
  const measure = log ? Math.log10 : (v) => v, from = measure(low), span = measure(high) - from || 1;
  return { low, high, to: (v) => (size * (measure(v) - from)) / span, from: (at) => (log ? 10 ** (from + (at / size) * span) : from + (at / size) * span),
    ticks: () => (log ? logTicks : linearTicks)(low, high, Math.max(2, Math.floor(size / apart))) };
}

class Panel {
  constructor(spec, columns) {
    Object.assign(this, { spec, top, hidden: new Set(), zoomed: null, ...upright });
    const map = spec.grid?.view === 'map', share = wide / columns;
    this.left = columns === 1 ? 102 : 72;
    this.width = (columns === 1 ? 780 : share - 90) - (map ? 92 : 0);
    this.space = spec.grid && !map;
    this.plane = spec.equal || map; // zooms by areas with the scales of both axes kept
    this.height = spec.height;
    this.svg = svg('svg', { viewBox: `0 0 ${share} ${top + this.height + (spec.x ? axis : bare)}`, 'font-family': 'sans-serif', 'font-size': 13, fill: 'currentColor', overflow: 'visible', role: 'img' });
    this.tip = element('div', { className: 'tip', hidden: true });
    this.element = element('div', { className: 'panel' });
    if (spec.title) this.element.append(element('p', { className: 'soft', textContent: spec.title }));
    const named = spec.curves.filter(({ label }) => label);
    if (named.length > 0) this.element.append(element('div', { className: 'legend' }, ...named.map((curve) => this.key(curve))));
    this.element.append(element('div', { className: 'axes' }, this.svg, this.tip));
    this.svg.addEventListener('pointerdown', (event) => this.press(event));
    this.svg.addEventListener('pointermove', (event) => this.move(event));
    this.svg.addEventListener('pointerup', () => this.release());
    this.svg.addEventListener('pointerleave', () => this.show(null));
    this.svg.addEventListener('dblclick', () => this.zoom(null));
    this.linked = [this];
  }

  key(curve) {
    const button = element('button', { type: 'button', title: 'Show or hide' }, svg('svg', { viewBox: '0 0 26 8' }, svg('path',
      { d: curve.mark === 'points' ? 'M13 4h0' : 'M1 4h24', stroke: curve.colour, ...strokes[curve.mark] })), curve.label);
    button.onclick = () => {
      if (!this.hidden.delete(curve)) this.hidden.add(curve);
      button.setAttribute('aria-pressed', String(!this.hidden.has(curve)));
      this.draw();
    };
    return button;
  }

  get curves() { return this.spec.curves.filter((curve) => !this.hidden.has(curve)); }

  // Ends of both axes: of the data with a margin; of a logarithmic y at most the upper six decades.
  ranges() {
    const { spec, width, height } = this, [logX, logY] = spec.log, of = (key) => ends(spec.curves.flatMap((curve) => curve[key].filter((_, i) => curve.y[i] !== null)));
    if (this.plane && this.zoomed) return this.zoomed;
    if (spec.grid) return [ends(spec.grid.x), ends(spec.grid.y)];
    let x = of('x');
    if (spec.equal) {
      const y = of('y'), middle = [x, y].map(([low, high]) => (low + high) / 2);
      const scale = 0.54 * Math.max((x[1] - x[0]) / width, (y[1] - y[0]) / height, 1e-6 * (1 + Math.abs(middle[0]) + Math.abs(middle[1])));
      return [width, height].map((size, i) => [middle[i] - scale * size, middle[i] + scale * size]);
    }
    if (logX) x = [x[0] / 1.05, x[1] * 1.05];
    else {
      const [first, last] = spec.xRange ?? x;
      x = [first, last + (last > first ? 0.003 * (last - first) : Math.max(1e-3, 1e-3 * Math.abs(first)))]; // shows the last tick
    }
    if (this.zoomed) [x] = this.zoomed;
    // Of a curve that crosses the shown part, the points beside it count too.
    let [low, high] = ends(this.curves.flatMap((curve) => curve.y.filter((_, i) => (curve.x[i + 1] ?? curve.x[i]) >= x[0] && (curve.x[i - 1] ?? curve.x[i]) <= x[1])));
    if (!(low <= high)) [low, high] = logY ? [0.1, 1] : [0, 1];
    const size = Math.max(Math.abs(low), Math.abs(high)), air = high > low ? Math.max(0.07 * (high - low), 1e-6 * size, 1e-9) : Math.max(1e-3, 0.07 * size);
    return [x, spec.yRange ?? (logY ? [Math.max(low, 1e-6 * high) / 1.3, 1.6 * high] : [logX ? 0 : low - air, high + air])];
  }

  draw() {
    if (this.space) return this.svg.replaceChildren(...drawSpace(this));
    const { spec, left, width, height } = this, [x, y] = this.ranges();
    this.x = scaleOf(x, width, tickWidth, spec.log[0]);
    this.y = scaleOf(y, height, tickHeight, spec.log[1]);
    const down = (v) => height - this.y.to(v), lines = [], labels = [];
    for (const [v, text] of this.x.ticks()) {
      const at = left + this.x.to(v);
      lines.push(`M${at.toFixed(1)} ${top}v${height}`);
      if (spec.x) labels.push(words(at, top + height + 17, text, { 'text-anchor': 'middle' }));
    }
    for (const [v, text] of spec.names.length > 0 ? spec.names.map((name, i) => [i, name]) : this.y.ticks()) {
      const at = top + down(v);
      if (at < top - 1 || at > top + height + 1) continue;
      lines.push(`M${left} ${at.toFixed(1)}h${width}`);
      labels.push(words(left - 7, at + 4.5, text, { 'text-anchor': 'end' }));
    }
    if (spec.x) labels.push(words(left + width / 2, top + height + 38, spec.x, { 'text-anchor': 'middle' }));
    labels.push(words(-(top + height / 2), left - 62, spec.y, { transform: 'rotate(-90)', 'text-anchor': 'middle' }));
    const inside = svg('svg', { x: left, y: top, width, height, 'stroke-linejoin': 'round' });
    if (spec.grid) inside.append(this.picture());
    for (const moment of spec.moments) {
      const at = this.x.to(moment.x).toFixed(1);
      inside.append(svg('path', { d: `M${at} 0v${height}`, stroke: grey, 'stroke-dasharray': '2 4' }));
      if (moment.text) inside.append(words(Number(at) + 2, 11, moment.text, { 'font-size': 10 }));
    }
    for (const curve of this.curves) inside.append(curvePath(curve, this.x.to, down));
    for (const note of spec.notes) inside.append(words(this.x.to(note.x) + 4, down(note.y) - 4, note.text, { 'font-size': 10 }));
    this.hover = inside.appendChild(svg('g', { class: 'hover' }));
    this.svg.replaceChildren(...(spec.grid ? this.shadeBar() : []), svg('path', { d: lines.join(''), stroke: grey, 'stroke-width': 0.5, opacity: 0.7 }), inside,
      svg('rect', { x: left, y: top, width, height, fill: 'none', stroke: 'currentColor', 'stroke-width': 0.8 }), ...labels);
  }

  // The field as a picture of its values.
  picture() {
    const { across, z } = this.spec.grid, rows = z.length / across, [low, high] = ends(z), canvas = element('canvas', { width: across, height: rows });
    const context = canvas.getContext('2d');
    z.forEach((v, i) => {
      context.fillStyle = v === null ? 'transparent' : shade((v - low) / (high - low || 1));
      context.fillRect(i % across, rows - 1 - Math.floor(i / across), 1, 1);
    });
    const [x, y] = ['x', 'y'].map((key) => ends(this.spec.grid[key]).map(this[key].to));
    return svg('image', { x: x[0], y: this.height - y[1], width: x[1] - x[0], height: y[1] - y[0], href: canvas.toDataURL(), preserveAspectRatio: 'none', style: 'image-rendering: pixelated' });
  }

  shadeBar() {
    const [low, high] = ends(this.spec.grid.z), at = this.left + this.width + 14, steps = 40, scale = scaleOf([low, high > low ? high : low + 1], this.height, tickHeight);
    return [...Array.from({ length: steps }, (_, i) => svg('rect', { x: at, y: top + (this.height * i) / steps, width: 16, height: this.height / steps + 0.5, fill: shade(1 - (i + 0.5) / steps) })),
      ...scale.ticks().map(([v, text]) => words(at + 21, top + this.height - scale.to(v) + 4.5, text, { 'font-size': 11 })),
      words(-(top + this.height / 2), at + 68, this.spec.grid.label, { transform: 'rotate(-90)', 'text-anchor': 'middle' })];
  }

  // Where the pointer is within the axes [px].
  at({ clientX, clientY }) {
    const box = this.svg.getBoundingClientRect(), scale = box.width / this.svg.viewBox.baseVal.width;
    return [(clientX - box.left) / scale - this.left, (clientY - box.top) / scale - top];
  }
  press(event) {
    const [x, y] = this.at(event);
    if (event.button !== 0 || (!this.space && (x < 0 || y < 0 || x > this.width || y > this.height))) return;
    event.preventDefault();
    this.svg.setPointerCapture(event.pointerId);
    this.start = [x, y, this.turn, this.tilt];
  }
  move(event) {
    const [x, y] = this.at(event);
    if (this.start && this.space) {
      this.turn = this.start[2] + 0.5 * (x - this.start[0]);
      this.tilt = Math.min(88, Math.max(5, this.start[3] - 0.5 * (y - this.start[1])));
      this.draw();
      return;
    }
    if (this.space) return;
    this.show(x >= 0 && y >= 0 && x <= this.width && y <= this.height ? [x, y] : null);
    if (this.start) {
      const [from, tall] = this.plane ? [Math.min(this.start[1], y), Math.abs(y - this.start[1])] : [0, this.height];
      this.area = [Math.min(this.start[0], x), from, Math.abs(x - this.start[0]), tall];
      this.hover.append(svg('rect', { x: this.area[0], y: this.area[1], width: this.area[2], height: this.area[3], fill: grey, opacity: 0.3 }));
    }
  }
  release() {
    const { area } = this;
    this.start = this.area = null;
    if (!area || Math.max(area[2], this.plane ? area[3] : 0) < 5) return;
    const [x, y, w, h] = area, x0 = this.x.from(x), x1 = this.x.from(x + w);
    if (!this.plane) return this.zoom([[x0, x1]]);
    const part = Math.max(w / this.width, h / this.height) / 2, middle = [(x0 + x1) / 2, this.y.from(this.height - y - h / 2)];
    return this.zoom([this.x, this.y].map(({ low, high }, i) => [middle[i] - part * (high - low), middle[i] + part * (high - low)]));
  }
  zoom(to) {
    for (const panel of this.linked) {
      Object.assign(panel, { zoomed: to, ...(!to && upright) });
      panel.draw();
    }
  }

  // The readings at a place of this panel, and of those that share its x axis.
  show(place) {
    for (const panel of this.linked) panel.read(place);
  }
  read(place) {
    this.tip.hidden = true;
    this.hover?.replaceChildren();
    if (!place) return;
    const [px] = place, { rows, dots } = (this.plane ? readPlane : readCurves)(this, place), share = this.svg.viewBox.baseVal.width, right = px > this.width / 2;
    if (!this.plane) this.hover.append(svg('path', { d: `M${px} 0v${this.height}`, stroke: 'currentColor', 'stroke-width': 0.7 }));
    this.hover.append(...dots.map(([x, y, fill]) => svg('circle', { cx: this.x.to(x), cy: this.height - this.y.to(y), r: 3.5, fill })));
    this.tip.replaceChildren(...rows.map(([colour, text]) => element('div', {}, element('i', { style: `background:${colour}` }), text)));
    Object.assign(this.tip.style, { left: right ? '' : `${(100 * (this.left + px + 12)) / share}%`, right: right ? `${(100 * (share - this.left - px + 12)) / share}%` : '' });
    this.tip.hidden = false;
  }
}

for (const data of document.querySelectorAll('figure > script[type="application/json"]')) {
  const { columns, panels: specs } = JSON.parse(data.textContent), panels = specs.map((spec) => new Panel(spec, columns));
  panels.forEach((panel, i) => { panel.shared = panel.spec.x || specs.slice(i).find(({ x }) => x)?.x; });
  for (const panel of panels.filter(({ plane, space }) => !plane && !space)) panel.linked = panels.filter((other) => other.shared === panel.shared && !other.plane && !other.space);
  data.after(element('div', { className: 'panels', style: `grid-template-columns: repeat(${columns}, minmax(0, 1fr))` }, ...panels.map((panel) => panel.element)));
  for (const panel of panels) panel.draw();
}
document.querySelector('figure .panels')?.closest('figure').previousElementSibling.before(element('p', { className: 'soft hint',
  textContent: 'Drag to zoom or to turn, double-click to see all; point at a curve to read it; click a name to hide it.' }));
