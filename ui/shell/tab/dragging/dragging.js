// Parameters act while their slider is dragged: Streamlit itself tells Python only of the release.
// One value is on its way at a time, then the newest: runs never pile up.

const SLIDER = '[data-testid="stSidebar"] [data-testid="stSlider"]';
const MOST_WAIT_MS = 5000; // for an answer that was lost

const drag = { field: null, name: "", start: "", sent: "", id: 0, sentAt: 0, isAnswered: true };
let released = null; // the field of a slider that was let go while a value was on its way
let names = [];
let send = () => {};

function nameOf(slider) {
  const classes = slider.closest('[class*="st-key-"]')?.classList ?? [];
  const keys = [...classes].filter((name) => name.startsWith("st-key-")).map((name) => name.slice("st-key-".length));
  return keys.find((key) => names.includes(key)) ?? "";
}

function tell() {
  const { value } = drag.field;
  if (value === drag.sent) return;
  const isLost = performance.now() - drag.sentAt > MOST_WAIT_MS;
  if (!drag.isAnswered && !isLost) return;
  drag.sent = value;
  drag.id += 1;
  drag.isAnswered = false;
  drag.sentAt = performance.now();
  send({ name: drag.name, value: Number(value), id: drag.id });
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
  released = null;
  Object.assign(drag, { field, name, start: field.value, sent: field.value });
  requestAnimationFrame(watch);
}

function sendLast(value) {
  drag.id += 1;
  send({ name: drag.name, value: Number(value), id: drag.id });
}

// What is let go is told by Streamlit, unless it ends where it began and so is no change. A value
// that is on its way then may arrive with it and hold in its place: the last one follows that.
function end() {
  const { field, start, sent } = drag;
  if (!field) return;
  requestAnimationFrame(() => {
    drag.field = null;
    if (field.value === start) {
      if (sent !== start) sendLast(start);
    } else if (!drag.isAnswered && field.value !== sent) {
      released = field;
    }
  });
}

export default function ({ data, setTriggerValue }) {
  names = data.names;
  send = (value) => setTriggerValue("drag", value);
  if (data.answered >= drag.id) drag.isAnswered = true;
  if (drag.isAnswered && released) {
    if (released.isConnected) sendLast(released.value);
    released = null;
  }
  if (window.nvcoreDragging) return;
  window.nvcoreDragging = true;
  document.addEventListener("pointerdown", begin, { capture: true });
  for (const name of ["pointerup", "pointercancel"]) document.addEventListener(name, end, { capture: true });
}
