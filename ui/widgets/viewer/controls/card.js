// What made this number: a card with nvcore's words on the boxes below the pointer, or on the one
// that was chosen.

import { make, worded } from "./elements.js";
import { SOURCE, TRUTH_STATE } from "../data/boxes.js";
import { inPane } from "../data/look.js";

const MOST_CARDS = 3;
const REACH_PX = 3; // a thin box is hit a little beside its line
const REST_MS = 60; // so long the pointer rests before anything is asked

// Boxes below a point of the canvas, as numbers within the row: truth first, small before large.
function boxesAt(viewer, pointOfCanvas) {
  const point = inPane(viewer, pointOfCanvas);
  const found = viewer.shown?.found;
  if (!found) return [];
  const { scale, x, y } = viewer.view.place;
  const { boxes } = found;
  const layers = ["truth", "x", "y"];
  const hits = [];
  for (let i = found.start; i < found.stop; i += 1) {
    if (!viewer.layers[layers[boxes.source[i]]]) continue;
    const left = x + scale * boxes.x[i], top = y + scale * boxes.y[i];
    const isInside = point.x >= left - REACH_PX && point.x <= left + scale * boxes.w[i] + REACH_PX
      && point.y >= top - REACH_PX && point.y <= top + scale * boxes.h[i] + REACH_PX;
    if (isInside) hits.push({ index: i - found.start, source: boxes.source[i], area: boxes.w[i] * boxes.h[i] });
  }
  hits.sort((a, b) => Number(a.source !== 0) - Number(b.source !== 0) || a.area - b.area);
  return hits.map((hit) => hit.index);
}

export class Card {
  constructor(viewer) {
    this.viewer = viewer;
    this.part = make("div", { class: "card", hidden: "" });
    viewer.parts.stage.append(this.part);
    this.timer = 0;
    this.shownKey = "";
  }

  // point: of the canvas, where the pointer rests; null: it has left
  point(point) {
    clearTimeout(this.timer);
    const { viewer } = this;
    const indices = point && !viewer.playing ? boxesAt(viewer, point) : [];
    viewer.parts.picture.classList.toggle("pointed", indices.length > 0);
    if (indices.length === 0) {
      this.hide();
      return;
    }
    this.timer = setTimeout(() => this.show(indices, point), REST_MS);
  }

  async show(indices, point) {
    const { viewer } = this;
    const { row } = viewer.shown;
    const reasons = await viewer.reasons.ofRow(row);
    const found = viewer.shown?.found;
    const isCurrent = viewer.shown?.row === row && found && reasons?.length === found.stop - found.start;
    if (!isCurrent || viewer.playing) return null;
    // what a detection is matched to says it all
    const told = indices.filter((index) => !indices.includes(reasons[index].truth)).slice(0, MOST_CARDS);
    const key = `${row} ${told}`;
    if (key !== this.shownKey || this.part.hidden) {
      this.part.replaceChildren(...told.map((index) => makeReason(reasons[index])));
      this.part.hidden = false;
      this.shownKey = key;
    }
    this.place(point);
    return told.map((index) => reasons[index]);
  }

  // Beside the point, inside the picture.
  place(point) {
    const { stage } = this.viewer.parts;
    const [w, h, gap] = [this.part.offsetWidth, this.part.offsetHeight, 16];
    const right = point.x + gap + w <= stage.clientWidth ? point.x + gap : point.x - gap - w;
    this.part.style.left = `${Math.max(4, Math.min(stage.clientWidth - w - 4, right))}px`;
    this.part.style.top = `${Math.max(4, Math.min(stage.clientHeight - h - 4, point.y + gap))}px`;
  }

  hide() {
    clearTimeout(this.timer);
    this.part.hidden = true;
  }
}

function makeReason({ title, lines }) {
  return make("section", {}, [
    make("strong", { text: title }), make("ul", {}, lines.map((text) => make("li", { text }))),
  ]);
}

// ---- choosing

// The pedestrian of the topmost box below the point becomes the chosen one, here and everywhere.
export async function chooseAt(viewer, point) {
  const indices = boxesAt(viewer, point);
  if (indices.length === 0) return;
  const reasons = await viewer.card.show(indices, point);
  const reason = reasons?.find(({ encounter }) => encounter >= 0);
  if (reason) choose(viewer, reason);
}

// By key: the next pedestrian of the frame, from left to right.
export async function chooseNext(viewer, direction) {
  const found = viewer.shown?.found;
  if (!found) return;
  const { boxes, start, stop } = found;
  const truth = [];
  for (let i = start; i < stop; i += 1) {
    if (boxes.source[i] === SOURCE.truth && !(boxes.state[i] & TRUTH_STATE.ignore)) truth.push(i - start);
  }
  if (truth.length === 0) {
    viewer.say(worded("{Nobody} is annotated in this frame", viewer.sent.words));
    return;
  }
  truth.sort((a, b) => boxes.x[start + a] - boxes.x[start + b]);
  const before = truth.findIndex((index) => boxes.track[start + index] === viewer.chosen);
  const first = direction > 0 ? 0 : truth.length - 1;
  const index = truth[before < 0 ? first : (before + direction + truth.length) % truth.length];
  const { scale, x, y } = viewer.view.place;
  const at = start + index;
  markAs(viewer, boxes.track[at]); // at once: the next press goes on from here
  const point = { x: x + scale * (boxes.x[at] + boxes.w[at]), y: y + scale * boxes.y[at] };
  const reasons = await viewer.card.show([index], point);
  if (!reasons) return;
  viewer.say([reasons[0].title, ...reasons[0].lines].join(". "));
  choose(viewer, reasons[0]);
}

function choose(viewer, { encounter, track }) {
  markAs(viewer, track);
  viewer.reportChosen(encounter);
}

function markAs(viewer, track) {
  viewer.chosen = track >= 0 ? track : null;
  viewer.isStale = true;
  viewer.wake();
}
