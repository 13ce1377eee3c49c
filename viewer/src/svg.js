// Elements of figures in SVG: curves by their marks, text, shades of a field.
export const grey = '#8a8f98';
const shades = ['f3f7fc', 'c6dcef', '84b8da', '3787c0', '0b3c7d'].map((hex) => [0, 2, 4].map((i) => parseInt(hex.slice(i, i + 2), 16)));
export const strokes = { line: { 'stroke-width': 1.6 }, dashed: { 'stroke-width': 1.6, 'stroke-dasharray': '8 5' }, thin: { 'stroke-width': 0.8 },
  points: { 'stroke-width': 5, 'stroke-linecap': 'round' }, arrows: { 'stroke-width': 1.4 }, bars: { 'stroke-width': 7, opacity: 0.55 } };

export function element(name, attributes, ...inside) {
  const one = document.createElement(name);
  Object.assign(one, attributes);
  one.append(...inside);
  return one;
}
export function svg(name, attributes, ...inside) {
  const one = document.createElementNS('http://www.w3.org/2000/svg', name);
  for (const [key, value] of Object.entries(attributes)) one.setAttribute(key, value);
  one.append(...inside);
  return one;
}
export const words = (x, y, text, more = {}) => svg('text', { x, y, ...more }, text);
export const written = (v, digits = 5) => (v === null ? '-' : String(Number(v.toPrecision(digits))));

// The least and the greatest value; infinite where there is none.
export const ends = (values) => values.reduce(([low, high], v) => (v === null ? [low, high] : [Math.min(low, v), Math.max(high, v)]), [Infinity, -Infinity]);

export function shade(part) {
  const at = Math.min(Math.max(part, 0), 1) * (shades.length - 1), i = Math.min(Math.floor(at), shades.length - 2);
  return `rgb(${shades[i].map((v, k) => Math.round(v + (at - i) * (shades[i + 1][k] - v)))})`;
}

// One path for each curve; a missing value is a gap. across and down: the pixels of x and of y.
export function curvePath({ colour, mark, x, y }, across, down) {
  const at = (i) => [across(x[i]), down(y[i])].map((v) => v.toFixed(1)), there = y.map((v, i) => v !== null && x[i] !== null);
  let d = '';
  if (mark === 'arrows') {
    for (let i = 0; i + 1 < x.length; i += 2) {
      if (!there[i] || !there[i + 1]) continue;
      const [bx, by] = [across(x[i + 1]), down(y[i + 1])], dx = bx - across(x[i]), dy = by - down(y[i]), length = Math.hypot(dx, dy) || 1, head = Math.min(10, length);
      const corner = (side) => `${(bx - (head * (dx + side * dy / 3)) / length).toFixed(1)} ${(by - (head * (dy - side * dx / 3)) / length).toFixed(1)}`;
      d += `M${at(i)}L${at(i + 1)}L${corner(1)}L${corner(-1)}L${at(i + 1)}`;
    }
    return svg('path', { d, stroke: colour, fill: colour, ...strokes.arrows });
  }
  if (mark === 'bars') {
    const foot = down(0).toFixed(1);
    for (let i = 0; i + 1 < x.length; ++i) if (there[i] && there[i + 1]) d += `M${at(i)[0]} ${foot}V${at(i)[1]}H${at(i + 1)[0]}V${foot}`;
    return svg('path', { d, fill: colour, opacity: 0.55 });
  }
  for (let i = 0; i < x.length; ++i) if (there[i]) d += mark === 'points' ? `M${at(i)}h0` : `${i > 0 && there[i - 1] ? 'L' : 'M'}${at(i)}`;
  return svg('path', { d, stroke: colour, fill: 'none', ...strokes[mark] });
}
