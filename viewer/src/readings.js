// What a panel shows at the pointer: rows of [colour, text], and dots [x, y, colour].
import { written } from './svg.js';

const near = 12; // [px]
const named = (curve, text) => [curve.colour, curve.label ? `${curve.label}: ${text}` : text];
const nearest = (values, v) => values.reduce((best, w, i) => (Math.abs(w - v) < Math.abs(values[best] - v) ? i : best), 0);

// In a plane: the nearest point of a curve, or the place itself; the value of the field.
export function readPlane({ spec: { grid }, curves, x, y, height }, [px, py]) {
  const here = [x.from(px), y.from(height - py)], rows = [], dots = [];
  let far = near, found;
  for (const curve of curves) {
    curve.x.forEach((v, i) => {
      const away = v === null || curve.y[i] === null ? Infinity : Math.hypot(x.to(v) - px, height - y.to(curve.y[i]) - py);
      if (away < far) [far, found] = [away, { curve, at: [v, curve.y[i]] }];
    });
  }
  const text = (found?.at ?? here).map((v) => written(v)).join(', ');
  rows.push(found ? named(found.curve, text) : ['none', text]);
  if (found) dots.push([...found.at, found.curve.colour]);
  if (grid) rows.push(['none', `${grid.label}: ${written(grid.z[nearest(grid.y, here[1]) * grid.across + nearest(grid.x, here[0])])}`]);
  return { rows, dots };
}

// Over a rising x: each curve's value at the nearest of its points; of limits none.
export function readCurves({ spec: { names }, shared, curves, x }, [px]) {
  const here = x.from(px), rows = [['none', `${shared} ${written(here)}`]], dots = [];
  for (const curve of curves) {
    const known = curve.x.filter((v) => v !== null), bars = curve.mark === 'bars';
    if (curve.x.length <= 2 || here < known[0] || here > known.at(-1) || known.some((v, i) => v < known[i - 1])) continue;
    const i = bars ? curve.x.findLastIndex((v) => v <= here) : nearest(curve.x, here), y = curve.y[i];
    if (y === null) continue;
    rows.push(named(curve, names[y] ?? written(y)));
    if (!bars) dots.push([curve.x[i], y, curve.colour]);
  }
  return { rows, dots };
}
