// Keys, mouse and touch of a viewer.

import { chooseAt, chooseNext } from "./card.js";
import { inPane } from "../data/look.js";

// Where keys are typed text or choose among things: they are never the viewer's. Tables are a canvas.
const TYPING = 'canvas, input:not([type="range"], [type="checkbox"], [type="radio"]), textarea, select, '
  + '[contenteditable="true"], [role="textbox"], [role="combobox"], [role="searchbox"], [role="spinbutton"], '
  + '[aria-haspopup="listbox"], [role="grid"], [role="listbox"], [role="menu"], [role="dialog"]';
// What has arrows, space, Home and End for itself; letters it leaves to the viewer.
const CONTROL = 'input, a[href], button, summary, [role="slider"], [role="button"], [role="tab"], [role="radio"], '
  + '[role="checkbox"], [role="switch"]';

const CLICK_PX = 4; // a press that moves less is a click

export function listen(viewer) {
  const { root, parts } = viewer;
  viewer.observer = new ResizeObserver(() => viewer.wake());
  viewer.observer.observe(parts.stage);
  viewer.observer.observe(parts.stripHolder);
  if (!viewer.isSteered) return;
  root.addEventListener("keydown", (event) => onKey(viewer, event));
  viewer.onPageKey = (event) => onPageKey(viewer, event);
  document.addEventListener("keydown", viewer.onPageKey);
  // after a click the keys belong to the viewer again, not to the button
  parts.bar.addEventListener("click", (event) => returnFocus(viewer, event));
  parts.legend.addEventListener("click", (event) => returnFocus(viewer, event));
  parts.speed.addEventListener("change", () => root.focus({ preventScroll: true }));
  parts.labels.setAttribute("aria-pressed", "true");
  listenToStrip(viewer);
  listenToPicture(viewer);
}

function returnFocus(viewer, event) {
  const isByPointer = event.detail > 0;
  if (isByPointer && !viewer.help && event.target.tagName !== "SELECT") viewer.root.focus({ preventScroll: true });
}

// A key that was pressed elsewhere on the page, with the picture in sight.
function onPageKey(viewer, event) {
  const { root, parts } = viewer;
  const [target] = event.composedPath();
  if (event.defaultPrevented || !root.isConnected || event.composedPath().includes(root)) return;
  const { top, height } = parts.stage.getBoundingClientRect();
  const middle = top + height / 2;
  if (middle < 0 || middle > window.innerHeight || !(target instanceof Element)) return;
  if (target.closest(TYPING)) return;
  const isLetter = event.key.length === 1 && event.key !== " ";
  const isOthers = target.closest(CONTROL) !== null || ["Home", "End"].includes(event.key); // those scroll
  if (isLetter || !isOthers) onKey(viewer, event);
}

function onKey(viewer, event) {
  if (event.ctrlKey || event.metaKey || event.altKey) return;
  if (event.target.type === "range" && event.key.length > 1) {
    event.stopPropagation(); // arrows, Home and End move the slider
    return;
  }
  const isControl = ["BUTTON", "SELECT"].includes(event.target.tagName);
  if (isControl && [" ", "Enter"].includes(event.key)) {
    event.stopPropagation(); // the control's own key
    return;
  }
  if (event.target.tagName === "SELECT" && event.key.length > 1) return;
  // while a list is walked through they are the page's
  if (viewer.sent?.listed && !event.shiftKey && ["n", "p"].includes(event.key)) return;
  const { recording, row } = viewer;
  const sign = event.key === "ArrowLeft" ? -1 : 1;
  const actions = {
    " ": () => viewer.playPause(),
    ArrowLeft: () => viewer.goTo(event.shiftKey ? recording.rowAfter(row, sign) : row + sign),
    ArrowRight: () => viewer.goTo(event.shiftKey ? recording.rowAfter(row, sign) : row + sign),
    Home: () => viewer.goTo(0),
    End: () => viewer.goTo(recording.nRows - 1),
    n: () => viewer.goToMiss(1),
    p: () => viewer.goToMiss(-1),
    x: () => viewer.toggle("x"),
    y: () => viewer.toggle("y"),
    g: () => viewer.toggle("truth"),
    l: () => viewer.toggle("labels"),
    c: () => viewer.cost.isKnown && viewer.toggle("cost"),
    f: () => viewer.fit(),
    b: () => viewer.light.isPossible && viewer.toggleLight(),
    t: () => viewer.toggleFollow(),
    v: () => viewer.nextLook(),
    d: () => viewer.toggleAdapting(),
    k: () => chooseNext(viewer, event.shiftKey ? -1 : 1),
    "+": () => viewer.zoomStep(1),
    "-": () => viewer.zoomStep(-1),
    "?": () => viewer.toggleHelp(),
    Escape: () => viewer.escape(),
  };
  const act = actions[event.key.length === 1 ? event.key.toLowerCase() : event.key];
  if (!act || !recording || recording.nRows === 0) return;
  if (event.key === "Escape" && !viewer.hasOpen) return;
  event.preventDefault();
  event.stopPropagation();
  act();
}

function listenToStrip(viewer) {
  const { strip, tip, stripHolder } = viewer.parts;
  const rowAt = (event) => viewer.strip.rowAt(event.clientX - strip.getBoundingClientRect().left);
  const hover = (event) => {
    if (!viewer.recording?.nRows) return;
    const row = rowAt(event);
    viewer.hoverRow = row;
    const { recording } = viewer;
    const place = `frame ${recording.frames[row]} · ${recording.timeText(row)}`;
    tip.textContent = `${place} · ${viewer.strip.valuesText(row)}`;
    tip.hidden = false;
    const half = tip.offsetWidth / 2;
    const x = event.clientX - stripHolder.getBoundingClientRect().left;
    tip.style.left = `${Math.max(half, Math.min(stripHolder.clientWidth - half, x))}px`;
    viewer.wake();
  };
  const leave = () => {
    viewer.hoverRow = null;
    tip.hidden = true;
    viewer.wake();
  };
  strip.addEventListener("pointerdown", (event) => {
    if (event.button !== 0 || !viewer.recording?.nRows) return;
    strip.setPointerCapture(event.pointerId);
    viewer.root.focus({ preventScroll: true });
    event.preventDefault();
    viewer.isDragging = true;
    viewer.goTo(rowAt(event));
  });
  strip.addEventListener("pointermove", (event) => {
    hover(event);
    if (viewer.isDragging && rowAt(event) !== viewer.row) viewer.goTo(rowAt(event));
  });
  const release = () => {
    if (!viewer.isDragging) return;
    viewer.isDragging = false;
    viewer.goTo(viewer.row);
  };
  strip.addEventListener("pointerup", release);
  strip.addEventListener("pointercancel", release);
  strip.addEventListener("pointerleave", leave);
}

function listenToPicture(viewer) {
  const { picture, stage } = viewer.parts;
  const pointOf = (event) => {
    const { left, top } = stage.getBoundingClientRect();
    return { x: event.clientX - left, y: event.clientY - top };
  };
  let last = null; // while the picture is dragged
  let start = null; // where the button went down
  picture.addEventListener("pointerdown", (event) => {
    viewer.root.focus({ preventScroll: true });
    event.preventDefault();
    if (event.button !== 0) return;
    start = pointOf(event);
    if (viewer.view.zoom === 1) return;
    picture.setPointerCapture(event.pointerId);
    last = start;
  });
  picture.addEventListener("pointermove", (event) => {
    const point = pointOf(event);
    if (!last) {
      viewer.card.point(point);
      return;
    }
    viewer.card.hide();
    viewer.moveBy(point.x - last.x, point.y - last.y);
    last = point;
  });
  const release = () => {
    last = null;
    start = null;
  };
  picture.addEventListener("pointerup", (event) => {
    const point = pointOf(event);
    const isClick = start && Math.hypot(point.x - start.x, point.y - start.y) < CLICK_PX;
    release();
    if (isClick) chooseAt(viewer, point);
  });
  picture.addEventListener("pointercancel", release);
  picture.addEventListener("pointerleave", () => viewer.card.point(null));
  picture.addEventListener("dblclick", (event) => {
    if (viewer.view.zoom > 1) viewer.fit();
    else viewer.zoomTo(3, inPane(viewer, pointOf(event)));
  });
  picture.addEventListener("wheel", (event) => {
    const isFull = viewer.root.getRootNode().fullscreenElement === viewer.root;
    if (!event.ctrlKey && !isFull) return; // the page scrolls
    event.preventDefault();
    viewer.zoomTo(viewer.view.zoom * Math.exp(-event.deltaY / 400), inPane(viewer, pointOf(event)));
  }, { passive: false });
}
