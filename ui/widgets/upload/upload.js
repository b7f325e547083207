// Sends the chosen files one after the other and tells Python when the last has arrived.
// Names of files are shown as text only.

const SHOWN_ERRORS = 6;
const fields = new WeakMap();

function element(name, attributes = {}, text = "") {
  const made = document.createElement(name);
  for (const [key, value] of Object.entries(attributes)) made.setAttribute(key, value);
  made.textContent = text;
  return made;
}

function inMebibytes(bytes) {
  return `${(bytes / 2 ** 20).toFixed(bytes < 10 * 2 ** 20 ? 1 : 0)} MiB`;
}

class Field {
  constructor(parent) {
    this.waiting = [];
    this.errors = [];
    this.total = 0;
    this.done = 0;
    this.request = null;
    this.root = element("div", { class: "nv-upload", role: "group", "aria-label": "Pictures" });
    this.input = element("input", { type: "file", multiple: "", hidden: "", "aria-label": "Files" });
    this.choose = element("button", { type: "button" }, "Choose files");
    this.hint = element("span", { class: "nv-hint" });
    this.bar = element("progress", { max: "1", value: "0", "aria-label": "Sent", hidden: "" });
    this.stop = element("button", { type: "button", hidden: "" }, "Cancel");
    this.status = element("span", { class: "nv-hint", role: "status" });
    const row = element("div", { class: "nv-row" });
    row.append(this.choose, this.hint, this.bar, this.stop);
    this.root.append(row, this.input, this.status);
    parent.appendChild(this.root);

    this.choose.addEventListener("click", () => this.input.click());
    this.input.addEventListener("change", () => {
      this.add([...this.input.files]);
      this.input.value = "";
    });
    this.stop.addEventListener("click", () => this.cancel());
    this.root.addEventListener("dragover", (event) => {
      event.preventDefault();
      this.root.classList.add("nv-over");
    });
    this.root.addEventListener("dragleave", () => this.root.classList.remove("nv-over"));
    this.root.addEventListener("drop", (event) => {
      event.preventDefault();
      this.root.classList.remove("nv-over");
      this.add([...event.dataTransfer.files]);
    });
  }

  update(data, tell) {
    this.data = data;
    this.tell = tell;
    this.hint.textContent =
      "or drop them here: a video, pictures, or a ZIP archive of pictures for each recording, " +
      `up to ${(data.maxBytes / 2 ** 30).toFixed(0)} GiB a file`;
  }

  add(files) {
    if (!files.length) return;
    if (!this.request) {
      this.total = this.done = this.sent = 0;
      this.errors = [];
    }
    this.total += files.length;
    this.waiting.push(...files);
    this.show();
    if (!this.request) this.next();
  }

  next() {
    const file = this.waiting.shift();
    if (!file) {
      this.finish();
      return;
    }
    if (file.size > this.data.maxBytes) {
      this.fail(file, `is larger than ${(this.data.maxBytes / 2 ** 30).toFixed(0)} GiB`);
      return;
    }
    const request = new XMLHttpRequest();
    this.request = request;
    request.open("PUT", `${this.data.url}?name=${encodeURIComponent(file.name)}`);
    request.upload.addEventListener("progress", (event) => this.progress(file, event.loaded));
    request.addEventListener("load", () => {
      const isText = (request.getResponseHeader("content-type") || "").startsWith("text/plain");
      if (request.status === 201) {
        this.done += 1;
        this.sent += 1;
        this.show();
        this.next();
      } else {
        this.fail(file, isText ? request.responseText : `was refused (${request.status})`);
      }
    });
    request.addEventListener("error", () => this.fail(file, "was not taken; is the app still running?"));
    request.send(file);
    this.progress(file, 0);
  }

  fail(file, why) {
    this.done += 1;
    this.errors.push(`${file.name}: ${why}`);
    this.show();
    this.next();
  }

  cancel() {
    this.waiting = [];
    this.total = this.done;
    if (this.request) this.request.abort();
    this.finish();
  }

  finish() {
    this.request = null;
    this.show();
    const sent = this.sent === 1 ? "1 file sent" : `${this.sent} files sent`;
    const n = this.errors.length;
    this.status.textContent = n ? `${sent}, ${n} refused` : sent;
    this.tellRefused();
    // a new value every time, or Python would not hear of the second upload
    if (this.sent) this.tell("arrived", Date.now());
  }

  // Python says it at the field, and before anything is opened without these files
  tellRefused() {
    const lines = this.lines();
    if (!lines.length && !this.toldRefused) return;
    this.toldRefused = lines.length > 0;
    this.tell("refused", lines);
  }

  lines() {
    const lines = this.errors.slice(0, SHOWN_ERRORS);
    const more = this.errors.length - lines.length;
    if (more > 0) lines[lines.length - 1] += ` (and ${more} more)`;
    return lines;
  }

  progress(file, loaded) {
    this.bar.value = (this.done + (file.size ? loaded / file.size : 0)) / this.total;
    const which = this.total > 1 ? `${this.done + 1} of ${this.total}: ` : "";
    this.status.textContent = `${which}${file.name}, ${inMebibytes(loaded)} of ${inMebibytes(file.size)}`;
  }

  show() {
    const isBusy = Boolean(this.request) || this.waiting.length > 0;
    this.bar.hidden = this.stop.hidden = !isBusy;
    this.hint.hidden = isBusy;
  }
}

export default function ({ data, parentElement, setStateValue }) {
  let field = fields.get(parentElement);
  if (!field) {
    field = new Field(parentElement);
    fields.set(parentElement, field);
  }
  field.update(data, setStateValue);
}
