// The viewer: one row is requested, one row is painted, and what is painted always has its own
// picture and its own boxes. Python hears of a row only when it has settled.

import { Card } from "../controls/card.js";
import { makeControls, makeHelp, showMissKeys } from "../controls/controls.js";
import { make, worded } from "../controls/elements.js";
import { listen } from "../controls/listening.js";
import { describeFrame, showCounts } from "../controls/readout.js";
import { showClock } from "../controls/sources.js";
import { makeLightPanel, nameFollow, showScale } from "../controls/tools.js";
import { BoxStore } from "../data/boxes.js";
import { Look } from "../data/look.js";
import { NO_PICTURE, PictureStore } from "../data/pictures.js";
import { Reasons } from "../data/reasons.js";
import { Recording } from "../data/recording.js";
import { CostLayer } from "../drawing/cost.js";
import { countStates, drawBoxes } from "../drawing/drawing.js";
import { Light } from "../drawing/light.js";
import { paintRow } from "../drawing/painting.js";
import { Strip } from "../drawing/strip.js";
import { View } from "../drawing/view.js";
import { Dock } from "./dock.js";
import { Looking } from "./looking.js";
import { advance } from "./playback.js";
import { LOADING_TEXT_MS } from "./player.js";

const HINT_MS = 4000;
const SCROLLER = '[data-testid="stMain"]';
const PAGE = '[data-testid="stMainBlockContainer"]';
const LEAST_STAGE_PX = 200;
const BELOW_BAR_PX = 4; // border of the viewer, and rounding

export class Viewer extends Looking {
  constructor() {
    super();
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
      secondBack: () => this.goTo(this.recording.rowAfter(this.row, -1)),
      secondForward: () => this.goTo(this.recording.rowAfter(this.row, 1)),
      fit: () => this.fit(),
      zoomIn: () => this.zoomStep(1),
      zoomOut: () => this.zoomStep(-1),
      light: () => this.toggleLight(),
      look: (changes) => this.changeLook(changes),
      adapting: () => this.toggleAdapting(),
      byHand: () => this.toggleByHand(),
      tunnel: () => this.toggleTunnel(),
      follow: () => this.toggleFollow(),
      large: () => this.dock.open(),
      closeDock: () => this.dock.close(),
      fullScreen: () => this.fullScreen(),
      help: () => this.toggleHelp(),
    });
    this.root = this.parts.root;
    this.holder = make("div", { class: "holder" }, [this.root]); // keeps the place of the root
    this.strip = new Strip(this.parts.strip);
    this.pictures = new PictureStore((row) => this.onPicture(row));
    this.visible = new PictureStore((row) => this.onPicture(row));
    this.look = new Look();
    this.boxes = new BoxStore((start, stop) => this.onBoxes(start, stop));
    this.root.dataset.playing = "false";
    this.row = 0;
    this.shown = null; // {row, entry, visible, found}: what is on the canvas
    this.speed = 1;
    this.playing = null; // {position (s of the recording's clock), from (row), at (time stamp)}
    this.isDragging = false;
    this.hoverRow = null;
    this.view = new View();
    this.cost = new CostLayer();
    this.light = new Light();
    this.lightPanel = null;
    this.parts.light.hidden = !this.light.isPossible;
    this.reasons = new Reasons();
    this.card = new Card(this);
    this.chosen = null; // track of the chosen pedestrian
    this.isFollowing = false;
    this.dock = this.isSteered ? new Dock(this) : null;
    this.isStale = true;
    this.isSpokenEarly = false;
    this.request = 0;
    this.settleTimer = 0;
    this.loadingTimer = 0;
    this.observer = null; // of the sizes, and the keys of the page: set by `listen`
    this.onPageKey = null;
    listen(this);
    const own = new WeakRef(this); // the document must not keep a viewer whose page is left
    document.addEventListener("nvcore-similarity", function follow({ detail }) {
      const viewer = own.deref();
      if (viewer) viewer.follow(detail);
      else document.removeEventListener("nvcore-similarity", follow);
    });
  }

  // whether keys, mouse and touch move it
  get isSteered() {
    return true;
  }

  // ---- what Python sends

  // Similarity of every row while a slider moves, and whether the legend's counts are older.
  follow({ recording, areCountsOld, ...similarity }) {
    if (!this.root.isConnected || this.sent?.recording !== recording || !this.strip.traces) return;
    this.strip.follow(similarity);
    this.root.classList.toggle("counts-old", areCountsOld);
    this.isStale = true;
    this.wake();
  }

  // report(row settled on); reportChoice(encounter chosen); reportLook(choice of the pictures)
  update(sent, report, reportChoice = null, reportLook = null) {
    const before = this.sent;
    this.sent = sent;
    this.root.classList.remove("counts-old");
    this.report = report;
    this.reportChoice = reportChoice;
    this.reportLook = reportLook;
    if (!before) {
      this.look.take(sent.look);
      this.toldLook = JSON.stringify(this.look.choice);
    }
    const isOther = !before || before.token !== sent.token || before.recording !== sent.recording
      || before.n_rows !== sent.n_rows;
    const differs = (...names) => isOther
      || names.some((name) => JSON.stringify(before[name]) !== JSON.stringify(sent[name]));
    if (differs("frames", "times", "picture_spans", "rows", "width", "height", "fps")) this.recording = new Recording(sent);
    const address = (kind) => `${sent.base}/nv/${encodeURIComponent(sent.token)}/${kind}/${sent.recording}`;
    if (isOther) this.boxes.reset(address("boxes"), sent.version, sent.n_rows);
    else this.boxes.setVersion(sent.version);
    if (differs("lo", "hi", "picture_version", "picture_spans")) {
      const query = new URLSearchParams({ lo: sent.lo, hi: sent.hi, v: sent.picture_version });
      this.pictures.reset((row) => `${address("frame")}/${row}.jpg?${query}`);
    }
    if (differs("visible", "picture_version")) {
      this.look.set(sent.visible);
      if (isOther) this.look.changeAt = null;
      this.addressOfVisible = address("visible");
      this.resetVisible();
    }
    this.reasons.reset(address("reasons"));
    if (isOther || before.chosen !== sent.chosen) this.chosen = sent.chosen;
    if (differs("colours", "theme")) this.setColours(sent);
    if (differs("traces", "intervals", "misses", "low", "colours")) this.strip.set(sent, sent.colours.picture);
    if (differs("names")) this.setNames(sent.names);
    if (differs("cost")) {
      this.cost.set(sent.cost);
      this.parts.cost.hidden = !this.cost.isKnown;
    }
    if (differs("height_px", "width", "height", "visible")) this.showLook();
    this.watchPage();
    if (differs("words")) nameFollow(this.parts.follow, sent.words);
    if (differs("listed")) showMissKeys(this.parts, sent.listed !== null);
    const isSeek = isOther || before.seek[1] !== sent.seek[1];
    if (isOther) {
      this.pictures.pin(null);
      this.visible.pin(null);
      this.shown = null;
      delete this.root.dataset.shownRow;
      delete this.root.dataset.shownFrame;
      this.view.fit();
      showScale(this);
      this.parts.picture.width = 0; // clears it; painting gives it its size again
    }
    const box = isSeek && sent.listed?.row === sent.seek[0] ? sent.listed.box : null;
    if (box && this.view.zoom > 1) this.view.centreOnBox({ x: box[0], y: box[1], w: box[2], h: box[3] });
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
    const { w, h } = this.look.areaOf(this.recording);
    const { style } = this.parts.stage;
    style.aspectRatio = `${this.look.nPanes * w} / ${h}`;
    // the transport stays in sight below the picture
    style.maxHeight = `min(${this.sent.height_px}px, max(300px, calc(100vh - 27.2rem)))`;
    this.fitHeight();
  }

  // The controls end within the window while the page is at its top, whatever stands above.
  fitHeight() {
    const { bar, stage } = this.parts;
    const isApart = this.dock?.isDocked || this.root.getRootNode().fullscreenElement === this.root;
    if (!this.sent.fits_window || !this.root.isConnected || isApart) return;
    const { top, bottom } = stage.getBoundingClientRect();
    const scrolled = this.dock?.around(SCROLLER)?.scrollTop ?? window.scrollY;
    const below = bar.getBoundingClientRect().bottom - bottom;
    const room = Math.floor(window.innerHeight - (top + scrolled) - below - BELOW_BAR_PX);
    stage.style.maxHeight = `min(${this.sent.height_px}px, ${Math.max(LEAST_STAGE_PX, room)}px)`;
  }

  // Whatever grows on the page or around the picture later leaves it another height.
  watchPage() {
    if (!this.sent.fits_window) return;
    const { bar, legend, sources } = this.parts;
    for (const part of [this.dock?.around(PAGE), legend, sources.root, bar]) if (part) this.observer.observe(part);
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
    else if (this.isStale && this.shown) this.paint(this.shown.row, this.shown);
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
    const isOther = (store, shown) => store.get(row) !== undefined && store.get(row) !== shown;
    return isOther(this.pictures, this.shown?.entry) || isOther(this.visible, this.shown?.visible);
  }

  resize() {
    this.fitHeight();
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
    this.view.set(this.look.areaOf(this.recording), stage.clientWidth / this.look.nPanes, stage.clientHeight);
    this.strip.resize(this.parts.stripHolder.clientWidth, ratio);
    this.parts.strip.style.height = `${this.strip.height}px`;
  }

  // shown: what is on the canvas already, should the stores have dropped it
  paint(row, shown = null) {
    const entry = shown?.entry ?? (this.recording.hasPicture(row) ? this.pictures.get(row) : undefined);
    const visible = shown?.visible ?? (this.look.hasVisible(row) ? this.visible.get(row) : undefined);
    const found = this.boxes.ofRow(row) ?? shown?.found ?? null;
    paintRow(this, row, { entry, visible, found });
    this.pictures.pin(entry ?? null);
    this.visible.pin(visible ?? null);
    this.shown = { row, entry, visible, found };
    if (this.isReady(row)) this.root.dataset.picture = this.look.mode;
    showClock(this.parts.sources, this.look, row, this.recording.endOf(row));
    this.isStale = false;
    this.root.dataset.shownRow = String(row);
    this.root.dataset.shownFrame = String(this.recording.frames[row]);
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
    const texts = [this.boxes.errorAt(row), this.hint];
    const { look, recording } = this;
    if (look.needsVisible) texts.push(look.hasVisible(row) ? this.shown?.visible?.error : NO_PICTURE);
    if (look.needsOwn && recording.hasPictures) {
      texts.push(recording.hasPicture(row) ? this.shown?.entry?.error : NO_PICTURE);
    } else if (look.needsOwn) texts.push("No pictures: boxes only");
    const isLate = !this.playing && this.row !== row && performance.now() - this.requestedAt > LOADING_TEXT_MS;
    if (isLate || this.shown === null) texts.unshift("Loading …");
    this.showMessage(texts.filter((text) => text)[0] ?? "");
  }

  // Words over the picture for a few seconds.
  showHint(text) {
    this.hint = text;
    clearTimeout(this.hintTimer);
    this.hintTimer = setTimeout(() => {
      this.hint = "";
      this.wake();
    }, HINT_MS);
    this.wake();
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
  zoomTo(zoom, at = null) {
    this.view.zoomTo(zoom, at);
    this.showView();
  }

  zoomStep(direction) {
    this.zoomTo(this.view.nextZoom(direction));
  }

  moveBy(right, down) {
    this.view.moveBy(right, down);
    this.showView();
  }

  showView() {
    this.card.hide();
    showScale(this);
    this.isStale = true;
    this.wake();
  }

  toggleLight() {
    this.parts.light.setAttribute("aria-expanded", String(!this.lightPanel));
    if (this.lightPanel) {
      this.lightPanel.remove();
      this.lightPanel = null;
      this.root.focus({ preventScroll: true });
      return;
    }
    const change = () => {
      this.isStale = true;
      this.wake();
    };
    this.lightPanel = makeLightPanel(this.light, change, () => this.toggleLight());
    this.parts.stage.append(this.lightPanel);
    this.lightPanel.querySelector("input").focus();
  }

  // whether anything lies over the picture that Escape takes away
  get hasOpen() {
    return Boolean(this.help || this.lightPanel || !this.card.part.hidden);
  }

  escape() {
    if (this.help) this.toggleHelp();
    else if (this.lightPanel) this.toggleLight();
    else this.card.hide();
  }

  toggleFollow() {
    if (this.chosen === null && !this.isFollowing) {
      const hint = worded("Choose {a_one} first: click its box, or press k", this.sent.words);
      this.say(hint);
      this.showHint(hint);
      return;
    }
    this.isFollowing = !this.isFollowing;
    this.parts.follow.setAttribute("aria-pressed", String(this.isFollowing));
    this.showView();
  }

  reportChosen(encounter) {
    this.reportChoice?.({ recording: this.sent.recording, encounter });
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
    this.help = makeHelp(this.sent.colours.picture, this.sent.words, () => this.toggleHelp());
    this.root.append(this.help);
    this.help.querySelector("button").focus();
  }

  destroy() {
    this.playing = null;
    cancelAnimationFrame(this.request);
    clearTimeout(this.settleTimer);
    clearTimeout(this.loadingTimer);
    clearTimeout(this.hintTimer);
    clearTimeout(this.lookTimer);
    this.dock?.destroy();
    this.card.hide();
    this.observer.disconnect();
    document.removeEventListener("keydown", this.onPageKey);
    this.pictures.pin(null);
    this.pictures.reset(() => "");
    this.visible.pin(null);
    this.visible.reset(() => "");
    this.boxes.reset("", "", 0);
  }
}
