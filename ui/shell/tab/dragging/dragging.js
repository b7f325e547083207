// Parameters act while their slider is dragged: Streamlit itself tells Python only of the release.
// One value is on its way at a time, then the newest: runs never pile up.

const SLIDER = '[data-testid="stSidebar"] [data-testid="stSlider"]';
const MOST_WAIT_MS = 5000; // for an answer that was lost
const LATE = "data-nv-late";
const ALIKE = 0.6; // of a slider's step: it rounds to its steps

const drag = { field: null, name: "", start: "", sent: "", id: 0, sentAt: 0, isAnswered: true };
let labels = {};
let drawn = {}; // what the page was drawn for
let send = () => {};

function nameOf(slider) {
  const classes = slider.closest('[class*="st-key-"]')?.classList ?? [];
  const keys = [...classes].filter((name) => name.startsWith("st-key-")).map((name) => name.slice("st-key-".length));
  return keys.find((key) => key in labels) ?? "";
}

function sendNext(value) {
  drag.id += 1;
  send({ name: drag.name, value: Number(value), id: drag.id });
}

function tell() {
  const { value } = drag.field;
  if (value === drag.sent) return;
  const isLost = performance.now() - drag.sentAt > MOST_WAIT_MS;
  if (!drag.isAnswered && !isLost) return;
  Object.assign(drag, { sent: value, isAnswered: false, sentAt: performance.now() });
  sendNext(value);
}

function watch() {
  if (!drag.field) return;
  if (drag.field.isConnected) tell();
  requestAnimationFrame(watch);
}

function begin(event) {
  const slider = event.target instanceof Element ? event.target.closest(SLIDER) : null;
  const field = slider?.querySelector('input[type="range"]');
  const name = field && !field.disabled ? nameOf(slider) : "";
  if (!name || event.button !== 0) return;
  Object.assign(drag, { field, name, start: field.value, sent: field.value });
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

// The sliders that show what the page was not drawn for: [name, value, step].
function ahead() {
  return [...document.querySelectorAll(`${SLIDER} input[type="range"]`)]
    .map((field) => [nameOf(field), Number(field.value), Number(field.step)])
    .filter(([name, value, step]) => name in drawn && Math.abs(value - drawn[name]) > ALIKE * step);
}

function text(name, value) {
  return `${labels[name]} ${Number(value.toFixed(6))}`;
}

// Says of which settings numbers are that are not of what the sliders show. The tables know it
// themselves, as the page is drawn part by part.
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
  for (const part of main.querySelectorAll(".nv-of")) {
    const of = JSON.parse(part.dataset.of);
    const others = sliders
      .map(([name, value, step]) => [name, of[name] ?? drawn[name], value, step])
      .filter(([, own, value, step]) => Math.abs(own - value) > ALIKE * step);
    const words = others.map(([name, own]) => text(name, own)).join(", ");
    if (part.textContent !== words) part.textContent = words;
    part.closest('[data-testid="stElementContainer"]')
      ?.toggleAttribute("data-nv-now", sliders.length > 0 && !words);
  }
}

export default function ({ data, setTriggerValue }) {
  ({ labels, drawn } = data);
  send = (value) => setTriggerValue("drag", value);
  if (data.answered >= drag.id) drag.isAnswered = true;
  mark();
  if (window.nvcoreDragging) return;
  window.nvcoreDragging = true;
  document.addEventListener("pointerdown", begin, { capture: true });
  for (const name of ["pointerup", "pointercancel"]) document.addEventListener(name, end, { capture: true });
  // told before anything of the change is painted
  new MutationObserver(mark).observe(document.querySelector('[data-testid="stApp"]'), {
    subtree: true, childList: true, attributeFilter: ["value", "aria-valuetext"],
  });
}
