// Cases as a grid of crops, with the keys that decide on the selected one.

const FRAME_MS = 180;
const AGAIN_MS = 4000; // until what is not confirmed is sent again
const galleries = new WeakMap();
const calm = matchMedia("(prefers-reduced-motion: reduce)");

function element(tag, parent, properties = {}) {
  const made = Object.assign(document.createElement(tag), properties);
  parent?.append(made);
  return made;
}

class Gallery {
  constructor(parent) {
    this.client = crypto.randomUUID?.() ?? String(Math.random());
    this.n = 0; // number of the last message
    this.pending = []; // what Python has not confirmed yet
    this.drafts = new Map(); // notes on cases without a decision
    this.items = new Map();
    this.buttons = null;
    this.root = element("div", parent, { className: "nv-gallery" });
    this.grid = element("div", this.root, { className: "grid", role: "listbox", ariaLabel: "Cases" });
    this.panel = element("div", this.root, { className: "panel" });
    this.about = element("p", this.panel, { className: "about" });
    this.keys = element("div", this.panel, { className: "keys", role: "group", ariaLabel: "Decide" });
    this.note = element("input", this.panel, { className: "note", placeholder: "Note", ariaLabel: "Note", maxLength: 2000 });
    this.more = element("div", this.panel, { className: "keys" });
    this.count = element("span", this.more, { className: "count", role: "status" });
    this.undo = this.button(this.more, "u", "Undo", () => this.send({ kind: "undo" }));
    this.button(this.more, "↵", "Open", () => this.open());
    this.grid.addEventListener("click", (event) => this.onClick(event));
    this.grid.addEventListener("dblclick", () => this.open());
    this.grid.addEventListener("mouseover", (event) => this.play(this.idAt(event)));
    this.grid.addEventListener("mouseleave", () => this.play(null));
    this.root.addEventListener("keydown", (event) => this.onKey(event));
    this.note.addEventListener("change", () => this.keepNote());
    addEventListener("beforeunload", (event) => this.pending.length && event.preventDefault());
  }

  button(parent, key, words, onClick) {
    const button = element("button", parent, { type: "button", onclick: onClick });
    element("kbd", button, { textContent: key, ariaHidden: "true" });
    element("span", button, { textContent: words });
    return button;
  }

  update(data, tell) {
    const before = this.cases?.findIndex(({ id }) => id === this.selected);
    this.data = data;
    this.tell = tell;
    if (data.heard?.client === this.client) this.pending = this.pending.filter(({ n }) => n > data.heard.n);
    this.cases = data.cases.map((one) => ({ ...one }));
    for (const message of this.pending) this.apply(message);
    if (!this.find(this.selected ?? data.selected)) {
      this.selected = this.cases[Math.min(Math.max(before ?? 0, 0), this.cases.length - 1)]?.id;
    } else this.selected ??= data.selected;
    for (const [letter, [colour, line]] of Object.entries(data.styles)) {
      this.root.style.setProperty(`--${letter}`, colour);
      this.root.style.setProperty(`--line-${letter}`, line);
    }
    this.buttons ??= Object.entries(data.decisions).sort(([a], [b]) => Number(a === "0") - Number(b === "0"))
      .map(([key, value]) => ({ value, button: this.button(this.keys, key, value || "take back", () => this.decide(value)) }));
    this.draw();
  }

  find(id) {
    return this.cases.find((one) => one.id === id);
  }

  draw() {
    const hadFocus = this.grid.contains(this.root.getRootNode().activeElement);
    const known = new Set(this.cases.map(({ id }) => id));
    for (const [id, item] of this.items) {
      if (known.has(id)) continue;
      item.remove();
      this.items.delete(id);
    }
    this.cases.forEach((one, i) => {
      const item = this.items.get(one.id) ?? this.newItem(one.id);
      if (this.grid.children[i] !== item) this.grid.insertBefore(item, this.grid.children[i] ?? null);
      const [picture, state, text] = item.children;
      const address = this.address(one, one.at);
      if (picture.dataset.address !== address) Object.assign(picture, { src: address }).dataset.address = address;
      item.dataset.who = one.who || "none";
      item.classList.toggle("done", one.isDone);
      state.textContent = one.decision;
      text.textContent = one.text;
      item.ariaLabel = [one.about, one.decision || "open"].join(", ");
    });
    this.mark();
    if (hadFocus) this.items.get(this.selected)?.focus({ preventScroll: true });
  }

  newItem(id) {
    const item = element("div", null, { className: "case", role: "option" });
    element("img", item, { loading: "lazy", alt: "", width: 160, height: 100, decoding: "async" });
    element("span", item, { className: "state" });
    element("span", item, { className: "text" });
    item.dataset.id = id;
    this.items.set(id, item);
    return item;
  }

  address(one, i) {
    const { url, query } = this.data;
    return `${url}/${one.recording}/${one.rows[i]}.jpg?box=${one.boxes[i].join(",")}&${query}`;
  }

  // Tab leads to the selected case alone.
  mark() {
    for (const [id, item] of this.items) {
      item.ariaSelected = String(id === this.selected);
      item.tabIndex = id === this.selected ? 0 : -1;
    }
    const one = this.find(this.selected);
    const place = this.cases.indexOf(one) + 1;
    this.panel.hidden = !one;
    if (!one) return;
    this.root.dataset.selected = one.id;
    this.about.textContent = `${place}/${this.cases.length}  ${one.about}${one.others ? ` · ${one.others}` : ""}`;
    for (const { button, value } of this.buttons) button.ariaPressed = String(value !== "" && value === one.mine);
    const isTyping = this.root.getRootNode().activeElement === this.note && this.noteOf === one.id;
    if (!isTyping) this.note.value = this.drafts.get(one.id) ?? one.note;
    this.noteOf = one.id;
    const { done, n } = this.data.counts;
    const ahead = this.cases.reduce((sum, { isDone }, i) => sum + Number(isDone) - Number(this.data.cases[i].isDone), 0);
    const late = this.isLate && this.pending.length ? `, ${this.pending.length} not stored` : "";
    this.count.textContent = `${done + ahead} of ${n} done${late}`;
    this.undo.disabled = !(this.data.canUndo || this.pending.length);
  }

  select(id, hasFocus = true) {
    if (!this.find(id)) return;
    this.keepNote();
    this.selected = id;
    this.mark();
    const item = this.items.get(id);
    if (hasFocus) item.focus({ preventScroll: true });
    item.scrollIntoView({ block: "nearest" });
  }

  idAt(event) {
    return event.target.closest?.(".case")?.dataset.id;
  }

  onClick(event) {
    const id = this.idAt(event);
    if (id) this.select(id);
  }

  step(key) {
    const at = this.cases.findIndex(({ id }) => id === this.selected);
    const columns = getComputedStyle(this.grid).gridTemplateColumns.split(" ").length;
    const steps = { ArrowLeft: -1, ArrowRight: 1, ArrowUp: -columns, ArrowDown: columns, Home: -at, End: this.cases.length - 1 - at };
    if (!(key in steps)) return false;
    this.select(this.cases[at + steps[key]]?.id);
    return true;
  }

  onKey(event) {
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    const { key, target } = event;
    const isNote = target === this.note;
    if (isNote && (key === "Enter" || key === "Escape")) this.items.get(this.selected)?.focus();
    else if (!isNote) {
      const decision = this.data.decisions[key];
      const isOnCase = this.grid.contains(target);
      if (decision !== undefined) this.decide(decision);
      else if (key === "u") this.undo.click();
      else if (isOnCase && key === "Enter") this.open();
      else if (!(isOnCase && this.step(key))) return;
    }
    if (!isNote || key === "Enter" || key === "Escape") event.preventDefault();
    event.stopPropagation();
  }

  decide(decision) {
    const one = this.find(this.selected);
    if (!one || (!decision && !one.mine)) return;
    const note = decision ? this.note.value : "";
    this.drafts.delete(one.id);
    this.send({ kind: "decide", case: one.id, decision, note, seen: this.data.seen });
  }

  // A note belongs to a decision; until there is one it waits.
  keepNote() {
    const one = this.find(this.noteOf);
    if (!one || this.note.value === (this.drafts.get(one.id) ?? one.note)) return;
    if (!one.mine) this.drafts.set(one.id, this.note.value);
    else this.send({ kind: "decide", case: one.id, decision: one.mine, note: this.note.value, seen: this.data.seen });
  }

  // Messages may overtake each other: each one holds all that are not confirmed.
  send(message) {
    this.n += 1;
    this.pending.push({ ...message, n: this.n });
    this.apply(message);
    this.tell("told", { client: this.client, messages: this.pending });
    this.draw();
    this.sendAgain();
  }

  // The server may have been away: nothing is lost, and the page says what is not stored.
  sendAgain() {
    clearTimeout(this.again);
    this.again = setTimeout(() => {
      this.isLate = this.pending.length > 0;
      if (this.isLate) {
        this.tell("told", { client: this.client, messages: this.pending });
        this.sendAgain();
      }
      this.draw();
    }, AGAIN_MS);
  }

  apply({ kind, case: id, decision, note }) {
    const one = kind === "decide" && this.find(id);
    if (!one) return;
    const isAlone = !one.others;
    Object.assign(one, { mine: decision, note });
    if (isAlone) Object.assign(one, { decision, isDone: !["", "ask"].includes(decision) });
  }

  open() {
    if (this.selected) this.tell("opened", { case: this.selected });
  }

  play(id) {
    if (id === undefined || id === this.playing) return;
    clearInterval(this.timer);
    const last = this.items.get(this.playing)?.firstChild;
    if (last) last.src = last.dataset.address;
    this.playing = id;
    const one = this.find(id);
    if (!one || calm.matches || one.rows.length < 2) return;
    const picture = this.items.get(id).firstChild;
    const frames = one.rows.map((_, i) => Object.assign(new Image(), { src: this.address(one, i) }));
    let i = 0;
    this.timer = setInterval(() => {
      const frame = frames[i % frames.length];
      if (!frame.complete) return; // wait for it
      if (frame.naturalWidth) picture.src = frame.src;
      i += 1;
    }, FRAME_MS);
  }
}

export default function ({ data, parentElement, setTriggerValue }) {
  if (!galleries.has(parentElement)) galleries.set(parentElement, new Gallery(parentElement));
  galleries.get(parentElement).update(data, setTriggerValue);
}
