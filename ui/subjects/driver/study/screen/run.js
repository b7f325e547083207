// A run: bright, coarse pictures, cross, dark at once, picture, answer, cross, picture, answer.

import { Clock } from "./clock.js";
import { BRIGHT, DARK, Drawing } from "./drawing.js";
import { fetchTrial, outbox } from "./sending.js";

const STEP_PX = 8;
const LONG_STEP_PX = 64;
const TEXTS = {
  loading: "Getting the pictures …",
  answer: "Touch the place where the pedestrian was",
  kept: "The run is kept.",
  rest: "Rest as long as you like.",
  sending: "Keeping your answers …",
  unreached: "Your answers are not saved yet; trying again. Leave this page open until they are.",
};
const screens = new WeakMap();

function element(name, attributes = {}, text = "") {
  const made = document.createElement(name);
  for (const [key, value] of Object.entries(attributes)) made.setAttribute(key, value);
  made.textContent = text;
  return made;
}

class Stopped extends Error {}

class Screen {
  constructor(parent) {
    this.clock = new Clock();
    this.kept = []; // what was sent of the last run
    this.root = element("div", { class: "nv-study" });
    this.outside = element("button", { type: "button", class: "nv-begin", disabled: "" });
    this.message = element("p", { class: "nv-message", role: "status" });
    this.dialog = element("dialog", { "aria-label": "Study" });
    this.canvas = element("canvas", { tabindex: "-1" });
    this.bar = element("div", { class: "nv-bar" });
    this.text = element("span", { role: "status" });
    this.inside = element("button", { type: "button", class: "nv-begin" });
    this.unseen = element("button", { type: "button", class: "nv-unseen" }, "Not seen (N)");
    this.leave = element("button", { type: "button", class: "nv-stop" }, "Stop (Esc)");
    this.bar.append(this.text, this.inside, this.unseen, this.leave);
    this.dialog.append(this.canvas, this.bar);
    this.root.append(this.outside, this.message, this.dialog);
    parent.appendChild(this.root);
    this.drawing = new Drawing(this.canvas);
    this.listen();
  }

  listen() {
    for (const button of [this.outside, this.inside]) {
      button.addEventListener("click", () => this.begin());
    }
    this.leave.addEventListener("click", () => this.stop());
    this.unseen.addEventListener("click", (event) => this.settle(event, null, "unseen"));
    this.canvas.addEventListener("pointerdown", (event) => {
      const pixel = this.asked ? this.drawing.pixelAt(event, this.asked.trial) : null;
      if (pixel) this.settle(event, pixel, event.pointerType);
    });
    this.unseen.addEventListener("pointerdown", (event) => {
      this.pressedBy = event.pointerType;
    });
    this.dialog.addEventListener("cancel", (event) => {
      event.preventDefault();
      this.stop();
    });
    // a browser closes it at the second Esc, whatever we say
    this.dialog.addEventListener("close", () => this.stop());
    this.dialog.addEventListener("keydown", (event) => this.key(event));
    window.addEventListener("resize", () => {
      if (this.phase === "ready") this.rest();
    });
  }

  update(data, tell) {
    this.tell = tell;
    outbox.open(data.url, data.whose, (isGone) => this.retry(isGone));
    if (this.isOn) {
      this.next = data; // the page was drawn again, maybe by an app that has started anew
      return;
    }
    this.next = null;
    if (this.data && this.data.run === data.run && this.data.url === data.url) return;
    this.data = data;
    this.load();
  }

  // A page whose app has started anew is connected again, but not drawn again by itself.
  retry(isGone) {
    if (isGone) this.tell("kept", this.data.run);
    if (this.phase === "sending") this.message.textContent = this.text.textContent = TEXTS.unreached;
  }

  enter(phase) {
    this.phase = phase;
    this.root.dataset.phase = phase;
    this.root.dataset.run = this.data ? this.data.run : "";
    this.text.textContent = TEXTS[phase] || "";
    this.inside.hidden = phase !== "ready";
    this.unseen.hidden = phase !== "answer";
    this.leave.hidden = phase === "sending";
    this.dialog.dataset.ground = this.isBright() ? "bright" : "dark";
  }

  isBright() {
    return ["bright", "preview", "cross"].includes(this.phase);
  }

  // Offers the run, once all answers are kept; unless some are of its pictures: then, and after an
  // event, the page is told.
  async load(event = null) {
    const { data } = this;
    const { run, title, trials, url } = data;
    this.outside.textContent = this.inside.textContent = title;
    this.outside.disabled = true;
    try {
      this.message.textContent = TEXTS.sending;
      this.enter("sending");
      await outbox.sendLeft();
      if (this.data !== data) return;
      const isAnswered = trials.some((trial) => outbox.isAnswered(trial.place));
      if (event || isAnswered) this.tell(event || "kept", run);
      if (isAnswered) return;
      this.message.textContent = TEXTS.loading;
      this.enter("loading");
      const ready = await Promise.all(trials.map((trial) => fetchTrial(url, trial)));
      if (this.data !== data) return;
      this.trials = ready;
    } catch (error) {
      if (this.data === data) this.fail(error);
      return;
    }
    this.message.textContent = "";
    this.outside.disabled = false;
    this.enter("ready");
    if (this.dialog.open) this.rest();
  }

  fail(error) {
    this.enter("failed");
    this.outside.disabled = true; // until the page is loaded again
    this.message.textContent = `This does not work: ${error.message}`;
    this.text.textContent = this.message.textContent;
  }

  // Between two runs: dark, with the button.
  rest() {
    const kept = this.kept.length ? [TEXTS.kept] : []; // of practice nothing is
    this.text.textContent = [...kept, TEXTS.rest].join(" ");
    this.drawing.fit();
    this.drawing.ground(DARK);
    this.inside.focus();
  }

  async begin() {
    if (this.phase !== "ready") return;
    if (!this.dialog.open) this.dialog.showModal();
    this.fill();
    this.isStopped = false;
    this.isOn = true;
    this.kept = [];
    const { run } = this.data;
    try {
      await this.go();
      this.enter("sending");
      await Promise.all(this.kept);
      this.tell("ended", run);
      this.isOn = false;
    } catch (error) {
      this.isOn = false;
      if (error instanceof Stopped) this.end("stopped");
      else this.fail(error);
    }
    if (this.next && this.next.run !== run) this.update(this.next, this.tell);
  }

  // The whole screen, where the browser lets us; else the window.
  fill() {
    this.stayAwake();
    if (document.fullscreenElement || !document.fullscreenEnabled) return;
    document.documentElement.requestFullscreen().catch(() => {});
  }

  // A tablet that nobody touches for the length of a bright screen goes to sleep.
  async stayAwake() {
    try {
      // the browser releases it when the page is out of sight
      if (!this.lock || this.lock.released) this.lock = await navigator.wakeLock?.request("screen");
      if (!this.dialog.open) this.sleep();
    } catch {
      this.lock = null; // not allowed here, or the battery is low
    }
  }

  sleep() {
    this.lock?.release().catch(() => {});
    this.lock = null;
  }

  async go() {
    const { timing } = this.data;
    const [clock, drawing] = [this.clock, this.drawing];
    this.enter("bright");
    this.canvas.focus();
    drawing.fit();
    let since = await clock.show(() => drawing.ground(BRIGHT));
    await this.until(since + 1000 * timing.bright_s);
    drawing.fit(); // the whole screen by now
    drawing.prepare(this.trials);
    for (const trial of this.trials) {
      this.enter("preview");
      since = await clock.show(() => drawing.whole(trial.screens.preview));
      await this.until(since + 1000 * timing.preview_s);
    }
    this.enter("cross");
    since = await clock.show(() => drawing.cross(BRIGHT));
    await this.until(since + 1000 * timing.cross_s);
    let dark = null;
    for (const [index, trial] of this.trials.entries()) {
      this.root.dataset.picture = index + 1;
      dark = await this.showTrial(trial, dark);
    }
  }

  // Shows one picture and waits for its answer; the time of the change of light.
  async showTrial(trial, darkSince) {
    const { timing } = this.data;
    const [clock, drawing] = [this.clock, this.drawing];
    let dark = darkSince;
    if (dark === null && trial.adaptation_s > 0) {
      this.enter("dark");
      dark = await clock.show(() => drawing.cross(DARK));
    } else if (dark !== null) {
      this.enter("again");
      const again = await clock.show(() => drawing.cross(DARK));
      await this.until(again + 1000 * timing.again_s);
    }
    if (dark !== null) await this.until(dark + 1000 * trial.adaptation_s);
    this.enter("picture");
    const seen = await clock.show(() => drawing.whole(trial.screens.picture));
    dark = dark === null ? seen : dark;
    this.send(trial, "shown", { name: `${Date.now()} ${Math.random()}` });
    await this.until(seen + 1000 * timing.show_s);
    const gone = await clock.show(() => drawing.answer(trial, null));
    this.enter("answer");
    const answer = await this.ask(trial, gone);
    const report = this.report(trial, answer, { dark, seen, gone });
    this.send(trial, "answer", report);
    return dark;
  }

  async until(time, isOver = () => false) {
    await this.clock.until(time, () => this.isStopped || isOver());
    if (this.isStopped) throw new Stopped();
  }

  async ask(trial, gone) {
    const { answer_s: limit } = this.data.timing;
    this.asked = { trial, answer: null, pointer: null };
    await this.until(limit > 0 ? gone + 1000 * limit : Infinity, () => this.asked.answer);
    const { answer } = this.asked;
    this.asked = null;
    return answer;
  }

  settle(event, pixel, by) {
    if (!this.asked || this.asked.answer) return;
    const known = { unseen: event.detail ? this.pressedBy || "mouse" : "keyboard" }[by] || by;
    this.asked.answer = { pixel, by: known, time: event.timeStamp };
  }

  report(trial, answer, { dark, seen, gone }) {
    return {
      measured_s: (seen - dark) / 1000,
      shown_s: (gone - seen) / 1000,
      touch: answer && answer.pixel ? [answer.pixel.x, answer.pixel.y] : null,
      response_s: answer ? Math.max(0, answer.time - seen) / 1000 : null,
      is_answered: Boolean(answer),
      pointer: answer ? answer.by : "",
      shown_px: this.drawing.shownWidth(trial),
      screen_px: window.screen.width,
    };
  }

  send(trial, kind, content) {
    if (!trial.place) return; // practice
    const sent = outbox.add(trial.place, kind, content);
    sent.catch(() => {}); // said at the end of the run
    this.kept.push(sent);
  }

  key(event) {
    event.stopPropagation();
    if (event.key === "Tab" || event.key === "Escape") return;
    const isButton = event.target instanceof HTMLButtonElement;
    if (!this.asked || (isButton && (event.key === "Enter" || event.key === " "))) return;
    event.preventDefault();
    const { trial, pointer } = this.asked;
    const middle = { x: trial.width / 2, y: trial.height / 2 };
    const step = (event.shiftKey ? STEP_PX : LONG_STEP_PX) * (trial.width / 1920);
    const [dx, dy] = {
      ArrowLeft: [-step, 0], ArrowRight: [step, 0], ArrowUp: [0, -step], ArrowDown: [0, step],
    }[event.key] || [0, 0];
    if (event.key.toLowerCase() === "n") {
      this.settle(event, null, "keyboard");
    } else if ((event.key === "Enter" || event.key === " ") && pointer) {
      this.settle(event, pointer, "keyboard");
    } else if (dx || dy) {
      const from = pointer || middle;
      this.asked.pointer = {
        x: Math.min(Math.max(from.x + dx, 0), trial.width - 1),
        y: Math.min(Math.max(from.y + dy, 0), trial.height - 1),
      };
      this.drawing.answer(trial, this.asked.pointer);
    }
  }

  stop() {
    if (this.isOn) this.isStopped = true;
    else if (this.dialog.open) this.end();
  }

  // Back to the page, which is told what happened to the run, if anything; what was answered is kept.
  end(event = null) {
    this.asked = null;
    this.close();
    if (event) this.load(event);
  }

  close() {
    this.sleep();
    if (this.dialog.open) this.dialog.close();
    if (document.fullscreenElement) document.exitFullscreen().catch(() => {});
  }
}

export default function ({ data, parentElement, setTriggerValue }) {
  let screen = screens.get(parentElement);
  if (!screen) {
    screen = new Screen(parentElement);
    screens.set(parentElement, screen);
  }
  screen.update(data, setTriggerValue);
  return () => {
    if (!parentElement.isConnected) screen.close();
  };
}
