// Boxes on a picture. Colour is never the only sign: X is solid, Y dashed, truth thin; a miss has
// corner marks and a filled tag, a false alarm is crossed out.

const HALO = "rgba(0, 0, 0, 0.6)";
const LABEL_GROUND = "rgba(8, 11, 16, 0.72)";
const LABEL_FONT = '600 12px "Source Sans", "Source Sans Pro", sans-serif';
const LABEL_HEIGHT = 15;
const Y_DASH = [6, 4];
const FAINT_DASH = [2, 3];

function strokeRect(ctx, box, style) {
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

// Labels keep off each other: the first free of their places is taken; an unimportant label that
// finds none is left out.
class Labels {
  constructor(ctx, width, height) {
    this.ctx = ctx;
    this.width = width;
    this.height = height;
    this.taken = [];
    ctx.font = LABEL_FONT;
    ctx.textBaseline = "middle";
  }

  // parts: [{text, colour, ground}]; places: [[left, top]...] with left as a share of the label
  put(parts, places, isImportant = false) {
    const widths = parts.map((part) => this.ctx.measureText(part.text).width + 8);
    const width = widths.reduce((sum, value) => sum + value, 0);
    const rects = places.map(([x, y, share = 0]) => ({
      x: Math.max(0, Math.min(this.width - width, x - share * width)),
      y: Math.max(0, Math.min(this.height - LABEL_HEIGHT, y)),
      w: width, h: LABEL_HEIGHT,
    }));
    const isFree = (rect) => this.taken.every((other) =>
      rect.x >= other.x + other.w || other.x >= rect.x + rect.w
      || rect.y >= other.y + other.h || other.y >= rect.y + rect.h);
    const rect = rects.find(isFree) ?? (isImportant ? rects[0] : null);
    if (!rect) return null;
    this.taken.push(rect);
    let x = rect.x;
    parts.forEach((part, index) => {
      this.ctx.fillStyle = part.ground ?? LABEL_GROUND;
      this.ctx.fillRect(x, rect.y, widths[index], LABEL_HEIGHT);
      this.ctx.fillStyle = part.colour;
      this.ctx.fillText(part.text, x + 4, rect.y + LABEL_HEIGHT / 2 + 0.5);
      x += widths[index];
    });
    return rect;
  }
}

function detectionStyle(system, state, palette) {
  const style = { colour: palette[system], dash: system === "y" ? Y_DASH : [], width: 2 };
  if (state === DETECTION_STATE.absorbed) return { ...style, width: 1, alpha: 0.55 };
  return style;
}

function truthStyle(state, palette) {
  if (state & TRUTH_STATE.ignore) return { colour: palette.truth, width: 1, dash: FAINT_DASH, alpha: 0.5 };
  if (!(state & TRUTH_STATE.relevant)) return { colour: palette.truth, width: 1, dash: FAINT_DASH, alpha: 0.8 };
  return { colour: palette.truth, width: 1.25 };
}

// Which of the two systems miss this truth box: "", "x", "y" or "xy".
function missedBy(state) {
  if (state & TRUTH_STATE.ignore || !(state & TRUTH_STATE.relevant)) return "";
  return (state & TRUTH_STATE.matched_x ? "" : "x") + (state & TRUTH_STATE.matched_y ? "" : "y");
}

// One row's counts for the legend above the picture.
function countStates(found) {
  const counts = { truth: 0, relevant: 0, missed_x: 0, missed_y: 0, false_x: 0, false_y: 0 };
  if (!found) return counts;
  const { boxes } = found;
  for (let i = found.start; i < found.stop; i += 1) {
    const state = boxes.state[i];
    if (boxes.source[i] === SOURCE.truth) {
      const missed = missedBy(state);
      if (!(state & TRUTH_STATE.ignore)) counts.truth += 1;
      if (!(state & TRUTH_STATE.ignore) && state & TRUTH_STATE.relevant) counts.relevant += 1;
      if (missed.includes("x")) counts.missed_x += 1;
      if (missed.includes("y")) counts.missed_y += 1;
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

function missTag(missed, palette) {
  const dark = "#0B0E13";
  const part = (system, text) => ({ text, colour: dark, ground: palette[system] });
  if (missed === "xy") return [part("x", "X"), part("y", "Y missed")];
  return [part(missed, missed === "x" ? "X missed" : "Y missed")];
}

// found: from BoxStore.ofRow; place: {scale, x, y} from the recording's pixels to the canvas's.
function drawBoxes(ctx, found, place, layers, palette, size) {
  const lists = { truth: [], x: [], y: [] };
  const names = ["truth", "x", "y"];
  const { boxes } = found;
  for (let i = found.start; i < found.stop; i += 1) {
    const box = {
      x: place.x + place.scale * boxes.x[i], y: place.y + place.scale * boxes.y[i],
      w: place.scale * boxes.w[i], h: place.scale * boxes.h[i],
      score: boxes.score[i], track: boxes.track[i], state: boxes.state[i],
    };
    const isInside = box.x < size.width && box.y < size.height && box.x + box.w > 0 && box.y + box.h > 0;
    if (isInside) lists[names[boxes.source[i]]].push(box);
  }
  // a layer that is off hides its boxes and its misses; the truth off hides every miss
  if (layers.truth) for (const box of lists.truth) strokeRect(ctx, box, truthStyle(box.state, palette));
  if (layers.x) drawDetections(ctx, lists.x, "x", palette);
  if (layers.y) drawDetections(ctx, lists.y, "y", palette);
  const labels = new Labels(ctx, size.width, size.height);
  const shownMiss = (box) => [...missedBy(box.state)].filter((system) => layers[system]).join("");
  const missed = layers.truth ? lists.truth.filter((box) => shownMiss(box) !== "") : [];
  for (const box of missed) {
    const systems = shownMiss(box);
    strokeCorners(ctx, box, palette[systems[0]], palette[systems[systems.length - 1]]);
  }
  const tops = new Map();
  for (const box of missed) {
    const centre = box.x + box.w / 2;
    const places = [[centre, box.y - LABEL_HEIGHT - 6, 0.5], [centre, box.y + box.h + 6, 0.5]];
    tops.set(box, labels.put(missTag(shownMiss(box), palette), places, true).y);
  }
  for (const box of layers.truth ? lists.truth : []) {
    const systems = ["x", "y"].filter((name) => layers[name] && box.state & TRUTH_STATE[`salient_${name}`]);
    if (!systems.length) continue;
    const colour = systems.length === 1 ? palette[systems[0]] : palette.truth;
    const top = Math.min(tops.get(box) ?? box.y, box.y);
    const rect = { x: box.x + box.w / 2 - 9, y: Math.max(1, top - 15), w: 18, h: 14 };
    labels.taken.push(rect);
    fillTriangle(ctx, rect.x + 9, rect.y + 12, colour);
  }
  if (layers.labels) drawLabels(labels, lists, layers, palette);
}

function drawLabels(labels, lists, layers, palette) {
  const score = (box, system) => {
    const name = system.toUpperCase();
    const isFalse = box.state === DETECTION_STATE.false_alarm;
    const value = Number.isFinite(box.score) ? ` ${box.score.toFixed(2)}` : "";
    return [{ text: `${name}${isFalse ? " false" : ""}${value}`, colour: palette[system] }];
  };
  const above = (box) => box.y - LABEL_HEIGHT - 1;
  const below = (box) => box.y + box.h + 1;
  // false alarms first: there is nothing else by which to know them
  for (const isFalse of [true, false]) {
    for (const [system, share] of [["x", 0], ["y", 1]]) {
      if (!layers[system]) continue;
      for (const box of lists[system]) {
        if ((box.state === DETECTION_STATE.false_alarm) !== isFalse) continue;
        const edge = box.x + share * box.w;
        const inside = box.w > 70 && box.h > 40 ? [[edge, box.y + 2, share]] : [];
        const places = [[edge, above(box), share], [edge, below(box), share], ...inside];
        labels.put(score(box, system), places, isFalse);
      }
    }
  }
  if (!layers.truth) return;
  for (const box of lists.truth) {
    const isIgnored = box.state & TRUTH_STATE.ignore;
    const track = box.track >= 0 ? `#${box.track}` : "";
    const text = isIgnored ? "ignored" : track;
    const style = { text, colour: palette.truth };
    const centre = box.x + box.w / 2;
    if (text) labels.put([style], [[centre, below(box), 0.5], [centre, above(box), 0.5]]);
  }
}
