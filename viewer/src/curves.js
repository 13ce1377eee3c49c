// Curves of the samples over time: distances, view angles, inputs, what the solver and the barrier do, errors of estimates.
import { colours, robotColour } from './palette.js';
import { Plot } from './plot.js';

const height = 118, pointsMost = 900, pairsMost = 6, robotsMost = 4, degrees = 180 / Math.PI, sigmas = 3;

const pick = (moments, from, to) => {
  const step = Math.max(1, Math.ceil((to - from) / pointsMost)), rows = [];
  for (let k = from; k < to; k += step) rows.push(moments[k]);
  return rows;
};

// The spans of time over which something holds.
const spans = (rows, on) => {
  const all = [];
  rows.forEach((m, i) => {
    if (!on(m)) return;
    if (i > 0 && on(rows[i - 1])) all.at(-1)[1] = m.t; else all.push([m.t, m.t]);
  });
  return all;
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
    const c = colours(), title = document.createElement('h2'), place = document.createElement('div');
    title.textContent = spec.title;
    this.element.append(title, place);
    this.looks.observe(place);
    const limits = [...new Set(spec.limits.filter((v) => v !== null && Number.isFinite(v) && Math.abs(v) < 1e6))];
    const series = [...spec.series, ...limits.map(() => ({ stroke: c.grey, dash: [5, 4] }))];
    return { spec, limits, place, plot: new Plot(place, { height, series, log: spec.log, colours: c, seek: this.seek }) };
  }

  // Moves the line of the present time, which costs little; draws curves where there is something new to draw.
  draw(history, index, log) {
    const moments = history.moments;
    if (moments.length === 0) return;
    const now = moments[index].t, whole = this.window === 0 && log, span = this.window || 20;
    const end = whole ? history.end : Math.max(now, history.begin + span);
    const begin = whole ? history.begin : Math.max(history.begin, end - span);
    const what = `${begin} ${end} ${whole ? moments.length : index} ${this.element.clientWidth} ${devicePixelRatio}`;
    if (what !== this.drawn) {
      this.drawn = what;
      const rows = pick(moments, history.indexAt(begin), whole ? moments.length : index + 1);
      for (const one of this.plots) if (this.shown.has(one.place)) this.drawPlot(one, rows, begin, end);
    }
    for (const { plot, place } of this.plots) if (this.shown.has(place)) plot.markNow(now);
  }

  drawPlot({ spec, limits, plot }, rows, begin, end) {
    const columns = spec.series.map(({ value }) => rows.map(value));
    let low = Infinity, high = -Infinity;
    const widen = (v) => { if (v !== null && v < low) low = v; if (v !== null && v > high) high = v; };
    columns.forEach((column) => column.forEach(widen));
    limits.forEach(widen);
    if (low > high) [low, high] = spec.log ? [1, 1] : [0, 0]; // nothing to show but the axes
    const room = Math.max(0.05 * (high - low), 1e-3);
    plot.draw({ times: rows.map((m) => m.t), values: [...columns, ...limits.map((v) => rows.map(() => v))], x: [begin, Math.max(end, begin + 0.1)],
      y: spec.log ? [low / 2, high * 2] : [low - room, high + room], strips: spec.bars?.map(({ colour, on }) => ({ colour, spans: spans(rows, on) })) });
  }
}
