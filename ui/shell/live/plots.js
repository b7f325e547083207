// Lines of figures that follow the sliders: their paths are written on the figure's own axes.

import { weigh } from "./comparison.js";

const COLUMNS = 700; // of a line over time: more than that nobody sees while it moves

function axesOf(plot, trace) {
  const full = plot._fullLayout;
  const axis = (name) => full[name.replace(/^([xy])(\d*)$/, "$1axis$2")];
  return [axis(trace.xaxis ?? "x"), axis(trace.yaxis ?? "y")];
}

// Traces are found by their `meta`: Plotly for Python leaves their names of their own out.
function groupOf(plot, trace) {
  return plot.querySelector(`.scatterlayer .trace${CSS.escape(trace.uid)}`);
}

export function traceOf(plot, name) {
  const trace = plot._fullData?.find((one) => one.meta === name);
  const group = trace && groupOf(plot, trace);
  return group ? { trace, group } : null;
}

export function hide(plot, prefix, isHidden) {
  const traces = (plot._fullData ?? []).filter((trace) => String(trace.meta).startsWith(prefix));
  for (const trace of traces) groupOf(plot, trace)?.style.setProperty("visibility", isHidden ? "hidden" : "visible");
}

function points(xs, ys) {
  let path = "";
  for (let i = 0; i < xs.length; i += 1) path += `${i ? "L" : "M"}${xs[i].toFixed(1)},${ys[i].toFixed(1)}`;
  return path;
}

// Rows of a series that keep its shape when drawn: of each column of pixels the least and the
// largest value, in their order.
function decimated(values, start, stop) {
  const n = stop - start;
  if (n <= 2 * COLUMNS) return Array.from({ length: n }, (_, i) => start + i);
  const rows = [];
  for (let column = 0; column < COLUMNS; column += 1) {
    const from = start + Math.floor((n * column) / COLUMNS);
    const to = start + Math.floor((n * (column + 1)) / COLUMNS);
    let [low, high] = [from, from];
    for (let i = from; i < to; i += 1) {
      if (values[i] < values[low]) low = i;
      if (values[i] > values[high]) high = i;
    }
    rows.push(Math.min(low, high));
    if (low !== high) rows.push(Math.max(low, high));
  }
  return rows;
}

function drawLine(plot, uid, isUpright, times, values, [start, stop]) {
  const found = traceOf(plot, uid);
  const line = found?.group.querySelector("path.js-line");
  if (!line) return;
  const [xAxis, yAxis] = axesOf(plot, found.trace);
  const rows = decimated(values, start, stop);
  const along = rows.map((row) => (isUpright ? yAxis : xAxis).d2p(times[row]));
  const across = rows.map((row) => (isUpright ? xAxis : yAxis).d2p(values[row]));
  line.setAttribute("d", isUpright ? points(across, along) : points(along, across));
}

// Similarity over time: both systems' frames and moving means. What is filled or marked is of the
// settings before and is left out until the server draws it.
export function paintTrace(plot, comparison, recording, windowS) {
  const isUpright = plot.layout.meta[2] === "y";
  const { first, frame, fps } = comparison.columns;
  const [start, stop] = [first[recording], first[recording + 1]];
  const times = Float64Array.from(frame.subarray(start, stop), (number) => (number - frame[start]) / fps[recording]);
  for (const letter of ["x", "y"]) {
    const values = comparison[letter].similarity.subarray(start, stop);
    drawLine(plot, `nv-raw-${letter}`, isUpright, times, values, [0, values.length]);
    drawLine(plot, `nv-mean-${letter}`, isUpright, times, comparison.smooth(comparison[letter], recording, windowS), [0, values.length]);
  }
}

// The weight of a box over its size, for the sigmoid that the sliders show: one for all recordings.
export function paintWeight(plot, zero, spread) {
  const found = traceOf(plot, "nv-weight-0");
  const line = found?.group.querySelector("path.js-line");
  if (!line) return;
  const [xAxis, yAxis] = axesOf(plot, found.trace);
  const [from, to] = xAxis.range;
  const sizes = Array.from({ length: 121 }, (_, i) => from + ((to - from) * i) / 120);
  line.setAttribute("d", points(sizes.map((size) => xAxis.d2p(size)), sizes.map((size) => yAxis.d2p(weigh((size - zero) / spread)))));
  const mark = traceOf(plot, "nv-midpoint-0")?.group.querySelector("path.point");
  mark?.setAttribute("transform", `translate(${xAxis.d2p(zero)},${yAxis.d2p(0.5)})`);
}
