// Curves over time, of what the moments tell: distances, view angles, inputs, solve time.
import uPlot from 'uplot';
import 'uplot/dist/uPlot.min.css';
import { colours, robotColour } from './palette.js';

const width = () => Math.max(240, document.getElementById('curves').clientWidth);
const height = 118, pointsMost = 900, degrees = 180 / Math.PI;

const pick = (moments, from, to) => {
  const step = Math.max(1, Math.ceil((to - from) / pointsMost)), rows = [];
  for (let k = from; k < to; k += step) rows.push(moments[k]);
  return rows;
};

export class Curves {
  constructor(element, seek) {
    this.element = element;
    this.seek = seek;
    this.window = 20; // [s]; of a log, all of it
  }

  build(scene) {
    for (const one of this.plots ?? []) one.plot.destroy();
    this.element.replaceChildren();
    this.scene = scene;
    const pairName = (pair) => `${scene.bodies[pair.observer].name} › ${scene.bodies[pair.target].name}`;
    const pairs = scene.pairs.slice(0, 6);
    const agents = scene.bodies.map((body, i) => ({ body, i })).filter(({ body }) => body.agent);
    const plots = [];
    if (pairs.length > 0) {
      plots.push({ title: 'Distance [m]', limits: pairs.flatMap((p) => [p.d_min, p.d_max]),
        series: pairs.map((pair, k) => ({ label: pairName(pair), stroke: robotColour(k), value: (m) => m.p[k]?.[1] ?? null })) });
      plots.push({ title: 'View angle [deg]', limits: pairs.map((p) => (p.alpha === null ? null : p.alpha * degrees)),
        series: pairs.map((pair, k) => ({ label: pairName(pair), stroke: robotColour(k), value: (m) => (m.p[k] === null ? null : m.p[k][2] * degrees) })) });
    }
    for (const [k, { body }] of agents.slice(0, 4).entries()) {
      plots.push({ title: `Inputs of ${body.name}`, limits: [Math.min(...body.u_min), Math.max(...body.u_max)],
        series: body.inputs.map((input, j) => ({ label: input, stroke: robotColour(j), value: (m) => m.u[k]?.[j] ?? null })) });
    }
    plots.push({ title: 'Solve time [µs]', limits: [], series: [{ label: 'update', stroke: robotColour(0), value: (m) => m.us }] });
    this.plots = plots.map((spec) => this.makePlot(spec));
  }

  makePlot(spec) {
    const c = colours(), title = document.createElement('h2'), place = document.createElement('div');
    title.textContent = spec.title;
    this.element.append(title, place);
    const axis = { stroke: c.text, grid: { stroke: c.edge, width: 1 }, ticks: { stroke: c.edge }, font: '11px system-ui' };
    const limits = [...new Set(spec.limits.filter((v) => v !== null && Number.isFinite(v) && Math.abs(v) < 1e6))];
    const plot = new uPlot({
      width: width(), height, legend: { live: false, show: spec.series.length > 1 },
      scales: { x: { time: false } },
      axes: [{ ...axis, size: 30, gap: 2 }, { ...axis, size: 44 }],
      series: [{ label: 't' }, ...spec.series.map(({ label, stroke }) => ({ label, stroke, width: 1.5, points: { show: false } })),
        ...limits.map((v) => ({ label: `limit ${v.toPrecision(3)}`, stroke: c.grey, width: 1, dash: [5, 4], points: { show: false } }))],
      cursor: { drag: { x: false, y: false }, bind: { click: (u) => () => { this.seek(u.posToVal(u.cursor.left, 'x')); return null; } } },
      hooks: { draw: [(u) => this.drawNow(u)] },
    }, [[], ...spec.series.map(() => []), ...limits.map(() => [])], place);
    for (const row of [...place.querySelectorAll('.u-series')].slice(spec.series.length)) row.hidden = true;
    return { spec, limits, plot };
  }

  drawNow(u) {
    if (this.now === undefined) return;
    const x = u.valToPos(this.now, 'x', true), { ctx } = u, { top, height: tall, left, width: wide } = u.bbox;
    if (x < left || x > left + wide) return;
    ctx.save();
    ctx.strokeStyle = colours().text;
    ctx.globalAlpha = 0.7;
    ctx.beginPath();
    ctx.moveTo(x, top);
    ctx.lineTo(x, top + tall);
    ctx.stroke();
    ctx.restore();
  }

  resize() {
    for (const { plot } of this.plots ?? []) plot.setSize({ width: width(), height });
  }

  draw(history, index, whole) {
    const moments = history.moments;
    if (moments.length === 0) return;
    this.now = moments[index].t;
    const end = whole ? history.end : Math.max(this.now, history.begin + this.window);
    const begin = whole ? history.begin : Math.max(history.begin, end - this.window);
    const rows = pick(moments, history.indexAt(begin), whole ? moments.length : index + 1);
    const times = rows.map((m) => m.t);
    for (const { spec, limits, plot } of this.plots) {
      plot.setData([times, ...spec.series.map(({ value }) => rows.map(value)), ...limits.map((v) => rows.map(() => v))], false);
      plot.batch(() => {
        plot.setScale('x', { min: begin, max: Math.max(end, begin + 0.1) });
        const known = spec.series.flatMap(({ value }) => rows.map(value)).filter((v) => v !== null).concat(limits);
        const low = Math.min(...known), high = Math.max(...known), room = Math.max(0.05 * (high - low), 1e-3);
        if (known.length > 0) plot.setScale('y', { min: low - room, max: high + room });
      });
    }
  }
}
