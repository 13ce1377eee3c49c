// The timeline: events to click on, faults that the scenario injects (hatched), and the robots' fallback levels.
import { robotColour } from './palette.js';

const bad = /conflict|refused|land|missed|late|dropped|deadline|not_finite|ignored|search/;

export class Timeline {
  constructor(marks, bands, seek) {
    this.marks = marks;
    this.bands = bands;
    this.seek = seek;
    this.forget();
  }

  forget() {
    this.drawn = '';
    this.drawnEnd = -Infinity;
  }

  draw(history) {
    const { events, levels, begin, end } = history, what = `${events.length} ${events.at(-1)?.[0]} ${levels.length} ${begin}`;
    // What grows is drawn once a second.
    if (what === this.drawn && (end === this.drawnEnd || Math.abs(end - this.drawnEnd) < 1)) return;
    this.drawn = what;
    this.drawnEnd = end;
    const share = (t) => `${(100 * Math.min(1, Math.max(0, (t - begin) / Math.max(end - begin, 1e-6)))).toFixed(3)}%`;
    this.marks.replaceChildren(...events.slice(-300).map(([, t, words]) => {
      const mark = document.createElement('button');
      mark.type = 'button';
      mark.title = `${t.toFixed(2)} s: ${words}`;
      mark.tabIndex = -1;
      if (bad.test(words)) mark.className = 'bad';
      mark.style.left = share(t);
      mark.onclick = () => this.seek(t);
      return mark;
    }));
    const band = (from, until, kind, words, colour) => {
      const one = document.createElement('i');
      one.className = kind;
      one.title = `${from.toFixed(2)} to ${until.toFixed(2)} s: ${words}`;
      one.style.left = share(from);
      one.style.right = `calc(100% - ${share(until)})`;
      if (colour) one.style.borderColor = colour;
      return one;
    };
    const faults = history.scene.faults.filter(({ from }) => from <= end)
      .map(({ name, from, until }) => band(from, Math.min(until ?? end, end), 'fault', name));
    const fallen = levels.slice(-300).filter(({ level }) => level !== 'valid').map(({ body, level, from, until }) =>
      band(from, until ?? end, `level ${level}`, `${history.scene.bodies[body].name}: ${level}`, robotColour(body)));
    this.bands.replaceChildren(...faults, ...fallen);
    this.bands.hidden = faults.length + fallen.length === 0;
  }
}
