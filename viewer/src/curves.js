// Curves over time, of what the moments tell: distances, view angles, inputs, what the solver and the barrier do, errors of estimates.
import uPlot from 'uplot';
import 'uplot/dist/uPlot.min.css';
import { colours, robotColour } from './palette.js';

const width = () => Math.max(240, document.getElementById('curves').clientWidth);
const height = 118, pointsMost = 900, pairsMost = 6, robotsMost = 4, degrees = 180 / Math.PI, sigmas = 3, strip = 3;

const pick = (moments, from, to) => {
  const step = Math.max(1, Math.ceil((to - from) / pointsMost)), rows = [];
  for (let k = from; k < to; k += step) rows.push(moments[k]);
  return rows;
};

export class Curves {
  constructor(element, seek) {
    this.element = element;
    this.seek = seek;
    this.window = 0; // [s]; 0: as it is best, of a log all of it, of a flight the last 20 s
    this.robot = -1; // body whose curves are shown; -1: of the first ones
    this.shown = new Set();
    this.looks = new IntersectionObserver((all) => {
      for (const { target, isIntersecting } of all) {
        if (isIntersecting) this.shown.add(target); else this.shown.delete(target);
      }
      this.drawn = '';
    });
  }

  build(scene) {
    for (const one of this.plots ?? []) one.plot.destroy();
    this.looks.disconnect();
    this.shown.clear();
    this.drawn = '';
    this.element.replaceChildren();
    this.plots = this.chosen(scene).map((spec) => this.makePlot(spec));
  }

  chosen(scene) {
    const pairName = (pair) => `${scene.bodies[pair.observer].name} › ${scene.bodies[pair.target].name}`;
    const is = (i) => this.robot < 0 || this.robot === i;
    const pairs = scene.pairs.map((pair, i) => ({ pair, i })).filter(({ pair }) => is(pair.observer) || is(pair.target)).slice(0, pairsMost);
    const all = scene.bodies.map((body, i) => ({ body, i })).filter(({ body }) => body.agent).map((one, k) => ({ ...one, k }));
    const agents = all.filter(({ i }) => is(i)).slice(0, robotsMost);
    const plots = [];
    if (pairs.length > 0) {
      plots.push({ title: 'Distance [m]', limits: pairs.flatMap(({ pair }) => [pair.d_min, pair.d_max]),
        series: pairs.map(({ pair, i }, k) => ({ label: pairName(pair), stroke: robotColour(k), value: (m) => m.p[i]?.[1] ?? null })) });
      plots.push({ title: 'View angle [deg]', limits: pairs.map(({ pair }) => (pair.alpha === null ? null : pair.alpha * degrees)),
        series: pairs.map(({ pair, i }, k) => ({ label: pairName(pair), stroke: robotColour(k), value: (m) => ((m.p[i]?.[2] ?? null) === null ? null : m.p[i][2] * degrees) })) });
    }
    for (const { body, i, k } of agents.filter(({ body: one }) => one.localized)) {
      plots.push({ title: `Error of the estimate of ${body.name} [m]`, limits: [],
        series: [{ label: 'error', stroke: robotColour(i), value: (m) => m.e?.[k]?.[9] ?? null },
          { label: '3 sigma', stroke: colours().grey, dash: [5, 4], value: (m) => ((m.e?.[k]?.[10] ?? null) === null ? null : sigmas * m.e[k][10]) }] });
    }
    for (const { body, k } of agents) {
      plots.push({ title: `Inputs of ${body.name}`, limits: [Math.min(...body.u_min), Math.max(...body.u_max)],
        series: body.inputs.map((input, j) => ({ label: input, stroke: robotColour(j), value: (m) => m.u[k]?.[j] ?? null })) });
    }
    if (scene.barrier) {
      plots.push({ title: 'Reserve of the barrier [m]; bars: it acts', limits: [0],
        bars: agents.map(({ i, k }) => ({ colour: robotColour(i), on: (m) => m.barrier?.[k] === 1 })),
        series: agents.map(({ body, i, k }) => ({ label: body.name, stroke: robotColour(i), value: (m) => m.reserve?.[k] ?? null })) });
    }
    plots.push({ title: 'Solve time [µs]', limits: [], series: [{ label: 'update', stroke: robotColour(0), value: (m) => m.us }] });
    plots.push({ title: 'Residual', limits: [], log: true, series: [{ label: 'residual', stroke: robotColour(0), value: (m) => (m.residual > 0 ? m.residual : null) }] });
    return plots;
  }

  makePlot(spec) {
    const c = colours(), title = document.createElement('h2'), place = document.createElement('div'), now = document.createElement('i');
    title.textContent = spec.title;
    now.className = 'now';
    this.element.append(title, place);
    this.looks.observe(place);
    const axis = { stroke: c.text, grid: { stroke: c.edge, width: 1 }, ticks: { stroke: c.edge }, font: '11px system-ui' };
    const limits = [...new Set(spec.limits.filter((v) => v !== null && Number.isFinite(v) && Math.abs(v) < 1e6))];
    const one = { spec, limits, place, now };
    one.plot = new uPlot({
      width: width(), height, legend: { live: false, show: spec.series.length > 1 },
      scales: { x: { time: false }, y: { auto: false, distr: spec.log ? 3 : 1 } },
      axes: [{ ...axis, size: 30, gap: 2 }, { ...axis, size: 48, ...(spec.log ? { values: (u, all) => all.map((v) => (v === null ? '' : v.toExponential(0))) } : {}) }],
      series: [{ label: 't' }, ...spec.series.map(({ label, stroke, dash }) => ({ label, stroke, dash, width: 1.5, points: { show: false } })),
        ...limits.map((v) => ({ label: `limit ${v.toPrecision(3)}`, stroke: c.grey, width: 1, dash: [5, 4], points: { show: false } }))],
      cursor: { drag: { x: false, y: false }, bind: { click: (u) => () => { this.seek(u.posToVal(u.cursor.left, 'x')); return null; } } },
      hooks: { draw: [(u) => this.drawBars(u, one)] },
    }, [[], ...spec.series.map(() => []), ...limits.map(() => [])], place);
    one.plot.over.append(now);
    for (const row of [...place.querySelectorAll('.u-series')].slice(spec.series.length)) row.hidden = true;
    return one;
  }

  // A strip for each robot at the plot's foot, where it holds.
  drawBars(u, { spec, rows }) {
    if (!spec.bars || !rows) return;
    const { ctx } = u, { top, height: tall } = u.bbox, thick = strip * devicePixelRatio;
    spec.bars.forEach(({ colour, on }, k) => {
      ctx.fillStyle = colour;
      for (let i = 0; i < rows.length; ++i) {
        if (!on(rows[i])) continue;
        const from = i;
        while (i + 1 < rows.length && on(rows[i + 1])) ++i;
        const x = u.valToPos(rows[from].t, 'x', true), until = u.valToPos(rows[i].t, 'x', true);
        ctx.fillRect(x, top + tall - (k + 1) * thick, Math.max(until - x, 1), thick);
      }
    });
  }

  resize() {
    for (const { plot } of this.plots ?? []) plot.setSize({ width: width(), height });
  }

  // Moves the line of the present time, which costs little; draws curves where there is something new to draw.
  draw(history, index, log) {
    const moments = history.moments;
    if (moments.length === 0) return;
    const now = moments[index].t, whole = this.window === 0 && log, span = this.window || 20;
    const end = whole ? history.end : Math.max(now, history.begin + span);
    const begin = whole ? history.begin : Math.max(history.begin, end - span);
    const what = `${begin} ${end} ${whole ? moments.length : index} ${this.element.clientWidth}`;
    if (what !== this.drawn) {
      this.drawn = what;
      const rows = pick(moments, history.indexAt(begin), whole ? moments.length : index + 1);
      for (const one of this.plots) if (this.shown.has(one.place)) this.drawPlot(one, rows, begin, end);
    }
    for (const { plot, now: mark, place } of this.plots) {
      if (this.shown.has(place)) mark.style.transform = `translateX(${plot.valToPos(now, 'x').toFixed(1)}px)`;
    }
  }

  drawPlot(one, rows, begin, end) {
    const { spec, limits, plot } = one, columns = spec.series.map(({ value }) => rows.map(value));
    one.rows = rows;
    let low = Infinity, high = -Infinity;
    const widen = (v) => { if (v !== null && v < low) low = v; if (v !== null && v > high) high = v; };
    columns.forEach((column) => column.forEach(widen));
    limits.forEach(widen);
    const room = Math.max(0.05 * (high - low), 1e-3);
    plot.batch(() => {
      plot.setData([rows.map((m) => m.t), ...columns, ...limits.map((v) => rows.map(() => v))], false);
      plot.setScale('x', { min: begin, max: Math.max(end, begin + 0.1) });
      if (low <= high) plot.setScale('y', spec.log ? { min: low / 2, max: high * 2 } : { min: low - room, max: high + room });
    });
  }
}
