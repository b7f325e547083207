// What Python sends about a recording, unpacked: frame numbers, times, pictures, traces.

export const LONGEST_GAP_S = 0.25; // sampled recordings play at four frames a second

export function unpack(text, Kind) {
  const binary = atob(text);
  const bytes = new Uint8Array(binary.length);
  for (let i = 0; i < binary.length; i += 1) bytes[i] = binary.charCodeAt(i);
  return new Kind(bytes.buffer);
}

// The number of sorted values that are <= value.
export function countUpTo(values, value) {
  let low = 0;
  let high = values.length;
  while (low < high) {
    const middle = (low + high) >> 1;
    if (values[middle] <= value) low = middle + 1;
    else high = middle;
  }
  return low;
}

export class Recording {
  constructor(sent) {
    this.nRows = sent.n_rows;
    this.firstRow = sent.rows?.[0] ?? 0;
    this.lastRow = sent.rows?.[1] ?? sent.n_rows - 1;
    this.width = sent.width;
    this.height = sent.height;
    this.frames = Recording.framesOf(sent);
    this.times = sent.times.every_row
      ? unpack(sent.times.every_row, Float64Array)
      : this.frames.map((frame) => frame / sent.fps + sent.times.offset);
    // playing time: real time, but no gap is longer than a quarter of a second
    this.clock = new Float64Array(this.nRows);
    for (let row = 1; row < this.nRows; row += 1) {
      const gap = this.times[row] - this.times[row - 1];
      this.clock[row] = this.clock[row - 1] + Math.min(Math.max(gap, 0.001), LONGEST_GAP_S);
    }
    this.pictureSpans = unpack(sent.picture_spans, Int32Array);
    this.frameS = sent.fps ? 1 / sent.fps : 0;
  }

  // When the frame of a row ends.
  endOf(row) {
    return this.times[row] + this.frameS;
  }

  // Frame numbers are sent as runs of a constant step.
  static framesOf(sent) {
    const starts = unpack(sent.frames.starts, Int32Array);
    const firsts = unpack(sent.frames.firsts, Float64Array);
    const steps = unpack(sent.frames.steps, Float64Array);
    const frames = new Float64Array(sent.n_rows);
    for (let run = 0; run < starts.length; run += 1) {
      const stop = run + 1 < starts.length ? starts[run + 1] : sent.n_rows;
      for (let row = starts[run]; row < stop; row += 1) {
        frames[row] = firsts[run] + steps[run] * (row - starts[run]);
      }
    }
    return frames;
  }

  get hasPictures() {
    return this.pictureSpans.length > 0;
  }

  hasPicture(row) {
    // spans are start, stop, start, stop ...: inside one where an odd count of edges is passed
    return countUpTo(this.pictureSpans, row) % 2 === 1;
  }

  clamp(row) {
    return Math.max(this.firstRow, Math.min(this.lastRow, row));
  }

  // The row that is `seconds` away, at least one row.
  rowAfter(row, seconds) {
    const there = countUpTo(this.times, this.times[row] + seconds + 1e-6) - 1;
    return this.clamp(seconds > 0 ? Math.max(there, row + 1) : Math.min(there, row - 1));
  }

  timeText(row) {
    const seconds = this.times[row];
    const shown = Math.abs(seconds).toFixed(2); // rounded first: 59.999 s is a minute
    if (Number(shown) < 60) return `${seconds.toFixed(2)} s`;
    const minutes = Math.floor(Number(shown) / 60);
    return `${seconds < 0 ? "-" : ""}${minutes}:${(Number(shown) - 60 * minutes).toFixed(2).padStart(5, "0")} min`;
  }
}
