// Lines over time on a canvas: gaps, dashes, ticks, strips at the foot, a legend that hides lines, and the present time.
import { linearTicks, logTicks } from './ticks.js';

const left = 48, right = 6, top = 8, bottom = 20, apartX = 48, apartY = 28, strip = 3; // [px]

export class Plot {
  // series: [{label, stroke, dash}], of which those with a label are in the legend where there are several; colours: {text, edge};
  // seek(t): a click on the time t.
  constructor(place, { height, series, log, colours, seek }) {
    Object.assign(this, { place, height, series, log, colours, hidden: new Set() });
    this.canvas = document.createElement('canvas');
    this.over = document.createElement('div');
    [this.now, this.upright, this.level] = ['now', 'upright', 'level'].map((kind) => {
      const one = document.createElement('i');
      one.className = kind;
      return one;
    });
    this.over.className = 'over';
    this.over.append(this.now, this.upright, this.level);
    Object.assign(this.over.style, { left: `${left}px`, right: `${right}px`, top: `${top}px`, height: `${height - top - bottom}px` });
    this.over.onpointermove = ({ offsetX, offsetY }) => {
      this.upright.style.transform = `translateX(${offsetX}px)`;
      this.level.style.transform = `translateY(${offsetY}px)`;
    };
    this.over.onclick = ({ offsetX }) => { if (this.x) seek(this.x[0] + (offsetX / this.over.clientWidth) * (this.x[1] - this.x[0])); };
    place.classList.add('plot');
    place.append(this.canvas, this.over);
    const named = series.filter(({ label }) => label);
    if (named.length > 1) place.append(this.legend(named));
  }

  legend(named) {
    const list = document.createElement('div');
    list.className = 'legend';
    for (const one of named) {
      const button = document.createElement('button'), mark = document.createElement('i');
      button.type = 'button';
      button.title = 'Show or hide';
      button.setAttribute('aria-pressed', 'true');
      mark.style.borderColor = one.stroke;
      mark.style.borderTopStyle = one.dash ? 'dashed' : 'solid';
      button.append(mark, one.label);
      button.onclick = () => {
        if (!this.hidden.delete(one)) this.hidden.add(one);
        button.setAttribute('aria-pressed', String(!this.hidden.has(one)));
        this.paint();
      };
      list.append(button);
    }
    return list;
  }

  // times and the series' values at them, null where there is none; the axes' ends x and y; strips: [{colour, spans: [[from, until]]}].
  draw({ times, values, x, y, strips }) {
    Object.assign(this, { times, values, x, y, strips });
    this.paint();
  }

  // Where a time is, from the left of the lines' area [px].
  across(t) {
    return ((t - this.x[0]) / (this.x[1] - this.x[0])) * (this.width - left - right);
  }

  markNow(t) {
    if (this.x) this.now.style.transform = `translateX(${this.across(t).toFixed(1)}px)`;
  }

  paint() {
    if (!this.x) return;
    const { canvas, height, colours, x, y } = this, context = canvas.getContext('2d'), ratio = devicePixelRatio;
    this.width = this.place.clientWidth;
    const size = [Math.round(this.width * ratio), Math.round(height * ratio)];
    if (canvas.width !== size[0] || canvas.height !== size[1]) {
      [canvas.width, canvas.height] = size;
      Object.assign(canvas.style, { width: `${this.width}px`, height: `${height}px` });
    }
    const wide = this.width - left - right, tall = height - top - bottom, measure = this.log ? Math.log10 : (v) => v;
    const [low, high] = y.map(measure), down = (v) => tall * (1 - (measure(v) - low) / (high - low));
    context.setTransform(ratio, 0, 0, ratio, ratio * left, ratio * top);
    context.clearRect(-left, -top, this.width, height);

    Object.assign(context, { font: '11px system-ui', fillStyle: colours.text, strokeStyle: colours.edge, lineWidth: 1, textAlign: 'center', textBaseline: 'top' });
    context.setLineDash([]);
    context.beginPath();
    for (const [t, words] of linearTicks(x[0], x[1], Math.max(2, Math.floor(wide / apartX)))) {
      const at = Math.round(this.across(t)) + 0.5;
      context.moveTo(at, 0);
      context.lineTo(at, tall + 4);
      context.fillText(words, at, tall + 6);
    }
    Object.assign(context, { textAlign: 'right', textBaseline: 'middle' });
    for (const [v, words] of (this.log ? logTicks : linearTicks)(y[0], y[1], Math.max(2, Math.floor(tall / apartY)))) {
      const at = Math.round(down(v)) + 0.5;
      context.moveTo(-4, at);
      context.lineTo(wide, at);
      context.fillText(words, -7, at);
    }
    context.stroke();

    context.save();
    context.beginPath();
    context.rect(0, 0, wide, tall);
    context.clip();
    this.series.forEach((one, k) => {
      if (this.hidden.has(one)) return;
      Object.assign(context, { strokeStyle: one.stroke, lineWidth: one.dash ? 1 : 1.5, lineJoin: 'round' });
      context.setLineDash(one.dash ?? []);
      context.beginPath();
      let joined = false;
      this.values[k].forEach((v, i) => {
        if (v !== null) context[joined ? 'lineTo' : 'moveTo'](this.across(this.times[i]), down(v));
        joined = v !== null;
      });
      context.stroke();
    });
    (this.strips ?? []).forEach(({ colour, spans }, k) => {
      context.fillStyle = colour;
      for (const [from, until] of spans) context.fillRect(this.across(from), tall - (k + 1) * strip, Math.max(this.across(until) - this.across(from), 1), strip);
    });
    context.restore();
  }
}
