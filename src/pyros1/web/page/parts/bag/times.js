// Format times in a bag for people.

const STEPS = [1, 2, 5, 10, 15, 30, 60, 120, 300, 600, 900, 1800, 3600, 7200, 14400, 43200, 86400];

// Return approximately a given number of round times for a ruler.
export function ticks(begin, end, count) {
  const least = (end - begin) / count;
  const power = 10 ** Math.floor(Math.log10(least));
  const step = least > 1 ? STEPS.find((size) => size >= least) || 86400 * Math.ceil(least / 86400) : [1, 2, 5, 10].map((factor) => factor * power).find((size) => size >= least * 0.999) ?? 10 * power;
  const times = [];
  for (let index = Math.ceil(begin / step); index * step <= end && times.length < 200; index += 1) times.push(index * step);
  return { step, times };
}

// Format seconds since the beginning: 3.25 s, 1:02, 1:02:03. step: the ruler's step, which determines the number of digits.
export function formatElapsed(seconds, step = 0.001) {
  const digits = step >= 1 ? 0 : Math.min(6, Math.ceil(-Math.log10(step) - 1e-9));
  const size = Math.abs(seconds);
  if (size < 60) return `${seconds.toFixed(digits)} s`;
  const two = (value) => String(Math.floor(value)).padStart(2, "0");
  const rounded = Number(size.toFixed(digits));
  const rest = (rounded % 60).toFixed(digits).padStart(digits ? digits + 3 : 2, "0");
  const minutes = Math.floor(rounded / 60);
  const text = minutes < 60 ? `${minutes}:${rest}` : `${Math.floor(minutes / 60)}:${two(minutes % 60)}:${rest}`;
  return seconds < 0 ? `-${text}` : text;
}
