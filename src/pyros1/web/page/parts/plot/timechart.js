// A chart of curves over time, with pan and zoom.

import uPlot from "../../vendor/uplot.js";
import { number } from "../../lib/format.js";
import { gestures } from "./gestures.js";
import { dots } from "./curve_styles.js";
import { axisWidth, safeRange, tickLabels, paddedRange, roundTimes } from "./plot_text.js";

/** @typedef {uPlot & {lines?: object[], high?: number[] | null}} TimeChart */

// lines: [{label, colour, dash}]
// on: {origin() -> the time that the axis calls 0, shown() -> [begin, end], show(range), all(), cursor(chart),
// room(width) -> the width to use for the axis}
// The chart has `lines`, and `high`: the zoomed vertical range, if any.
export function timeChart(area, lines, size, on) {
  const style = getComputedStyle(document.documentElement);
  const colour = (name) => style.getPropertyValue(name).trim();
  const axis = { stroke: colour("--muted"), grid: { stroke: colour("--border"), width: 1 }, ticks: { stroke: colour("--border"), width: 1 } };
  /** @type {TimeChart} */
  const chart = new uPlot({
    ...size,
    padding: [10, 12, 0, 0],
    legend: { show: false },
    cursor: { sync: { key: "plots" }, drag: { x: true, y: true, uni: 40, setScale: false }, focus: { prox: 24 } },
    scales: { x: { time: false, auto: false }, y: { range: (/** @type {TimeChart} */ plot, least, most) => (plot.high ? safeRange(plot.high) : paddedRange(least, most)) } },
    axes: [
      {
        ...axis, size: 30,
        splits: (plot, _, begin, end) => roundTimes(on.origin() ?? end, begin, end, plot.over.clientWidth / 80),
        values: (_, ticks) => ticks.map((tick) => `${number(tick - (on.origin() ?? 0), 3)} s`),
      },
      { ...axis, size: (_, texts) => on.room(axisWidth(_, texts)), values: (_, ticks) => tickLabels(ticks) },
    ],
    series: [{}, ...lines.map((line) => ({
      label: line.label, stroke: line.colour, dash: line.dash, width: 1.5, points: dots(line.colour),
    }))],
    hooks: {
      setSelect: [zoomTo],
      setCursor: [on.cursor],
    },
  }, [new Float64Array(0), ...lines.map(() => [])], area);
  chart.lines = lines;
  chart.high = null; // the zoomed vertical range
  let pressed = false; // whether the mouse was pressed in this chart, not in another one with a synchronised cursor
  chart.over.addEventListener("mousedown", () => { pressed = true; });
  gestures(chart.over, { pan, pinch: scale });
  chart.over.addEventListener("dblclick", () => on.all());
  chart.over.addEventListener("wheel", wheel, { passive: false });
  return chart;

  function zoomTo({ select: { left, top, width, height } }) {
    if (width < 4 || height < 4) return;
    const { clientWidth, clientHeight } = chart.over;
    if (pressed && height < clientHeight - 1) chart.high = [chart.posToVal(top + height, "y"), chart.posToVal(top, "y")];
    pressed = false;
    chart.setSelect({ left: 0, width: 0, top: 0, height: 0 }, false);
    on.show(width < clientWidth - 1 ? [chart.posToVal(left, "x"), chart.posToVal(left + width, "x")] : on.shown());
  }

  function wheel(event) {
    event.preventDefault();
    const [begin, end] = on.shown();
    const factor = event.deltaY > 0 ? 1 / 1.2 : 1.2;
    if (event.ctrlKey) scale(event.offsetX, event.offsetY, 1, factor);
    else if (event.shiftKey || Math.abs(event.deltaX) > Math.abs(event.deltaY)) {
      const by = Math.sign(event.deltaX || event.deltaY) * (end - begin) * 0.1;
      on.show([begin + by, end + by]);
    } else scale(event.offsetX, event.offsetY, factor, 1);
  }

  // The curves follow the pointer; vertically only if zoomed.
  function pan(right, down) {
    const [begin, end] = on.shown();
    const by = (right / chart.over.clientWidth) * (end - begin);
    if (chart.high) {
      const up = (down / chart.over.clientHeight) * (chart.high[1] - chart.high[0]);
      chart.high = chart.high.map((value) => value + up);
    }
    on.show([begin - by, end - by]);
  }

  // Zoom around a position, which stays fixed.
  function scale(left, top, across, along) {
    const about = (/** @type {number[]} */ [least, most], here, factor) => [here - (here - least) / factor, here + (most - here) / factor];
    const { min = NaN, max = NaN } = chart.scales.y;
    if (along !== 1) chart.high = about([min, max], chart.posToVal(top, "y"), along);
    on.show(about(on.shown(), chart.posToVal(left, "x"), across));
  }
}
