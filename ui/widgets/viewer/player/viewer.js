// The viewer: one row is requested, one row is painted, and what is painted always has its own
// picture and its own boxes. Python hears of a row only when it has settled.

const SETTLE_MS = 150;
const PREFETCH = 12;
const LOADING_TEXT_MS = 400;

class Viewer {
  constructor() {
    this.layers = { truth: true, x: true, y: true, labels: true, cost: false };
    this.parts = makeControls({
      toggle: (layer) => this.toggle(layer),
      playPause: () => this.playPause(),
      speed: (speed) => { this.speed = speed; },
      first: () => this.goTo(0),
      last: () => this.goTo(this.recording.nRows - 1),
      previous: () => this.goTo(this.row - 1),
      next: () => this.goTo(this.row + 1),
      previousMiss: () => this.goToMiss(-1),
      nextMiss: () => this.goToMiss(1),
      fit: () => this.fit(),
      fullScreen: () => this.fullScreen(),
      help: () => this.toggleHelp(),
    });
    this.root = this.parts.root;
    this.strip = new Strip(this.parts.strip);
    this.pictures = new PictureStore((row) => this.onPicture(row));
    this.boxes = new BoxStore((start, stop) => this.onBoxes(start, stop));
    this.root.dataset.playing = "false";
    this.row = 0;
    this.shown = null; // {row, entry, found}: what is on the canvas
    this.speed = 1;
    this.playing = null; // {position (s of the recording's clock), from (row), at (time stamp)}
    this.isDragging = false;
    this.hoverRow = null;
    this.view = new View();
    this.cost = new CostLayer();
    this.isStale = true;
    this.isSpokenEarly = false;
    this.request = 0;
    this.settleTimer = 0;
    this.loadingTimer = 0;
    listen(this);
  }

  // whether keys, mouse and touch move it
  get isSteered() {
    return true;
  }

  // ---- what Python sends

  update(sent, report) {
    const before = this.sent;
    this.sent = sent;
    this.report = report;
    const isOther = !before || before.token !== sent.token || before.recording !== sent.recording
      || before.n_rows !== sent.n_rows;
    const differs = (...names) => isOther
      || names.some((name) => JSON.stringify(before[name]) !== JSON.stringify(sent[name]));
    if (differs("frames", "times", "picture_spans", "width", "height", "fps")) this.recording = new Recording(sent);
    const address = (kind) => `${sent.base}/nv/${encodeURIComponent(sent.token)}/${kind}/${sent.recording}`;
    if (isOther) this.boxes.reset(address("boxes"), sent.version, sent.n_rows);
    else this.boxes.setVersion(sent.version);
    if (differs("lo", "hi", "picture_version", "picture_spans")) {
      const query = new URLSearchParams({ lo: sent.lo, hi: sent.hi, v: sent.picture_version });
      this.pictures.reset((row) => `${address("frame")}/${row}.jpg?${query}`);
    }
    if (differs("colours", "theme")) this.setColours(sent);
    if (differs("traces", "intervals", "misses", "low", "colours")) this.strip.set(sent, sent.colours.picture);
    if (differs("names")) this.setNames(sent.names);
    if (differs("cost")) {
      this.cost.set(sent.cost);
      this.parts.cost.hidden = !this.cost.isKnown;
    }
    if (differs("height_px", "width", "height")) this.setHeight();
    const isSeek = isOther || before.seek[1] !== sent.seek[1];
    if (isOther) {
      this.pictures.pin(null);
      this.shown = null;
      delete this.root.dataset.shownRow;
      this.view.fit();
      this.parts.picture.width = 0; // clears it; painting gives it its size again
    }
    if (isSeek) this.seek(sent.seek[0]);
    else this.load();
    this.isStale = true;
    this.wake();
  }

  seek(row) {
    this.pause(false);
    this.goTo(row, true);
  }

  setColours({ colours, theme }) {
    for (const [name, value] of Object.entries(colours.chrome)) this.root.style.setProperty(`--viewer-${name}`, value);
    this.root.dataset.theme = theme;
  }

  setNames([x, y]) {
    for (const [layer, text] of [["x", `X ${x}`], ["y", `Y ${y}`], ["truth", "Ground truth"]]) {
      this.parts[layer].querySelector(".name").textContent = text;
      this.parts[layer].title = text;
    }
  }

  setHeight() {
    const { width, height } = this.recording;
    const { style } = this.parts.stage;
    style.aspectRatio = `${width} / ${height}`;
    // the transport stays in sight below the picture
    style.maxHeight = `min(${this.sent.height_px}px, max(300px, calc(100vh - 24.6rem)))`;
  }

  // ---- moving about

  goTo(row, isFromPython = false) {
    const { recording } = this;
    if (!recording || recording.nRows === 0) return;
    this.direction = row < this.row && !this.playing ? -1 : 1;
    this.row = recording.clamp(row);
    this.isSpokenEarly = false;
    if (this.playing) this.startClock();
    this.load();
    showPosition(this, this.row);
    this.wake();
    clearTimeout(this.settleTimer);
    if (isFromPython) this.settled = { recording: this.sent.recording, row: this.row, nonce: this.sent.seek[1] };
    if (!this.playing) this.settleTimer = setTimeout(() => this.settle(), SETTLE_MS);
    clearTimeout(this.loadingTimer);
    this.loadingTimer = setTimeout(() => this.wake(), LOADING_TEXT_MS);
    this.requestedAt = performance.now();
  }

  goToMiss(direction) {
    const { misses } = this.strip;
    const next = countUpTo(misses, this.row);
    let index = next;
    if (direction < 0) index = next > 0 && misses[next - 1] === this.row ? next - 2 : next - 1;
    if (index >= 0 && index < misses.length) this.goTo(misses[index]);
    else this.say(direction > 0 ? "No later miss" : "No earlier miss");
  }

  settle() {
    if (this.playing || this.isDragging) return;
    const now = { recording: this.sent.recording, row: this.row, nonce: this.sent.seek[1] };
    this.speak();
    const known = this.settled;
    if (known && known.row === now.row && known.recording === now.recording && known.nonce === now.nonce) return;
    this.settled = now;
    this.report(now);
  }

  playPause() {
    if (this.playing) {
      this.pause(true);
      return;
    }
    const { recording } = this;
    if (this.row >= recording.nRows - 1) this.goTo(0);
    clearTimeout(this.settleTimer);
    this.startClock();
    this.direction = 1;
    this.showPlaying();
    this.wake();
  }

  startClock() {
    this.playing = { position: this.recording.clock[this.row], from: this.row, at: null };
  }

  pause(isReported) {
    if (!this.playing) return;
    this.playing = null;
    this.showPlaying();
    if (isReported) this.goTo(this.shownRow);
  }

  // the end of the recording
  stopAt(row) {
    this.pause(false);
    this.goTo(row);
  }

  showPlaying() {
    const { play } = this.parts;
    play.replaceChildren(svg(ICONS[this.playing ? "pause" : "play"]));
    play.setAttribute("aria-label", this.playing ? "Pause" : "Play");
    this.root.dataset.playing = String(Boolean(this.playing));
  }

  // ---- loading

  isReady(row) {
    const hasPicture = !this.recording.hasPicture(row) || this.pictures.get(row) !== undefined;
    return hasPicture && this.boxes.isReady(row);
  }

  load() {
    const { recording } = this;
    if (!recording || recording.nRows === 0) return;
    this.boxes.want(this.row);
    if (!recording.hasPictures) return;
    const rows = [this.row];
    const stride = this.playing ? rowsPerPicture(this) : 1;
    const ahead = this.isDragging ? 0 : PREFETCH;
    // clamped: long strides must not step over the last row, where playing ends
    for (let step = 1; step <= ahead; step += 1) rows.push(recording.clamp(this.row + this.direction * stride * step));
    const wanted = [...new Set(rows)].filter((row) => recording.hasPicture(row));
    this.pictures.want(wanted, this.isDragging ? 1 : REQUESTS);
  }

  onPicture(row) {
    if (row === this.row || this.playing) this.wake();
    else if (this.isDragging && this.isReady(row)) this.wake(row);
  }

  onBoxes(start, stop) {
    if (this.shown && this.shown.row >= start && this.shown.row < stop) this.isStale = true;
    this.wake();
  }

  // ---- painting

  wake(passingRow = null) {
    if (passingRow !== null) this.passingRow = passingRow;
    if (this.request === 0) this.request = requestAnimationFrame((now) => this.tick(now));
  }

  tick(now) {
    this.request = 0;
    if (!this.root.isConnected || !this.recording) {
      // while it is moved about in the page it waits, and plays on from here
      if (this.playing) {
        this.playing.at = null;
        this.wake();
      }
      return;
    }
    this.resize();
    if (this.recording.nRows === 0) {
      this.showMessage("This recording has no frames");
      return;
    }
    const row = this.playing && !this.isDragging ? advance(this, now) : this.row;
    const isNew = this.shown === null || row !== this.shown.row || this.isReplaced(row);
    if (this.isReady(row) && (isNew || this.isStale)) this.paint(row);
    else if (this.passingRow !== undefined && this.isDragging && this.isReady(this.passingRow)) this.paint(this.passingRow);
    else if (this.isStale && this.shown) this.paint(this.shown.row, this.shown.entry, this.shown.found);
    this.passingRow = undefined;
    this.strip.draw(this.row, this.hoverRow);
    this.showState();
    if (this.playing) this.wake();
  }

  get shownRow() {
    return this.shown ? this.shown.row : this.row;
  }

  // the same row again, but stretched differently
  isReplaced(row) {
    const entry = this.pictures.get(row);
    return entry !== undefined && entry !== this.shown?.entry;
  }

  resize() {
    const ratio = window.devicePixelRatio || 1;
    const { picture, stage } = this.parts;
    const width = Math.max(1, Math.round(stage.clientWidth * ratio));
    const height = Math.max(1, Math.round(stage.clientHeight * ratio));
    if (picture.width !== width || picture.height !== height) {
      picture.width = width;
      picture.height = height;
      this.isStale = true;
    }
    this.ratio = ratio;
    this.view.set(this.recording, stage.clientWidth, stage.clientHeight);
    this.strip.resize(this.parts.stripHolder.clientWidth, ratio);
    this.parts.strip.style.height = `${this.strip.height}px`;
  }

  // The last two: what is on the canvas already, should the stores have dropped it.
  paint(row, shownEntry = undefined, shownFound = null) {
    const { recording } = this;
    const { place } = this.view;
    const entry = shownEntry ?? (recording.hasPicture(row) ? this.pictures.get(row) : undefined);
    const ctx = this.parts.picture.getContext("2d");
    ctx.setTransform(this.ratio, 0, 0, this.ratio, 0, 0);
    ctx.clearRect(0, 0, place.size.width, place.size.height);
    const frame = { x: place.x, y: place.y, w: recording.width * place.scale, h: recording.height * place.scale };
    if (entry?.bitmap) {
      ctx.imageSmoothingEnabled = place.scale < 4;
      ctx.drawImage(entry.bitmap, frame.x, frame.y, frame.w, frame.h);
    } else {
      ctx.fillStyle = "#171C25";
      ctx.fillRect(frame.x, frame.y, frame.w, frame.h);
    }
    if (this.layers.cost) this.cost.draw(ctx, frame, this.view.seen);
    const found = this.boxes.ofRow(row) ?? shownFound;
    this.drawFound(ctx, found);
    this.pictures.pin(entry ?? null);
    this.shown = { row, entry, found };
    this.isStale = false;
    this.root.dataset.shownRow = String(row);
    if (this.isSpokenEarly && row === this.row) this.speak();
  }

  drawFound(ctx, found) {
    const { place, seen } = this.view;
    if (found) drawBoxes(ctx, found, place, this.layers, this.sent.colours.picture, seen);
    this.counts = countStates(found);
    showCounts(this.parts, this.counts);
  }

  // ---- words

  // a row that is not painted yet is spoken of without its counts, and again when it is
  speak() {
    this.isSpokenEarly = this.shown?.row !== this.row;
    const text = describeFrame(this);
    this.say(text);
    this.parts.picture.setAttribute("aria-label", text);
  }

  say(text) {
    this.parts.spoken.textContent = text;
  }

  showState() {
    const row = this.shownRow;
    const texts = [this.boxes.errorAt(row)];
    if (this.recording.hasPictures) {
      texts.push(this.recording.hasPicture(row) ? this.shown?.entry?.error : NO_PICTURE);
    } else texts.push("No pictures: boxes only");
    const isLate = !this.playing && this.row !== row && performance.now() - this.requestedAt > LOADING_TEXT_MS;
    if (isLate || this.shown === null) texts.unshift("Loading …");
    this.showMessage(texts.filter((text) => text)[0] ?? "");
  }

  showMessage(text) {
    const { message } = this.parts;
    if (message.textContent !== text) message.textContent = text;
    message.hidden = text === "";
  }

  // ---- view

  toggle(layer) {
    this.layers[layer] = !this.layers[layer];
    this.parts[layer].setAttribute("aria-pressed", String(this.layers[layer]));
    this.isStale = true;
    this.wake();
  }

  fit() {
    this.view.fit();
    this.showView();
  }

  // at: the point of the canvas (CSS pixels) that stays where it is
  zoomBy(factor, at = null) {
    this.view.zoomBy(factor, at);
    this.showView();
  }

  moveBy(right, down) {
    this.view.moveBy(right, down);
    this.showView();
  }

  showView() {
    this.parts.picture.classList.toggle("movable", this.view.zoom > 1);
    this.isStale = true;
    this.wake();
  }

  fullScreen() {
    const isFull = this.root.getRootNode().fullscreenElement === this.root;
    if (isFull) document.exitFullscreen();
    else this.root.requestFullscreen().catch(() => this.say("Full screen is not available"));
  }

  toggleHelp() {
    if (this.help) {
      this.help.remove();
      this.help = null;
      this.root.focus();
      return;
    }
    this.help = makeHelp(this.sent.colours.picture, () => this.toggleHelp());
    this.root.append(this.help);
    this.help.querySelector("button").focus();
  }

  destroy() {
    this.playing = null;
    cancelAnimationFrame(this.request);
    clearTimeout(this.settleTimer);
    clearTimeout(this.loadingTimer);
    this.observer.disconnect();
    document.removeEventListener("keydown", this.onPageKey);
    this.pictures.pin(null);
    this.pictures.reset(() => "");
    this.boxes.reset("", "", 0);
  }
}
