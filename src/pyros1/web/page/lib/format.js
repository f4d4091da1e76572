// Format numbers and times for people.

const MAX_SIMULATED_TIME = 1e8; // seconds; earlier times (before 1973) are simulated time

export function number(value, digits = 4) {
  if (typeof value !== "number") return String(value);
  if (Number.isInteger(value) && Math.abs(value) < 1e15) return String(value);
  const size = Math.abs(value);
  if (size !== 0 && (size < 1e-4 || size >= 1e7)) return value.toExponential(digits - 1).replace(/\.?0*e/, "e");
  return String(Number(value.toPrecision(digits + 2)));
}

// Format a value of a curve with enough digits to resolve a thousandth of its axis.
export function reading(value, span) {
  const size = Math.abs(value);
  if (!(span > 0) || !(size > 0) || size >= 1e15 || Number.isInteger(value)) return number(value);
  const behind = Math.ceil(-Math.log10(span / 1000)); // digits after the decimal point
  const needed = Math.floor(Math.log10(size)) + 1 + behind;
  if (needed <= (size < 1e-4 || size >= 1e7 ? 4 : 6)) return number(value);
  return String(Number(value.toFixed(Math.min(12, Math.max(0, behind)))));
}

export function rate(hz) {
  if (hz === undefined || hz === null) return "";
  if (hz === 0) return "0 Hz";
  return `${hz >= 99.95 ? hz.toFixed(0) : hz >= 9.995 ? hz.toFixed(1) : hz.toFixed(2)} Hz`;
}

export function bytes(count, unit = "B") {
  if (count === undefined || count === null) return "";
  const units = ["", "k", "M", "G", "T"];
  let index = 0;
  while (count >= 999.5 && index < units.length - 1) {
    count /= 1000;
    index += 1;
  }
  return `${index && count < 10 ? count.toFixed(1) : count.toFixed(0)} ${units[index]}${unit}`;
}

export function clock(seconds) {
  const date = new Date(seconds * 1000);
  if (seconds < MAX_SIMULATED_TIME) return seconds.toFixed(3);
  const two = (value) => String(value).padStart(2, "0");
  return `${two(date.getHours())}:${two(date.getMinutes())}:${two(date.getSeconds())}.${String(date.getMilliseconds()).padStart(3, "0")}`;
}

// Format a time or duration {secs, nsecs} in seconds, exactly. Negative ones have secs rounded down, and nsecs >= 0.
export function seconds({ secs, nsecs }) {
  const back = secs < 0 && nsecs > 0;
  const [whole, part] = back ? [-secs - 1, 1e9 - nsecs] : [secs, nsecs];
  return `${back ? "-" : ""}${whole}.${String(part).padStart(9, "0")}`;
}

// Format a date and time; simulated times as seconds.
export function moment(seconds) {
  return seconds < MAX_SIMULATED_TIME ? `${seconds.toFixed(2)} s` : new Date(seconds * 1000).toLocaleString();
}

export function plural(count, word) {
  return `${count} ${word}${count === 1 ? "" : "s"}`;
}

export function duration(seconds) {
  if (seconds === undefined || seconds === null) return "";
  const two = (value) => String(value).padStart(2, "0");
  const whole = Math.floor(seconds);
  const [days, hours] = [Math.floor(whole / 86400), Math.floor(whole / 3600) % 24];
  const rest = `${hours}:${two(Math.floor(whole / 60) % 60)}:${two(whole % 60)}`;
  return days ? `${days} d ${rest}` : rest;
}
