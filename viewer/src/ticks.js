// Round numbers from low to high, at most so many intervals.
export function linearTicks(low, high, most) {
  const rough = (high - low) / most, power = 10 ** Math.floor(Math.log10(rough));
  const step = power * ([1, 2, 5].find((m) => m * power >= rough) ?? 10), digits = Math.min(9, Math.max(0, -Math.floor(Math.log10(step) + 1e-9)));
  return Array.from({ length: most + 1 }, (_, k) => (Math.ceil(low / step - 1e-9) + k) * step).filter((v) => v <= high + 1e-9 * step)
    .map((v) => [v, Math.abs(v) < 1e5 ? v.toFixed(digits) : v.toExponential(1)]);
}

// Powers of ten; parts of them where there is hardly one.
export function logTicks(low, high, most) {
  const first = Math.ceil(Math.log10(low) - 1e-9), last = Math.floor(Math.log10(high) + 1e-9), step = Math.max(1, Math.ceil((last - first) / most));
  const values = [];
  for (let power = first; power <= last; power += step) values.push(10 ** power);
  if (values.length < 2) values.splice(0, values.length, ...[-1, 0].flatMap((k) => [1, 2, 5].map((m) => m * 10 ** (first + k))).filter((v) => v >= low && v <= high));
  return values.map((v) => [v, v.toExponential(0)]);
}
