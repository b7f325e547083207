// Sliders act while they move. What the browser can compute follows at once; the server, whose
// numbers take their place, is told when the slider rests or is let go, as by Streamlit itself.
// Where the browser cannot compute, the server is told on the way: one value at a time, then the
// newest, so that runs never pile up.

import { Comparison } from "./comparison.js";
import { paintFrame, paintMeasures } from "./numbers.js";
import { hide, paintTrace, paintWeight, traceOf } from "./plots.js";

const SLIDER = '[data-testid="stSidebar"] [data-testid="stSlider"]';
const MOST_WAIT_MS = 5000; // for an answer that was lost
const REST_MS = 250; // without a move, then the server is told
const LATE = "data-nv-late";
const NOW = "data-nv-now";
const PART = '[data-testid="stElementContainer"]';
const ALIKE = 0.6; // of a slider's step: it rounds to its steps
const STEPS = { ArrowLeft: -1, ArrowDown: -1, ArrowRight: 1, ArrowUp: 1 };
const KEY_BACK = { [-1]: "ArrowLeft", 1: "ArrowRight" };

const drag = { field: null, name: "", start: "", sent: "", id: 0, sentAt: 0, isAnswered: true, value: "", movedAt: 0 };
const keys = { field: null, step: 0, at: 0, timer: null };
let labels = {};
let drawn = {}; // what the page was drawn for
let live = null; // what the browser needs to compute by itself
let comparison = null;
let painted = ""; // the settings for which figures were last painted
let send = (_value) => {};

function nameOf(slider) {
  const classes = slider.closest('[class*="st-key-"]')?.classList ?? [];
  const names = [...classes].filter((name) => name.startsWith("st-key-")).map((name) => name.slice("st-key-".length));
  return names.find((name) => name in labels) ?? "";
}

function canFollow(name) {
  return comparison !== null && live?.names.includes(name);
}

// ---- what the server is told

function sendNext(value) {
  drag.id += 1;
  send({ name: drag.name, value: Number(value), id: drag.id });
}

function tell() {
  const { value } = drag.field;
  const now = performance.now();
  if (value !== drag.value) Object.assign(drag, { value, movedAt: now });
  if (value === drag.sent || (canFollow(drag.name) && now - drag.movedAt < REST_MS)) return;
  if (!drag.isAnswered && now - drag.sentAt <= MOST_WAIT_MS) return;
  Object.assign(drag, { sent: value, isAnswered: false, sentAt: now });
  sendNext(value);
}

function watch() {
  if (!drag.field) return;
  if (drag.field.isConnected) tell();
  requestAnimationFrame(watch);
}

function sliderAt(target) {
  const slider = target instanceof Element ? target.closest(SLIDER) : null;
  const field = slider?.querySelector('input[type="range"]');
  return field && !field.disabled ? { field, name: nameOf(slider) } : null;
}

function begin(event) {
  const { field, name } = sliderAt(event.target) ?? {};
  if (!name || event.button !== 0) return;
  Object.assign(drag, { field, name, start: field.value, sent: field.value, value: field.value });
  requestAnimationFrame(watch);
}

// What is let go is told by Streamlit, unless it ends where it began and so is no change.
function end() {
  const { field, start, sent } = drag;
  if (!field) return;
  requestAnimationFrame(() => {
    drag.field = null;
    if (field.value === start && sent !== start) sendNext(start);
  });
}

// Streamlit runs the page for every press of a key. Of presses in quick succession the first and
// the last do, the others move the slider alone: the last is pressed again when the keys rest.
function press(event) {
  const step = STEPS[event.key];
  const { field, name } = sliderAt(event.target) ?? {};
  if (!step || !name || event.nvcore || !canFollow(name)) return;
  const isFirst = keys.field !== field || performance.now() - keys.at > REST_MS;
  Object.assign(keys, { field, at: performance.now(), step });
  if (isFirst) return;
  event.preventDefault();
  event.stopImmediatePropagation();
  move(field, step);
  clearTimeout(keys.timer);
  keys.timer = setTimeout(pressLast, REST_MS / 2);
}

function move(field, step) {
  const setter = Object.getOwnPropertyDescriptor(HTMLInputElement.prototype, "value").set;
  setter.call(field, Number(field.value) + step * Number(field.step));
  field.dispatchEvent(new Event("input", { bubbles: true }));
}

function pressLast() {
  const { field, step } = keys;
  keys.field = null;
  if (!field.isConnected) return;
  const isAtStart = Number(field.value) - step * Number(field.step) < Number(field.min);
  const way = isAtStart ? -step : step;
  move(field, -way);
  const event = new KeyboardEvent("keydown", { key: KEY_BACK[way], code: KEY_BACK[way], bubbles: true, cancelable: true });
  event.nvcore = true;
  field.dispatchEvent(event);
}

// ---- what follows at once

// The sliders that show what the page was not drawn for: [name, value, step].
function ahead() {
  return [...document.querySelectorAll(`${SLIDER} input[type="range"]`)]
    .map((field) => [nameOf(field), Number(field.value), Number(field.step)])
    .filter(([name, value, step]) => name in drawn && Math.abs(value - drawn[name]) > ALIKE * step);
}

function text(name, value) {
  return `${labels[name]} ${Number(value.toFixed(6))}`;
}

// Numbers and figures for what the sliders show, where the browser can compute them.
function follow(main, sliders) {
  if (!live) return;
  const moved = new Map(sliders.map(([name, value]) => [name, value]));
  const isKnown = sliders.length > 0 && [...moved.keys()].every(canFollow);
  const settings = { ...live.settings, ...Object.fromEntries(moved) };
  const key = isKnown ? JSON.stringify(settings) : "";
  const isNew = key !== painted;
  if (isKnown && isNew) comparison.update(settings);
  const hasNumbers = main.querySelector("[data-measure]") !== null;
  if (hasNumbers) paintMeasures(main, moved, live.moves, isKnown ? comparison.measures() : null);
  if (isNew || !isKnown) paintFigures(main, isKnown, settings);
  painted = key;
}

function paintFigures(main, isKnown, settings) {
  const plot = document.querySelector('[class*="st-key-time_plot_"] .js-plotly-plot');
  const hasTrace = Boolean(plot?._fullLayout && traceOf(plot, "nv-raw-x"));
  if (hasTrace) {
    if (isKnown) paintTrace(plot, comparison, live.recording, live.window_s);
    hide(plot, "nv-low", isKnown);
    plot.closest(PART)?.toggleAttribute(NOW, isKnown);
  }
  for (const panel of main.querySelectorAll(".nv-numbers[data-row]")) {
    paintFrame(panel, isKnown ? comparison : null);
    panel.closest(PART)?.toggleAttribute(NOW, isKnown);
  }
  if (!isKnown) return;
  const weight = document.querySelector(".st-key-proximity_plot .js-plotly-plot");
  if (weight?._fullLayout && comparison.rules.proximity !== "none") {
    const { zero, spread, zeroM, spreadM } = comparison.formulaOf(live.recording);
    if (comparison.rules.proximity === "distance") paintWeight(weight, zeroM, -spreadM);
    else paintWeight(weight, zero - comparison.columns.horizon[live.recording], spread);
  }
  const { first } = comparison.columns;
  const [start, stop] = [first[live.recording], first[live.recording + 1]];
  const similarity = Object.fromEntries(["x", "y"].map((of) => [of, comparison[of].similarity.subarray(start, stop)]));
  const areCountsOld = live.counts.some((name) => settings[name] !== live.settings[name]);
  const detail = { recording: live.recording, areCountsOld, ...similarity };
  document.dispatchEvent(new CustomEvent("nvcore-similarity", { detail }));
}

// Says of which settings numbers are that are not of what the sliders show.
function mark() {
  const main = document.querySelector('[data-testid="stMain"]');
  if (!main) return;
  const sliders = ahead();
  if (!sliders.length && !main.hasAttribute(LATE)) return;
  if (sliders.length) {
    const words = sliders.map(([name, value]) => text(name, value)).join(", ");
    const grey = sliders.map(([name]) => text(name, drawn[name])).join(", ");
    const message = `Computing for ${words}. Grey parts are older: from ${grey} or before.`;
    if (main.getAttribute(LATE) !== message) main.setAttribute(LATE, message);
  } else main.removeAttribute(LATE);
  follow(main, sliders);
  const isFollowed = sliders.length > 0 && sliders.every(([name]) => canFollow(name));
  for (const part of main.querySelectorAll(".nv-of")) {
    const of = JSON.parse(part.dataset.of);
    const others = sliders
      .map(([name, value, step]) => [name, of[name] ?? drawn[name], value, step])
      .filter(([, own, value, step]) => Math.abs(own - value) > ALIKE * step);
    const isLive = isFollowed && part.parentElement.querySelector("[data-measure]") !== null;
    const words = isLive ? "" : others.map(([name, own]) => text(name, own)).join(", ");
    if (part.textContent !== words) part.textContent = words;
    part.closest(PART)?.toggleAttribute(NOW, sliders.length > 0 && !words);
  }
  for (const [key, names] of Object.entries(live?.still ?? {})) {
    const isStill = sliders.length > 0 && !sliders.some(([name]) => names.includes(name));
    for (const part of main.querySelectorAll(`.st-key-${key}`)) part.closest(PART)?.toggleAttribute(NOW, isStill);
  }
}

let url = "";

// The columns are fetched once, when a slider is first reached for, or at rest if they are few.
async function load() {
  if (!live || url === live.url) return;
  const wanted = live.url;
  url = wanted;
  comparison = null;
  const answer = await fetch(wanted).catch(() => null);
  const content = answer?.status === 200 ? await answer.arrayBuffer() : null;
  if (url !== wanted) return; // another comparison has been opened
  if (!content || live?.url !== wanted) {
    url = "";
    return;
  }
  comparison = new Comparison(content, live.rules);
  comparison.update(live.settings);
  mark();
}

export default function ({ data, setTriggerValue }) {
  ({ labels, drawn, live } = data);
  send = (value) => setTriggerValue("drag", value);
  if (data.answered >= drag.id) drag.isAnswered = true;
  if (live === null || url !== live.url) comparison = null;
  else if (comparison) comparison.rules = live.rules;
  if (live?.is_small) requestIdleCallback(load);
  mark();
  if (window.nvcoreLive) return;
  window.nvcoreLive = { compare: () => comparison };
  const options = { capture: true };
  document.addEventListener("pointerdown", begin, options);
  for (const name of ["pointerup", "pointercancel"]) document.addEventListener(name, end, options);
  document.addEventListener("keydown", press, options);
  for (const name of ["pointerover", "focusin"])
    document.addEventListener(name, (event) => sliderAt(event.target) && load(), options);
  // told before anything of the change is painted
  new MutationObserver(mark).observe(document.querySelector('[data-testid="stApp"]'), {
    subtree: true, childList: true, attributeFilter: ["value", "aria-valuetext"],
  });
}
