// What stands above a figure: its title, how to read it behind a question mark, and the menu to take
// it away.

import { asText } from "./figure.js";
import { saveData, savePicture } from "./taking.js";

const ICON = `<svg viewBox="0 0 24 24" width="16" height="16" aria-hidden="true">
<path d="M12 4v11m-4.5-4.5L12 15l4.5-4.5M5 19.5h14" fill="none" stroke="currentColor"
stroke-width="2" stroke-linecap="round" stroke-linejoin="round"/></svg>`;
const WAYS = {
  "Picture (PNG)": (plot) => savePicture(plot, "png"),
  "Drawing (SVG)": (plot) => savePicture(plot, "svg"),
  "Data as drawn (CSV)": saveData,
  "Full screen": (plot) => plot.requestFullscreen(),
};
let isClosing = false; // whether a press elsewhere closes what is unfolded

function make(name, className, ...content) {
  const element = document.createElement(name);
  element.className = className;
  element.append(...content);
  return element;
}

// Escape, or a look elsewhere, closes what unfolds.
function closesItself(details) {
  details.addEventListener("keydown", (event) => {
    if (event.key !== "Escape" || !details.open) return;
    event.stopPropagation();
    details.open = false;
    details.querySelector("summary").focus();
  });
  details.addEventListener("focusout", (event) => {
    if (event.relatedTarget && !details.contains(event.relatedTarget)) details.open = false;
  });
}

function closeAtPress({ target }) {
  document.querySelectorAll(":is(.nv-take, .nv-help)[open]").forEach((details) => {
    if (!details.contains(target)) details.open = false;
  });
}

// Words and links, which are written [text](address).
function linked(text) {
  return text.split(/(\[[^\]]+\]\([^)\s]+\))/).map((words) => {
    const [, name, address] = words.match(/^\[(.+)\]\((.+)\)$/) ?? [];
    if (!name) return words;
    const link = make("a", "", name);
    Object.assign(link, { href: address, target: "_blank", rel: "noopener" });
    return link;
  });
}

export class Heading {
  constructor(plot) {
    this.title = make("strong", "");
    this.subtitle = make("span", "");
    this.help = make("details", "nv-help", make("summary", "", "?"), make("p", ""));
    this.menu = make("details", "nv-take", make("summary", ""));
    const [summary] = this.menu.children;
    summary.innerHTML = ICON;
    for (const [label, take] of Object.entries(WAYS)) {
      const button = make("button", "", label);
      button.type = "button";
      button.addEventListener("click", () => {
        take(plot);
        this.menu.open = false;
        summary.focus();
      });
      this.menu.append(button);
    }
    this.menu.hidden = true; // until there is something to take
    [this.help, this.menu].forEach(closesItself);
    if (!isClosing) document.addEventListener("pointerdown", closeAtPress);
    isClosing = true;
    this.element = make("div", "nv-figure", make("p", "", this.title, " ", this.subtitle), this.help, this.menu);
  }

  update([title, subtitle], help) {
    this.element.hidden = !title;
    this.title.textContent = asText(title);
    this.subtitle.textContent = asText(subtitle);
    this.help.hidden = !help;
    this.help.lastElementChild.replaceChildren(...linked(help ?? ""));
    for (const [fold, what] of [[this.help, "About this figure"], [this.menu, "Take this figure away"]]) {
      fold.firstElementChild.title = what;
      fold.firstElementChild.ariaLabel = `${what}: ${this.title.textContent}`;
    }
  }
}
