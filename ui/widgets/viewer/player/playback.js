// Which row is due while the viewer plays, and how many pictures to ask for.

import { showPosition } from "../controls/readout.js";
import { LONGEST_GAP_S, countUpTo } from "../data/recording.js";

export const PREFETCH = 12;
const LONGEST_LAG_S = 0.5; // playback waits for pictures when it is so far ahead of them
const SCREEN_S = 1 / 60;

// How far ahead of what is shown playback may be, in seconds of the recording's clock.
function longestLag(speed) {
  return Math.max(LONGEST_LAG_S * speed, 2 * LONGEST_GAP_S);
}

// The row to paint now: the newest one that is due and complete. Frames are dropped, never mixed.
export function advance(viewer, now) {
  const { playing, recording, speed } = viewer;
  const { clock } = recording;
  if (playing.at !== null) playing.position += ((now - playing.at) / 1000) * speed;
  playing.at = now;
  const shown = Math.max(playing.from, Math.min(viewer.shownRow, viewer.row));
  playing.position = Math.min(playing.position, clock[shown] + longestLag(speed));
  const due = recording.clamp(countUpTo(clock, playing.position + 1e-9) - 1);
  let row = due;
  while (row > shown && !viewer.isReady(row)) row -= 1;
  if (row !== viewer.row) {
    viewer.row = row;
    showPosition(viewer, row);
  }
  viewer.load();
  if (row === recording.lastRow) viewer.stopAt(row);
  return row;
}

// Every how many rows a picture is asked for: more than 1 when they come more slowly than they
// are due. The next one is near enough for playback to reach it while it waits for pictures.
export function rowsPerPicture({ recording, row, speed, pictures, visible, look }) {
  const { clock, nRows } = recording;
  const last = Math.min(nRows - 1, row + PREFETCH);
  const interval = (clock[last] - clock[row]) / Math.max(1, last - row) / speed;
  const ofVisible = look.needsVisible ? visible.secondsPerPicture : 0;
  const ofOwn = look.needsOwn ? pictures.secondsPerPicture : 0;
  const needed = Math.max(ofOwn, ofVisible, SCREEN_S);
  const within = countUpTo(clock, clock[row] + longestLag(speed)) - 1 - row;
  return interval > 0 ? Math.max(1, Math.min(16, within, Math.ceil((0.9 * needed) / interval))) : 1;
}
