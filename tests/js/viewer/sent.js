// What Python sends to the viewer, made by hand.

export function pack(Kind, values) {
  return Buffer.from(Kind.from(values).buffer).toString("base64");
}

// A recording with these times, of 100 x 50 pixels at 10 frames a second; `changes` replace fields.
export function recordingOf(times, changes = {}) {
  return {
    n_rows: times.length, width: 100, height: 50, fps: 10, picture_spans: "",
    frames: { starts: pack(Int32Array, [0]), firsts: pack(Float64Array, [0]), steps: pack(Float64Array, [1]) },
    times: { every_row: pack(Float64Array, times) },
    ...changes,
  };
}
