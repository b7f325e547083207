// Boxes of the recording in chunks of rows, in the format of `pack_boxes` in ui/session/packed_comparison.py.

const CHUNK_ROWS = 1024;
const NEIGHBOUR_ROWS = 256; // so near to a chunk's end the next one is fetched
const CHUNKS_KEPT = 12;
export const RETRY_MS = 2000;
const MOST_LETTERS = 200;

export const SOURCE = { truth: 0, x: 1, y: 2 };
export const TRUTH_STATE = {
  ignore: 1, matched_x: 2, matched_y: 4, relevant: 8, salient_x: 16, salient_y: 32,
};
export const DETECTION_STATE = { matched: 1, false_alarm: 2, absorbed: 3 };
export const SESSION_ENDED = "The session has ended: load the page again";

function parseBoxes(buffer) {
  const [nFrames, nBoxes] = new Uint32Array(buffer, 0, 2);
  let at = 8;
  const column = (Kind, n) => {
    const values = new Kind(buffer, at, n);
    at += Math.ceil((n * Kind.BYTES_PER_ELEMENT) / 4) * 4;
    return values;
  };
  return {
    nFrames,
    offsets: column(Uint32Array, nFrames + 1),
    x: column(Float32Array, nBoxes), y: column(Float32Array, nBoxes),
    w: column(Float32Array, nBoxes), h: column(Float32Array, nBoxes),
    score: column(Float32Array, nBoxes), track: column(Int32Array, nBoxes),
    source: column(Uint8Array, nBoxes), state: column(Uint8Array, nBoxes),
  };
}

export class BoxStore {
  constructor(onLoad) {
    this.onLoad = onLoad;
    this.chunks = new Map(); // chunk number -> {boxes, version, error, failedAt}
    this.pending = new Set();
    this.generation = 0; // answers to questions about another recording are dropped
  }

  reset(address, version, nRows) {
    this.generation += 1;
    this.chunks.clear();
    this.pending.clear();
    this.address = address;
    this.version = version;
    this.nRows = nRows;
  }

  // A new analysis of the same recording: the old boxes stay until the new ones are here.
  setVersion(version) {
    this.version = version;
  }

  chunkOf(row) {
    return this.chunks.get(Math.floor(row / CHUNK_ROWS));
  }

  isReady(row) {
    const chunk = this.chunkOf(row);
    return chunk !== undefined && (chunk.boxes !== null || chunk.error !== "");
  }

  // The chunk and the first and last box of one row; null where there are none to draw.
  ofRow(row) {
    const chunk = this.chunkOf(row);
    const inside = row % CHUNK_ROWS;
    if (!chunk || !chunk.boxes || inside >= chunk.boxes.nFrames) return null;
    const { boxes } = chunk;
    return { boxes, start: boxes.offsets[inside], stop: boxes.offsets[inside + 1] };
  }

  errorAt(row) {
    return this.chunkOf(row)?.error ?? "";
  }

  want(row) {
    const number = Math.floor(row / CHUNK_ROWS);
    this.fetchChunk(number);
    const inside = row % CHUNK_ROWS;
    if (inside >= CHUNK_ROWS - NEIGHBOUR_ROWS) this.fetchChunk(number + 1);
    if (inside < NEIGHBOUR_ROWS) this.fetchChunk(number - 1);
  }

  async fetchChunk(number) {
    if (number < 0 || number * CHUNK_ROWS >= this.nRows || this.pending.has(number)) return;
    const known = this.chunks.get(number);
    const isTried = known?.error && performance.now() - known.failedAt < RETRY_MS;
    if (known && known.version === this.version && (!known.error || isTried)) return;
    const { generation, version } = this;
    this.pending.add(number);
    const chunk = { boxes: null, version, error: "", failedAt: 0 };
    try {
      const url = `${this.address}/${number}?v=${encodeURIComponent(version)}`;
      const answer = await fetch(url, { credentials: "same-origin" });
      // an unknown address is answered with the app's own page
      const isPage = (answer.headers.get("content-type") ?? "").startsWith("text/html");
      if (isPage) throw new Error(SESSION_ENDED);
      if (!answer.ok) throw new Error(await refusal(answer, SESSION_ENDED));
      chunk.boxes = parseBoxes(await answer.arrayBuffer());
    } catch (error) {
      chunk.boxes = null;
      chunk.failedAt = performance.now();
      chunk.error = errorText(error, "The boxes could not be loaded");
    }
    if (generation !== this.generation) return;
    this.pending.delete(number);
    if (version !== this.version) {
      this.fetchChunk(number);
      return;
    }
    this.chunks.delete(number); // to the end of the map's order: the newest
    this.chunks.set(number, chunk);
    for (const oldest of this.chunks.keys()) {
      if (this.chunks.size <= CHUNKS_KEPT) break;
      this.chunks.delete(oldest);
    }
    this.onLoad(number * CHUNK_ROWS, (number + 1) * CHUNK_ROWS);
  }
}

// What the server says in words, when it refuses.
export async function refusal(answer, otherwise) {
  const isText = (answer.headers.get("content-type") ?? "").startsWith("text/plain");
  const text = isText ? (await answer.text()).trim().slice(0, MOST_LETTERS) : "";
  if (text) return text[0].toUpperCase() + text.slice(1);
  return answer.status === 404 ? otherwise : `The server answers with status ${answer.status}`;
}

export function errorText(error, otherwise) {
  if (error instanceof TypeError) return "The server does not answer";
  return error instanceof Error && !(error instanceof RangeError) ? error.message : otherwise;
}
