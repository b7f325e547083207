// Boxes on a picture. Colour is never the only sign: each system has its line, truth is thin; a miss has
// corner marks and a filled tag, a false alarm is crossed out.

import { DETECTION_STATE, SOURCE, TRUTH_STATE } from "../data/boxes.js";
import { LEAST_INSIDE, Labels, PLACE } from "./labels.js";

export const HALO = "rgba(0, 0, 0, 0.6)";
const FAINT_DASH = [2, 3];

export function strokeRect(ctx, box, style) {
  const { colour, width = 2, dash = [], alpha = 1 } = style;
  ctx.globalAlpha = alpha;
  ctx.setLineDash(dash);
  ctx.lineWidth = width + 2;
  ctx.strokeStyle = HALO;
  ctx.strokeRect(box.x, box.y, box.w, box.h);
  ctx.lineWidth = width;
  ctx.strokeStyle = colour;
  ctx.strokeRect(box.x, box.y, box.w, box.h);
  ctx.setLineDash([]);
  ctx.globalAlpha = 1;
}

function strokeCross(ctx, box, style) {
  const draw = (width, colour) => {
    ctx.lineWidth = width;
    ctx.strokeStyle = colour;
    ctx.beginPath();
    ctx.moveTo(box.x, box.y);
    ctx.lineTo(box.x + box.w, box.y + box.h);
    ctx.moveTo(box.x + box.w, box.y);
    ctx.lineTo(box.x, box.y + box.h);
    ctx.stroke();
  };
  ctx.globalAlpha = 0.8;
  ctx.setLineDash(style.dash ?? []);
  draw(2.5, HALO);
  draw(1.25, style.colour);
  ctx.setLineDash([]);
  ctx.globalAlpha = 1;
}

// Corner marks around a missed pedestrian; the left ones in one colour, the right ones in another.
function strokeCorners(ctx, box, left, right) {
  const gap = 3;
  const x0 = box.x - gap, y0 = box.y - gap, x1 = box.x + box.w + gap, y1 = box.y + box.h + gap;
  const arm = Math.max(5, Math.min(16, 0.35 * Math.min(x1 - x0, y1 - y0)));
  const side = (x, inward) => {
    ctx.beginPath();
    ctx.moveTo(x + inward * arm, y0);
    ctx.lineTo(x, y0);
    ctx.lineTo(x, y0 + arm);
    ctx.moveTo(x, y1 - arm);
    ctx.lineTo(x, y1);
    ctx.lineTo(x + inward * arm, y1);
    ctx.stroke();
  };
  for (const [width, isHalo] of [[5.5, true], [3.5, false]]) {
    ctx.lineWidth = width;
    ctx.strokeStyle = isHalo ? HALO : left;
    side(x0, 1);
    ctx.strokeStyle = isHalo ? HALO : right;
    side(x1, -1);
  }
}

function fillTriangle(ctx, x, y, colour) {
  ctx.beginPath();
  ctx.moveTo(x - 7, y - 11);
  ctx.lineTo(x + 7, y - 11);
  ctx.lineTo(x, y);
  ctx.closePath();
  ctx.lineWidth = 3;
  ctx.strokeStyle = "#0B0E13";
  ctx.stroke();
  ctx.fillStyle = colour;
  ctx.fill();
  ctx.lineWidth = 1;
  ctx.strokeStyle = "#FFFFFF";
  ctx.stroke();
}

function detectionStyle(system, state, palette) {
  const style = { colour: palette[system], dash: palette.dash[system], width: 2 };
  if (state === DETECTION_STATE.absorbed) return { ...style, width: 1, alpha: 0.55 };
  return style;
}

function truthStyle(state, palette) {
  if (state & TRUTH_STATE.ignore) return { colour: palette.truth, width: 1, dash: FAINT_DASH, alpha: 0.5 };
  if (!(state & TRUTH_STATE.relevant)) return { colour: palette.truth, width: 1, dash: FAINT_DASH, alpha: 0.8 };
  return { colour: palette.truth, width: 1.25 };
}

// Which of the two systems miss this truth box: "", "x", "y" or "xy".
export function missedBy(state) {
  if (state & TRUTH_STATE.ignore || !(state & TRUTH_STATE.relevant)) return "";
  return unmatchedBy(state);
}

function unmatchedBy(state) {
  return (state & TRUTH_STATE.matched_x ? "" : "x") + (state & TRUTH_STATE.matched_y ? "" : "y");
}

// One row's counts for the legend above the picture.
export function countStates(found) {
  const counts = {
    truth: 0, relevant: 0, missed_x: 0, missed_y: 0, far_x: 0, far_y: 0, false_x: 0, false_y: 0,
  };
  if (!found) return counts;
  const { boxes } = found;
  for (let i = found.start; i < found.stop; i += 1) {
    const state = boxes.state[i];
    if (boxes.source[i] === SOURCE.truth) {
      if (state & TRUTH_STATE.ignore) continue;
      const isRelevant = state & TRUTH_STATE.relevant;
      counts.truth += 1;
      if (isRelevant) counts.relevant += 1;
      for (const system of unmatchedBy(state)) counts[`${isRelevant ? "missed" : "far"}_${system}`] += 1;
    } else if (state === DETECTION_STATE.false_alarm) {
      if (boxes.source[i] === SOURCE.x) counts.false_x += 1;
      else counts.false_y += 1;
    }
  }
  return counts;
}

function drawDetections(ctx, list, system, palette) {
  for (const box of list) {
    const style = detectionStyle(system, box.state, palette);
    strokeRect(ctx, box, style);
    if (box.state === DETECTION_STATE.false_alarm) strokeCross(ctx, box, style);
  }
}

// The tag of a missed pedestrian, in full and short.
function missTags(missed, track, palette) {
  const part = (system, text) => ({ text, colour: "#0B0E13", ground: palette[system] });
  const name = track ? [{ text: track, colour: palette.truth }] : [];
  const short = [...missed].map((system) => part(system, system.toUpperCase()));
  const last = missed[missed.length - 1];
  const full = [...short.slice(0, -1), part(last, `${last.toUpperCase()} missed`)];
  return [[...full, ...name], [...short, ...name]];
}

// found: from BoxStore.ofRow; place: {scale, x, y} from the recording's pixels to the canvas's;
// area: the part of the canvas that shows the picture.
export function drawBoxes(ctx, found, place, layers, palette, area) {
  const lists = { truth: [], x: [], y: [] };
  const names = ["truth", "x", "y"];
  const { boxes } = found;
  for (let i = found.start; i < found.stop; i += 1) {
    const box = {
      x: place.x + place.scale * boxes.x[i], y: place.y + place.scale * boxes.y[i],
      w: place.scale * boxes.w[i], h: place.scale * boxes.h[i],
      score: boxes.score[i], track: boxes.track[i], state: boxes.state[i],
    };
    const isInside = box.x < area.x + area.w && box.y < area.y + area.h
      && box.x + box.w > area.x && box.y + box.h > area.y;
    if (isInside) lists[names[boxes.source[i]]].push(box);
  }
  // a layer that is off hides its boxes and its misses; the truth off hides every miss
  if (layers.truth) for (const box of lists.truth) strokeRect(ctx, box, truthStyle(box.state, palette));
  if (layers.x) drawDetections(ctx, lists.x, "x", palette);
  if (layers.y) drawDetections(ctx, lists.y, "y", palette);
  const shownMiss = (box) => [...missedBy(box.state)].filter((system) => layers[system]).join("");
  const missed = layers.truth ? lists.truth.filter((box) => shownMiss(box) !== "") : [];
  for (const box of missed) {
    const systems = shownMiss(box);
    strokeCorners(ctx, box, palette[systems[0]], palette[systems[systems.length - 1]]);
  }
  const labels = new Labels(ctx, area, missed);
  missed.sort((a, b) => b.h - a.h); // the nearest have the first choice of places
  const tags = new Map();
  for (const box of missed) {
    const track = layers.labels ? trackText(box) : "";
    tags.set(box, labels.putTag(missTags(shownMiss(box), track, palette), box));
  }
  for (const box of layers.truth ? lists.truth : []) {
    const systems = ["x", "y"].filter((name) => layers[name] && box.state & TRUTH_STATE[`salient_${name}`]);
    if (!systems.length) continue;
    const colour = systems.length === 1 ? palette[systems[0]] : palette.truth;
    markSalient(labels, box, tags.get(box) ?? box, colour);
  }
  if (layers.labels) drawLabels(labels, lists, layers, palette, tags);
}

// A triangle above the box and its tag, else beside the tag.
function markSalient(labels, box, tag, colour) {
  const [w, h] = [18, 14];
  const top = Math.min(tag.y, box.y - 1);
  const places = [
    [box.x + (box.w - w) / 2, top - h - 1], [tag.x + (tag.w - w) / 2, top - h - 1],
    [tag.x + tag.w + 1, tag.y], [tag.x - w - 1, tag.y],
  ];
  const rect = labels.reserve(places, w, h);
  fillTriangle(labels.ctx, rect.x + w / 2, rect.y + 12, colour);
}

function trackText(box) {
  return box.track >= 0 ? `#${box.track}` : "";
}

// What is not missed: scores, tracks and ignored regions, where there is room.
function drawLabels(labels, lists, layers, palette, tags) {
  const around = (box, share, text) => {
    const isRoomy = box.h >= LEAST_INSIDE && box.w >= labels.widthOf(text) + 4;
    const inside = isRoomy ? [PLACE.inside(box, share)] : [];
    const near = [PLACE.above(box, share, 1), PLACE.below(box, share, 1)];
    // beyond the marks of a missed pedestrian in the same place
    return [...near, ...inside, PLACE.above(box, share, 7), PLACE.below(box, share, 7)];
  };
  // false alarms first: there is nothing else by which to know them
  for (const isFalse of [true, false]) {
    for (const system of ["x", "y"]) {
      const share = "xy".indexOf(system);
      for (const box of layers[system] ? lists[system] : []) {
        if ((box.state === DETECTION_STATE.false_alarm) !== isFalse) continue;
        const score = Number.isFinite(box.score) ? ` ${box.score.toFixed(2)}` : "";
        const text = `${system.toUpperCase()}${isFalse ? " false" : ""}${score}`;
        labels.put([{ text, colour: palette[system] }], around(box, share, text));
      }
    }
  }
  for (const box of layers.truth ? lists.truth : []) {
    const text = box.state & TRUTH_STATE.ignore ? "ignored" : trackText(box);
    if (!text || tags.has(box)) continue;
    labels.put([{ text, colour: palette.truth }], [PLACE.below(box, 0.5, 1), PLACE.above(box, 0.5, 1)]);
  }
}
