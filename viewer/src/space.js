// A surface, or a cloud of points with curves in the plane z = 0, as seen from above at an angle.
import { curvePath, ends, grey, shade, svg, words, written } from './svg.js';

const shadesOfCloud = 12;

export function drawSpace({ spec, curves, left, top, width, height, turn, tilt }) {
  const { grid } = spec, cloud = grid.view === 'cloud', parts = [];
  const box = ['x', 'y', 'z'].map((key) => ends(grid[key].concat(cloud ? spec.curves.flatMap((curve) => curve[key] ?? [0]) : [])));
  const sizes = box.map(([low, high]) => Math.max(high - low, 1e-9)), longest = Math.max(...sizes, 1e-3);
  const middle = box.map(([low, high]) => (low + high) / 2);
  // Half the sides of the box; a cloud has equal scales, and no side too short for its ends.
  const [hx, hy, hz] = cloud ? sizes.map((size) => Math.max(size / longest, 0.5)) : [1, 1, 0.7], half = [hx, hy, hz];
  const unit = sizes.map((size, i) => (cloud ? 2 / longest : (2 * half[i]) / size));
  const [a, b] = [turn, tilt].map((v) => (v * Math.PI) / 180), size = (0.5 * height) / Math.hypot(...half);
  const place = ([x, y, z]) => { // [px], and the depth
    const u = x * Math.cos(a) - y * Math.sin(a), v = x * Math.sin(a) + y * Math.cos(a);
    return [left + width / 2 + size * u, top + 16 + height / 2 - size * (v * Math.cos(b) + z * Math.sin(b)), v * Math.sin(b) - z * Math.cos(b)];
  };
  const of = (p) => place(p.map((v, i) => (v - middle[i]) * unit[i]));
  const two = (p) => p.slice(0, 2).map((v) => v.toFixed(1)).join(' ');
  const text = (p, content, more) => { const [x, y] = place(p); parts.push(words(x, y, content, { 'text-anchor': 'middle', ...more })); };

  const corners = [[-hx, -hy], [hx, -hy], [hx, hy], [-hx, hy]], least = (k) => corners.reduce((best, c) => (place([...c, 0])[k] < place([...best, 0])[k] ? c : best));
  const nearest = least(2), leftmost = least(0);
  parts.push(svg('path', { d: `M${corners.map((c) => two(place([...c, -hz]))).join('L')}ZM${two(place([...leftmost, -hz]))}L${two(place([...leftmost, hz]))}`, fill: 'none', stroke: grey }));
  for (const [i, name] of [spec.x, spec.y].entries()) {
    const edge = (along) => (i === 0 ? [along * hx, 1.17 * nearest[1], -hz] : [1.17 * nearest[0], along * hy, -hz]);
    for (const end of [-0.9, 0.9]) text(edge(end), written(middle[i] + (end * half[i]) / unit[i], 3), { dy: 8, 'font-size': 11 });
    text(edge(0), name, { dy: 16 });
  }
  for (const end of [-1, 1]) text([...leftmost, end * hz], written(middle[2] + (end * hz) / unit[2], 3), { dx: -8, 'text-anchor': 'end', 'font-size': 11 });
  text([...leftmost, 0], grid.label, { dx: -8, 'text-anchor': 'end' });

  const [low, high] = ends(grid.z), span = high - low || 1;
  if (cloud) {
    // The middle of the shades is legible on light and dark pages.
    const paths = Array.from({ length: shadesOfCloud }, () => ''), part = (z) => (z - low + 0.9 * span) / (2.4 * span);
    grid.z.forEach((z, i) => { if (z !== null) paths[Math.floor(shadesOfCloud * part(z))] += `M${two(of([grid.x[i], grid.y[i], z]))}h0`; });
    paths.forEach((d, k) => parts.push(svg('path', { d, fill: 'none', stroke: shade((k + 0.5) / shadesOfCloud), 'stroke-width': 2, 'stroke-linecap': 'round' })));
  } else {
    const { across } = grid, at = (i) => [grid.x[i % across], grid.y[Math.floor(i / across)], grid.z[i]], faces = [];
    for (let i = 0; i + across + 1 < grid.z.length; ++i) {
      const four = [i, i + 1, i + across + 1, i + across].map(at);
      if ((i + 1) % across === 0 || four.some((p) => p[2] === null)) continue;
      const places = four.map(of), mean = four.reduce((sum, p) => sum + p[2] / 4, 0);
      faces.push([Math.max(...places.map((p) => p[2])), svg('path', { d: `M${places.map(two).join('L')}Z`, fill: shade((mean - low) / span), stroke: grey, 'stroke-width': 0.3 })]);
    }
    parts.push(...faces.sort(([p], [q]) => q - p).map(([, face]) => face));
  }
  for (const curve of curves) {
    const on = curve.x.map((x, i) => of([x, curve.y[i], 0]));
    parts.push(curvePath({ ...curve, x: on.map((p) => p[0]), y: on.map((p) => p[1]) }, (v) => v, (v) => v));
  }
  return parts;
}
