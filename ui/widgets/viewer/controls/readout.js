// The frame in words: position, counts, and a sentence for those who do not see the picture.

export function showPosition({ recording, parts, root }, row) {
  const frame = String(recording.frames[row]);
  const time = recording.timeText(row);
  root.dataset.row = String(row);
  root.dataset.frame = frame;
  // the page's figures over time mark it
  document.nvcoreTime = recording.times[row];
  document.dispatchEvent(new Event("nvcore-time"));
  const [frameText, timeText, rowText] = parts.readout.children;
  frameText.textContent = `frame ${frame}`;
  timeText.textContent = time;
  rowText.textContent = `${row + 1} of ${recording.nRows}`;
  parts.strip.setAttribute("aria-valuemin", "1");
  parts.strip.setAttribute("aria-valuemax", String(recording.nRows));
  parts.strip.setAttribute("aria-valuenow", String(row + 1));
  parts.strip.setAttribute("aria-valuetext", `frame ${frame}, ${time}`);
}

export function showCounts(parts, counts) {
  const set = (part, text) => {
    const span = part.querySelector(".counts");
    if (span.textContent !== text) span.textContent = text;
  };
  for (const system of ["x", "y"]) {
    const missed = counts[`missed_${system}`];
    const far = counts[`far_${system}`];
    const texts = [`${missed} near missed`, ...(far ? [`${far} far`] : [])];
    set(parts[system], [...texts, `${counts[`false_${system}`]} false`].join(", "));
    parts[system].classList.toggle("misses", missed > 0);
  }
  set(parts.truth, `${counts.truth}, ${counts.relevant} near enough`);
}

export function describeFrame({ counts, recording, row, shown }) {
  const place = `Frame ${recording.frames[row]}, ${recording.timeText(row)}`;
  if (shown?.row !== row) return place;
  return `${place}: X misses ${counts.missed_x}, Y misses ${counts.missed_y}, `
    + `false alarms X ${counts.false_x}, Y ${counts.false_y}`;
}
