// A figure whose points can be clicked is worked by keys as well: arrows go from point to point,
// Enter clicks. A second click on a point acts like the first.

import { asText, axisKey, partOf } from "./figure.js";

const STEP_OF_PAGE = 0.1;
const MOST_IN_ROW = 0.5; // rows are rows if there are no more of them than this share of the points
const MOST_DISTINCT = 0.5; // marks with fewer meanings than this share of them are of regions
const INSIDE_PX = 4;
const HOVER_MS = 80; // Plotly answers a movement of the mouse within so long
const LOOK_MS = 20;
const LOOKS = 10;
const DIRECTIONS = { ArrowRight: 1, ArrowLeft: -1, ArrowDown: 1, ArrowUp: -1, PageDown: 1, PageUp: -1, Home: 0, End: 0 };
const spots = new WeakMap(); // the point that is marked

function axesOf(plot, trace) {
  return [plot._fullLayout[axisKey(trace.xaxis, "x")], plot._fullLayout[axisKey(trace.yaxis, "y")]];
}

// Where a point is, in pixels of its axes; of a bar just inside its end. Nothing of an empty bar.
function placeOf(plot, trace, curve, index) {
  const [xaxis, yaxis] = axesOf(plot, trace);
  if (trace.type !== "bar") return [xaxis.d2p(trace.x[index]), yaxis.d2p(trace.y[index])];
  const { p0, p1, s, s0, s1 } = plot.calcdata[curve]?.[index] ?? {};
  if (!s) return [];
  const isFlat = trace.orientation === "h";
  const [lengthwise, across] = isFlat ? [xaxis, yaxis] : [yaxis, xaxis];
  const [base, end] = [lengthwise.c2p(s0), lengthwise.c2p(s1)];
  const inside = end + Math.sign(base - end) * Math.min(INSIDE_PX, Math.abs(base - end) / 2);
  const middle = across.c2p((p0 + p1) / 2);
  return isFlat ? [inside, middle] : [middle, inside];
}

// What leads to the same place counts once: X and Y of a frame, and the many marks of a region.
function namesOf(trace, curve, what, point, isRegion) {
  if (isRegion || trace.type === "bar") return [`${curve} ${what}`];
  return [`${what} x${point.x}`, `${what} y${point.y}`];
}

// A place in the plot for each thing that a click could mean, in pixels of the figure.
function pointsOf(plot) {
  const known = new Set();
  const points = [];
  plot._fullData.forEach((trace, curve) => {
    if (trace.visible !== true || !trace.customdata || !trace.x) return;
    const [xaxis, yaxis] = axesOf(plot, trace);
    const whats = Array.from(trace.customdata, (of) => JSON.stringify(of ?? null));
    const isRegion = new Set(whats).size <= MOST_DISTINCT * whats.length;
    for (let index = 0; index < trace.x.length; index += 1) {
      const [left, top] = placeOf(plot, trace, curve, index);
      const isSeen = left >= -1 && left <= xaxis._length + 1 && top >= -1 && top <= yaxis._length + 1;
      if (!isSeen || whats[index] === "null") continue;
      const point = { curve, index, x: Math.round(left + xaxis._offset), y: Math.round(top + yaxis._offset) };
      const names = namesOf(trace, curve, whats[index], point, isRegion);
      if (names.some((name) => known.has(name))) continue;
      names.forEach((name) => known.add(name));
      points.push(point);
    }
  });
  return points;
}

function along(first, second) {
  return (one, other) => one[first] - other[first] || one[second] - other[second];
}

function step(list, current, by) {
  const at = list.indexOf(current);
  return list[Math.min(Math.max(at + by, 0), list.length - 1)];
}

// Lanes and maps have rows, through which one goes; other points lie in the order of their axes.
function target(points, current, key) {
  const rows = [...new Set(points.map((point) => point.y))].sort((a, b) => a - b);
  const hasRows = rows.length > 1 && rows.length <= MOST_IN_ROW * points.length;
  const across = [...points].sort(hasRows ? along("y", "x") : along("x", "y"));
  const page = Math.max(Math.round(STEP_OF_PAGE * points.length), 1);
  if (!current || key === "Home") return across[0];
  if (key === "End") return across.at(-1);
  if (key.startsWith("Page")) return step(across, current, DIRECTIONS[key] * page);
  if (key === "ArrowRight" || key === "ArrowLeft") return step(across, current, DIRECTIONS[key]);
  if (!hasRows) return step([...points].sort(along("y", "x")), current, DIRECTIONS[key]);
  const row = rows[rows.indexOf(current.y) + DIRECTIONS[key]];
  const inRow = points.filter((point) => point.y === row);
  return inRow.reduce((best, point) => (
    Math.abs(point.x - current.x) < Math.abs(best.x - current.x) ? point : best
  ), inRow[0] ?? current);
}

function marked(plot, points) {
  const spot = spots.get(plot);
  return points.find((point) => point.curve === spot?.curve && point.index === spot?.index);
}

function press(plot, { curve, index }) {
  const value = plot._fullData[curve].customdata[index];
  plot.nvClick({ curve, value: value?.buffer ? [...value] : value });
}

function say(text) {
  const box = partOf(document.body, "nv-says");
  box.setAttribute("role", "status");
  box.textContent = text;
}

// Plotly writes its text beside the point that it thinks the mouse is at.
function hover(plot, point) {
  const { left, top } = plot.getBoundingClientRect();
  const [clientX, clientY] = [left + point.x, top + point.y];
  const area = [...plot.querySelectorAll(".nsewdrag")].find((drag) => {
    const box = drag.getBoundingClientRect();
    return clientX >= box.left - 1 && clientX <= box.right + 1 && clientY >= box.top - 1
      && clientY <= box.bottom + 1;
  });
  area?.dispatchEvent(new MouseEvent("mousemove", { bubbles: true, clientX, clientY }));
}

function unhover(plot) {
  plot.querySelector(".nv-mark")?.remove();
  plot.querySelectorAll(".nsewdrag").forEach((area) => (
    area.dispatchEvent(new MouseEvent("mouseout", { bubbles: true }))
  ));
}

function wordsOf(plot, { curve, index }) {
  const trace = plot._fullData[curve];
  const own = trace.type === "bar" ? null : trace.hovertext?.[index] ?? trace.text?.[index];
  if (typeof own === "string" && own.length > 1) return asText(own.replace(/<br>/g, ", "));
  const lines = [...plot.querySelectorAll(".hoverlayer .hovertext :is(.name, .nums)")].flatMap(
    (text) => (text.querySelector("tspan") ? [...text.querySelectorAll("tspan.line")] : [text]),
  );
  const written = lines.map((line) => line.textContent.trim()).filter(Boolean);
  return written.join(", ") || `${trace.name}: ${trace.x[index]}, ${trace.y[index]}`;
}

function mark(plot, points, point) {
  spots.set(plot, point);
  const ring = partOf(plot, "nv-mark");
  ring.style.left = `${point.x}px`;
  ring.style.top = `${point.y}px`;
  hover(plot, point);
  setTimeout(() => {
    if (spots.get(plot) !== point || document.activeElement !== plot) return;
    say(`${wordsOf(plot, point)} (${points.length} points)`);
  }, HOVER_MS);
}

function onKey(event) {
  const plot = event.currentTarget;
  const isPress = event.key === "Enter" || event.key === " ";
  if (event.target !== plot || event.ctrlKey || event.metaKey || event.altKey) return;
  if (!isPress && !(event.key in DIRECTIONS)) return;
  event.preventDefault();
  event.stopPropagation();
  const points = pointsOf(plot);
  const current = marked(plot, points);
  if (isPress && current) press(plot, current);
  else if (points.length) mark(plot, points, target(points, current, event.key));
}

function onFocus(event) {
  const plot = event.currentTarget;
  const points = pointsOf(plot);
  if (!points.length || !plot.matches(":focus-visible")) return;
  mark(plot, points, marked(plot, points) ?? target(points, null, ""));
}

// Presses what lies where the mouse was clicked. Plotly looks that up every now and then, not when the
// mouse is quick, and forgets it between press and release: it is asked until it has looked.
function pressAt(plot, area, { clientX, clientY }, triesLeft = LOOKS) {
  plot._hoverPointerX = undefined;
  area.dispatchEvent(new MouseEvent("mousemove", { bubbles: true, clientX, clientY }));
  if (plot._hoverPointerX === undefined && triesLeft) {
    setTimeout(() => pressAt(plot, area, { clientX, clientY }, triesLeft - 1), LOOK_MS);
    return;
  }
  const point = plot._hoverdata?.find((of) => plot._fullData[of.curveNumber]?.customdata);
  if (point) press(plot, { curve: point.curveNumber, index: point.pointNumber });
}

function hearClicks(plot) {
  let touch = null; // Plotly's click after a touch is at 0, 0
  plot.addEventListener("touchstart", (event) => {
    touch = event.changedTouches[0];
  }, { capture: true, passive: true });
  plot.addEventListener("click", (event) => {
    const area = event.target.closest(".nsewdrag");
    // Plotly sends one itself where nothing was dragged; the browser's own comes now and then
    if (!area || event.isTrusted) return;
    pressAt(plot, area, event.clientX || event.clientY ? event : touch ?? event);
  });
}

// Once for a plot whose points can be clicked, when it has been drawn.
export function makeReachable(plot) {
  plot.tabIndex = 0;
  hearClicks(plot);
  plot.addEventListener("keydown", onKey);
  plot.addEventListener("focus", onFocus);
  plot.addEventListener("blur", () => unhover(plot));
  plot.on("plotly_afterplot", () => {
    const points = pointsOf(plot);
    const point = marked(plot, points);
    if (point && plot.querySelector(".nv-mark")) mark(plot, points, point);
  });
}

export function namePlot(plot, { meta: [title, subtitle], alt, isClicked }) {
  const name = alt ?? ([title, subtitle].filter(Boolean).map(asText).join(": ") || "Figure");
  const keys = isClicked ? ". Arrow keys go from point to point, Enter does what a click does." : "";
  plot.setAttribute("role", isClicked ? "application" : "img");
  plot.setAttribute("aria-label", name + keys);
}
