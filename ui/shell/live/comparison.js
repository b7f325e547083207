// The comparison of X and Y, computed in the browser while a slider moves: the formulas of
// nvcore.metrics on the columns of `ui/session/packed_comparison.py`. Each step is computed anew
// only when one of the settings that it depends on has changed.

const ARRAYS = { f: Float64Array, i: Int32Array };
const RELEVANT_K = 0.5;
const SURE = 1e-9; // beyond it, which side of the midpoint a box is on needs no sigmoid
const MATCHED = -1; // in place of a cost
const LARGEST_EXPONENT = 700;
const UNEQUAL = 1.5; // as `nvcore.metrics.detection.operating_point`
const LEAST_MORE = 6;

function unpackColumns(buffer) {
  const length = new DataView(buffer).getUint32(0, true);
  const header = JSON.parse(new TextDecoder().decode(new Uint8Array(buffer, 4, length)));
  const start = 8 * Math.ceil((4 + length) / 8);
  return Object.fromEntries(header.map(([name, kind, place, n]) => [name, new ARRAYS[kind](buffer, start + place, n)]));
}

export function weigh(z) {
  return 1 / (1 + Math.exp(Math.min(Math.max(-z, -LARGEST_EXPONENT), LARGEST_EXPONENT)));
}

// Puts the n-th smallest of values at its place, all smaller ones before it (quickselect).
function select(values, n) {
  let low = 0;
  let high = values.length - 1;
  while (low < high) {
    const pivot = values[(low + high) >> 1];
    let i = low;
    let j = high;
    while (i <= j) {
      while (values[i] < pivot) i += 1;
      while (values[j] > pivot) j -= 1;
      if (i > j) break;
      const value = values[i];
      values[i++] = values[j];
      values[j--] = value;
    }
    if (n <= j) high = j;
    else if (n >= i) low = i;
    else return;
  }
}

// With linear interpolation, as numpy.
function percentile(values, share) {
  const copy = values.slice();
  const place = share * (copy.length - 1);
  const n = Math.floor(place);
  select(copy, n);
  let next = copy.length > n + 1 ? Infinity : copy[n];
  for (let i = n + 1; i < copy.length; i += 1) if (copy[i] < next) next = copy[i];
  return copy[n] + (next - copy[n]) * (place - n);
}

function sum(values) {
  let total = 0;
  for (let i = 0; i < values.length; i += 1) total += values[i];
  return total;
}

// Of each frame that is stale: how far each box is from the other set or the border, times the
// factor of its weight, beside its size; the farthest first. All of the distance of two sets that
// does not depend on the sigmoid, close together in memory.
function reachOf({ offsets, centre, size, metres, near, isMember, factor, reaches }, formula, start, stop, isStale) {
  const { width, least, slope } = formula;
  for (let f = start; f < stop; f += 1) {
    if (!isStale[f]) continue;
    const from = offsets[f];
    for (let i = from; i < offsets[f + 1]; i += 1) {
      const c = centre[i];
      const reach = isMember[i] ? factor[i] * Math.min(least + slope * Math.min(c, width - c), near[i]) : 0;
      let place = i;
      for (; place > from && reaches[3 * place - 3] < reach; place -= 1) reaches.copyWithin(3 * place, 3 * place - 3, 3 * place);
      reaches[3 * place] = reach;
      reaches[3 * place + 1] = size[i];
      reaches[3 * place + 2] = metres ? metres[i] : NaN;
    }
  }
}

// The largest weight times reach of the boxes of each frame that is stale. After the farthest few
// others can be more, as no weight is above 1, nor that of a box of less depth above that of the
// box before it: their sigmoids are not computed.
function maximin({ offsets, reaches }, formula, start, stop, isStale, result) {
  const { zero, spread, zeroM, spreadM, isFlat } = formula;
  for (let f = start; f < stop; f += 1) {
    if (!isStale[f]) continue;
    const end = 3 * offsets[f + 1];
    let most = 0;
    let weight = 1;
    let depth = -Infinity;
    for (let i = 3 * offsets[f]; i < end; i += 3) {
      const reach = reaches[i];
      if (reach <= most) break;
      const metres = reaches[i + 2];
      const z = Number.isNaN(metres) ? (reaches[i + 1] - zero) / spread : (zeroM - metres) / spreadM;
      if (z <= depth && weight * reach <= most) continue;
      weight = isFlat ? 1 : weigh(z);
      depth = z;
      if (weight * reach > most) most = weight * reach;
    }
    result[f] = most;
  }
}

// How many of values, the largest first, are not below a limit.
function countFrom(values, limit) {
  let [low, high] = [0, values.length];
  while (low < high) {
    const middle = (low + high) >> 1;
    if (values[middle] < limit) high = middle;
    else low = middle + 1;
  }
  return low;
}

function roundBetween(out, within) {
  for (let decimals = 2; decimals <= 6; decimals += 1) {
    const scale = 10 ** decimals;
    const step = Math.floor(out * scale) + 1;
    for (const candidate of [step / scale, (step + 1) / scale])
      if (out < candidate && candidate <= within) return candidate;
  }
  return null;
}

function boxesOf(columns, name) {
  const prefix = `${name}_`;
  const own = Object.entries(columns).filter(([column]) => column.startsWith(prefix));
  return Object.fromEntries(own.map(([column, values]) => [column.slice(prefix.length), values]));
}

class System {
  constructor(columns, letter, truth) {
    const own = boxesOf(columns, letter);
    Object.assign(this, own);
    const nFrames = own.offsets.length - 1;
    for (const boxes of [this, (this.ofTruth = { ...truth })]) {
      const n = boxes.size.length;
      boxes.near = new Float64Array(n).fill(Infinity);
      boxes.reaches = new Float64Array(3 * n);
      boxes.isMember = new Uint8Array(n).fill(boxes === this ? 0 : 1);
      boxes.factor ??= new Float64Array(n).fill(1);
    }
    this.isMatched = new Uint8Array(truth.size.length);
    this.isStale = new Uint8Array(nFrames);
    this.nAlarms = 0;
    for (const name of ["dMiss", "dFalse", "similarity"]) this[name] = new Float64Array(nFrames);
    const scores = (of) => own.score.filter(of).sort().reverse();
    this.scores = scores((score) => !Number.isNaN(score));
    this.alarms = scores((score, i) => own.match[i] < 0 && !Number.isNaN(score));
    this.hasScores = new Set(own.score.filter(Number.isFinite)).size > 1;
    this.keys = {};
  }

  // Whether the settings of a step have changed since it was last asked.
  isNew(step, ...settings) {
    const key = settings.join();
    const differs = this.keys[step] !== key;
    this.keys[step] = key;
    return differs;
  }

  // As `threshold_with_alarms` of nvcore; every detection counts above minus infinity.
  thresholdWithAlarms(target) {
    const { alarms, scores: [highest] } = this;
    if (!this.hasScores || !alarms.length) return -Infinity;
    let left = alarms[0] === highest ? Infinity : 0; // no false alarm would be no detection
    for (let n = 1; n <= alarms.length; n += 1)
      if ((n === alarms.length || alarms[n] !== alarms[n - 1]) && Math.abs(n - target) < Math.abs(left - target)) left = n;
    if (left === alarms.length) return -Infinity;
    const within = left ? alarms[left - 1] : highest;
    return roundBetween(alarms[left], within) ?? within;
  }
}

export class Comparison {
  // rules: proximity, pairing, coverage, and the operating point that is shown.
  constructor(buffer, rules) {
    this.columns = unpackColumns(buffer);
    this.rules = rules;
    const { gap, fps, width } = this.columns;
    this.nFrames = gap.length;
    this.truth = boxesOf(this.columns, "truth");
    this.x = new System(this.columns, "x", this.truth);
    this.y = new System(this.columns, "y", this.truth);
    this.stepS = new Float64Array(this.nFrames);
    this.halfWidth = new Float64Array(this.nFrames);
    this.ofRecordings((recording, start, stop) => {
      for (let f = start; f < stop; f += 1) this.stepS[f] = gap[f] / fps[recording];
      this.halfWidth.fill(0.5 * width[recording], start, stop);
    });
    this.durationS = sum(this.stepS);
  }

  ofRecordings(visit) {
    const { first } = this.columns;
    for (let r = 0; r + 1 < first.length; r += 1) visit(r, first[r], first[r + 1]);
  }

  // Computes each system's arrays, such as its similarity, for these settings. Only frames in which
  // a threshold adds or takes a detection are measured anew for it.
  update(settings) {
    this.settings = settings;
    this.values = null;
    const thresholds = this.thresholdsShown(settings);
    const weights = ["midpoint", "spread", "midpoint_m", "spread_m"].map((name) => settings[name]).join();
    for (const letter of ["x", "y"]) {
      const system = this[letter];
      const isMoved = system.isNew("members", thresholds[letter]);
      const isEdgeNew = system.isNew("edge", settings.edge_weight);
      const isWeightNew = system.isNew("weights", weights);
      if (isMoved || isEdgeNew || isWeightNew) this.ofEncounters = null;
      system.isStale.fill(isEdgeNew ? 1 : 0);
      if (isMoved) this.findMembers(system, thresholds[letter]);
      if (isMoved || isEdgeNew) this.measureReach(system);
      if (isWeightNew) system.isStale.fill(1);
      if (isMoved || isEdgeNew || isWeightNew) this.measureSets(system);
      this.trace(system);
    }
  }

  // What the settings make of both systems, by measure and system.
  measures() {
    if (this.values) return this.values;
    this.ofEncounters ??= this.weighFailures();
    const [x, y] = [this.x, this.y].map((system, i) => ({ ...this.ofFrames(system), ...this.ofEncounters[i] }));
    this.values = Object.fromEntries(Object.keys(x).map((key) => [key, { x: x[key], y: y[key] }]));
    return this.values;
  }

  // The thresholds of the comparison that is shown: where X and Y are set unequally, one is moved.
  thresholdsShown({ threshold_x: x, threshold_y: y }) {
    const set = { x: x ?? -Infinity, y: y ?? -Infinity };
    const alarms = (letter, at) => countFrom(this[letter].alarms, at[letter]);
    const areUnequal = (at) => {
      const [fewer, more] = [alarms("x", at), alarms("y", at)].sort((a, b) => a - b);
      return more > UNEQUAL * fewer && more - fewer >= LEAST_MORE;
    };
    if (this.rules.point === "as-set" || !areUnequal(set)) return set;
    const movable = ["x", "y"].filter((letter) => this[letter].hasScores);
    if (!movable.length) return set;
    const rank = (letter) => alarms(letter, set) * 2 ** 30 + countFrom(this[letter].scores, set[letter]);
    const moved = movable.length > 1 && rank("y") > rank("x") ? "y" : movable[0];
    const target = alarms(moved === "x" ? "y" : "x", set);
    const equal = { ...set, [moved]: this[moved].thresholdWithAlarms(target) };
    return areUnequal(equal) ? set : equal;
  }

  // What weights and borders in a recording are made of: the weight of a box is the sigmoid of
  // (size - zero) / spread, or of (zeroM - metres) / spreadM, its border least + slope * (distance
  // to the nearer edge).
  formulaOf(recording) {
    const { settings, columns } = this;
    const width = columns.width[recording];
    const edge = settings.edge_weight ?? columns.edge_weight[recording];
    return {
      zero: columns.horizon[recording] + (settings.midpoint ?? columns.midpoint[recording]),
      spread: settings.spread ?? columns.spread[recording],
      zeroM: settings.midpoint_m,
      spreadM: settings.spread_m,
      isFlat: this.rules.proximity === "none",
      width,
      least: edge * 0.5 * width,
      slope: 1 - edge,
    };
  }

  // Who belongs to S; in frames where that changes, who is matched, and how far each box is from
  // the nearest of the other set.
  findMembers(system, threshold) {
    const { centre: truthCentre, foot: truthFoot, offsets: truthOffsets } = this.truth;
    const { offsets, score, match, centre, foot, isMember, isMatched, isStale } = system;
    const { near } = system;
    const { near: truthNear } = system.ofTruth;
    const ofMatchOnly = this.rules.pairing === "matched";
    for (let f = 0; f < this.nFrames; f += 1) {
      for (let d = offsets[f]; d < offsets[f + 1]; d += 1) {
        const is = score[d] < threshold ? 0 : 1;
        if (is === isMember[d]) continue;
        isMember[d] = is;
        if (match[d] < 0) system.nAlarms += 2 * is - 1;
        isStale[f] = 1;
      }
      if (!isStale[f]) continue;
      for (let g = truthOffsets[f]; g < truthOffsets[f + 1]; g += 1) {
        isMatched[g] = 0;
        truthNear[g] = Infinity;
      }
      for (let d = offsets[f]; d < offsets[f + 1]; d += 1) {
        if (!isMember[d]) continue;
        const partner = match[d];
        if (partner >= 0) isMatched[partner] = 1;
        const start = ofMatchOnly ? partner : truthOffsets[f];
        const stop = ofMatchOnly ? partner + (partner >= 0) : truthOffsets[f + 1];
        let least = Infinity;
        for (let g = start; g < stop; g += 1) {
          let apart = Math.abs(truthCentre[g] - centre[d]);
          if (foot) apart = Math.hypot(apart, truthFoot[g] - foot[d]);
          if (apart < truthNear[g]) truthNear[g] = apart;
          if (apart < least) least = apart;
        }
        near[d] = least;
      }
    }
  }

  measureReach(system) {
    this.ofRecordings((recording, start, stop) => {
      const formula = this.formulaOf(recording);
      reachOf(system.ofTruth, formula, start, stop, system.isStale);
      reachOf(system, formula, start, stop, system.isStale);
    });
  }

  // D(G, S) and D(S, G) of every frame, px.
  measureSets(system) {
    this.ofRecordings((recording, start, stop) => {
      const formula = this.formulaOf(recording);
      maximin(system.ofTruth, formula, start, stop, system.isStale, system.dMiss);
      maximin(system, formula, start, stop, system.isStale, system.dFalse);
    });
  }

  trace(system) {
    const { alpha } = this.settings;
    const { halfWidth } = this;
    const { dMiss, dFalse, similarity } = system;
    for (let f = 0; f < this.nFrames; f += 1) {
      const lost = (alpha * dMiss[f] + (1 - alpha) * dFalse[f]) / halfWidth[f];
      similarity[f] = lost < 1 ? 1 - lost : 0;
    }
  }

  // Encounters detected, and what the failures in each weigh. A track that is given twice in a
  // frame counts once: matched if one of its boxes is, else by the largest cost.
  weighFailures() {
    const { gap: gaps, fps, encounter_recording: recordingOf } = this.columns;
    const { offsets, encounter, factor, centre, size, metres } = this.truth;
    const n = recordingOf.length;
    const last = new Int32Array(n).fill(-1);
    const relevant = new Int32Array(n);
    const [isMatchedX, isMatchedY] = [this.x.isMatched, this.y.isMatched];
    const [hitsX, hitsY, lostX, lostY, severityX, severityY] = Array.from({ length: 6 }, () => new Float64Array(n));
    const close = (e) => {
      const gap = gaps[last[e]];
      if (lostX[e] < 0) hitsX[e] += 1;
      else severityX[e] += lostX[e] * gap;
      if (lostY[e] < 0) hitsY[e] += 1;
      else severityY[e] += lostY[e] * gap;
    };
    this.ofRecordings((recording, start, stop) => {
      const { zero, spread, zeroM, spreadM, isFlat, width, least, slope } = this.formulaOf(recording);
      for (let f = start; f < stop; f += 1) {
        for (let g = offsets[f]; g < offsets[f + 1]; g += 1) {
          const e = encounter[g];
          let z = (size[g] - zero) / spread;
          if (metres && !Number.isNaN(metres[g])) z = (zeroM - metres[g]) / spreadM;
          if (isFlat) z = Infinity;
          if (e < 0 || z < -SURE || (z < SURE && weigh(z) < RELEVANT_K)) continue;
          const c = centre[g];
          const isBoth = isMatchedX[g] && isMatchedY[g];
          const cost = isBoth ? 0 : (weigh(z) * factor[g] * (least + slope * Math.min(c, width - c))) / (0.5 * width);
          const x = isMatchedX[g] ? MATCHED : cost;
          const y = isMatchedY[g] ? MATCHED : cost;
          if (last[e] === f) {
            lostX[e] = Math.min(x, lostX[e]) < 0 ? MATCHED : Math.max(x, lostX[e]);
            lostY[e] = Math.min(y, lostY[e]) < 0 ? MATCHED : Math.max(y, lostY[e]);
            continue;
          }
          if (last[e] >= 0) close(e);
          lostX[e] = x;
          lostY[e] = y;
          last[e] = f;
          relevant[e] += 1;
        }
      }
    });
    let near = 0;
    for (let e = 0; e < n; e += 1) {
      if (last[e] < 0) continue;
      close(e);
      near += 1;
      severityX[e] /= fps[recordingOf[e]];
      severityY[e] /= fps[recordingOf[e]];
    }
    /** @type {[Float64Array, Float64Array, Uint8Array][]} */
    const sides = [
      [hitsX, severityX, isMatchedX],
      [hitsY, severityY, isMatchedY],
    ];
    return sides.map(([hits, severity, isMatched]) => {
      const severityS = sum(severity);
      return {
        encounters_detected: hits.reduce((count, hit, e) => count + Number(hit > 0 && hit / relevant[e] >= this.rules.coverage), 0),
        severity_s: severityS,
        severity_s_per_min: this.durationS ? (60 * severityS) / this.durationS : NaN,
        severity_s_per_encounter: near ? severityS / near : NaN,
        worst_severity_s: near ? severity.reduce((a, b) => Math.max(a, b), 0) : NaN,
        boxes_matched: sum(isMatched),
      };
    });
  }

  ofFrames(system) {
    const { low } = this.settings;
    const { nFrames: n, stepS } = this;
    const { similarity: values } = system;
    let [total, least, nLow, lostS] = [0, Infinity, 0, 0];
    for (let f = 0; f < n; f += 1) {
      const value = values[f];
      total += value;
      if (value < least) least = value;
      if (value < low) nLow += 1;
      lostS += (1 - value) * stepS[f];
    }
    return {
      mean_similarity: n ? total / n : NaN,
      min_similarity: n ? least : NaN,
      percentile_5_similarity: n ? percentile(values, 0.05) : NaN,
      share_low: n ? nLow / n : NaN,
      lost_s_per_min: n ? (60 * lostS) / this.durationS : NaN,
      false_alarms_per_frame: n ? system.nAlarms / n : NaN,
    };
  }

  // Moving mean of similarity over the frames of a recording.
  smooth(system, recording, windowS) {
    const { first, frame, fps } = this.columns;
    const [start, stop] = [first[recording], first[recording + 1]];
    const half = 0.5 * windowS * fps[recording] * (1 + 1e-9);
    const means = new Float64Array(stop - start);
    let [from, to, total] = [start, start, 0];
    for (let f = start; f < stop; f += 1) {
      while (to < stop && frame[to] - frame[f] <= half) total += system.similarity[to++];
      while (frame[f] - frame[from] > half) total -= system.similarity[from++];
      means[f - start] = total / (to - from);
    }
    return means;
  }
}
