// Numbers of the page that follow the sliders: cells marked with their measure and its format.

import { UNDEFINED, difference, formatted } from "../../widgets/table/number_format.js";

const originals = new WeakMap(); // what the server drew, by element

function setText(element, text) {
  if (!originals.has(element)) originals.set(element, element.textContent);
  if (element.textContent !== text) element.textContent = text;
}

function restore(element) {
  if (!originals.has(element)) return;
  element.textContent = originals.get(element);
  originals.delete(element);
}

// Where the values of a measure stand, X, Y and their difference: in a row of a table, or a tile.
function cellsOf(element) {
  const cells = element.cells ? [...element.cells].slice(1, 4) : [...element.querySelectorAll("[data-value]")];
  return cells.length === 3 ? cells : [];
}

function paintMeasure(element, value) {
  const cells = cellsOf(element);
  const { form, better } = element.dataset;
  const texts = [formatted(value.x, form), formatted(value.y, form), difference(value.x, value.y, form)];
  const isEven = texts[0] === texts[1] || texts.includes(UNDEFINED);
  const winner = isEven ? "" : value.x > value.y === (better === "higher") ? "x" : "y";
  cells.forEach((cell, i) => {
    setText(cell, texts[i]);
    if (better && i < 2) (element.cells ? cell : cell.parentElement).classList.toggle("better", "xy"[i] === winner);
  });
}

// moved: names of the settings that the sliders have changed; moves: the settings that move each
// measure; values: what can be computed here.
export function paintMeasures(main, moved, moves, values) {
  for (const element of main.querySelectorAll("[data-measure]")) {
    const key = element.dataset.measure;
    const isMoved = (moves[key] ?? []).some((name) => moved.has(name));
    const value = isMoved ? values?.[key] : undefined;
    if (value) paintMeasure(element, value);
    else cellsOf(element).forEach(restore);
    element.classList.toggle("nv-old", isMoved && !value);
    element.classList.toggle("nv-half", isMoved && Boolean(value));
  }
}

// What a frame's panel says of it, by the heading of its row.
const OF_FRAME = {
  similarity: (system, row) => system.similarity[row],
  "lost to misses": (system, row, { halfWidth, settings }) => (settings.alpha * system.dMiss[row]) / halfWidth[row],
  "lost to false alarms": (system, row, { halfWidth, settings }) => ((1 - settings.alpha) * system.dFalse[row]) / halfWidth[row],
};

// The panel beside the viewer; without a comparison it gets its former numbers back.
export function paintFrame(panel, comparison) {
  const row = Number(panel.dataset.row);
  for (const line of panel.querySelectorAll("[data-frame-value]")) {
    const cells = [...line.cells].slice(1).map((cell) => cell.querySelector("b") ?? cell);
    const value = OF_FRAME[line.dataset.frameValue];
    if (!comparison || !value) cells.forEach(restore);
    else cells.forEach((cell, i) => setText(cell, formatted(value(comparison["xy"[i]], row, comparison), ".3f")));
    line.classList.toggle("nv-old", Boolean(comparison && !value));
  }
}
