// Words for curves as rqt_plot takes them, and places of the ticks of a chart.

// /a/x:y and /a,/b stand for several curves; an expression stands for itself.
export function expand(text) {
  if (text.includes(": ") || text.includes("(")) return [text];
  return text.split(",").flatMap((part) => {
    if (part.includes("[")) return [part];
    const [head, ...others] = part.trim().split(":");
    const folder = head.slice(0, head.lastIndexOf("/"));
    return [head, ...others.map((other) => `${folder}/${other}`)];
  });
}

// Round numbers of seconds before a time, about so many.
export function ticksBefore(origin, begin, end, count) {
  const least = (end - begin) / Math.max(2, count);
  const power = 10 ** Math.floor(Math.log10(least));
  const step = [1, 2, 5, 10].map((factor) => factor * power).find((size) => size >= least);
  const first = Math.ceil((begin - origin) / step - 1e-6);
  const last = Math.floor((end - origin) / step + 1e-6);
  return Array.from({ length: Math.max(0, last - first + 1) }, (_, index) => origin + (first + index) * step);
}

// The ends of an axis for values between two, with some room.
export function spread(least, most) {
  if (least === null || most === null || !Number.isFinite(least) || !Number.isFinite(most)) return [0, 1];
  const room = least === most ? Math.abs(least) * 0.1 || 0.5 : (most - least) * 0.08;
  return [least - room, most + room];
}
