// Every figure of the page gets a menu: picture (PNG, twice the size), drawing (SVG), data (CSV),
// and the whole screen.

import { followTime } from "./cursor.js";
import { asText, axisKey, headingOf } from "./figure.js";
import { reachPoints } from "./points.js";

const LABELS = [["png", "Picture (PNG)"], ["svg", "Drawing (SVG)"], ["csv", "Data as drawn (CSV)"],
  ["full", "Full screen"]];
const [LINE_PX, EDGE_PX, SCALE] = [20, 8, 2];
const ICON = `<svg viewBox="0 0 24 24" width="16" height="16" aria-hidden="true">
<path d="M12 4v11m-4.5-4.5L12 15l4.5-4.5M5 19.5h14" fill="none" stroke="currentColor"
stroke-width="2" stroke-linecap="round" stroke-linejoin="round"/></svg>`;

function fileName(plot, suffix) {
  const words = asText(headingOf(plot).title).toLowerCase().match(/[\p{L}\p{N}]+/gu) ?? ["figure"];
  return `${words.join("-").slice(0, 60)}${suffix}`;
}

// The page's font as a picture has to carry it, which can load nothing.
async function fontRules(family) {
  const rules = [...document.styleSheets].flatMap((sheet) => [...sheet.cssRules]).filter((rule) => (
    rule instanceof CSSFontFaceRule && rule.style.getPropertyValue("font-style") !== "italic"
      && rule.style.getPropertyValue("font-family").replace(/["']/g, "") === family
  ));
  return Promise.all(rules.map(async (rule) => {
    const [, address] = rule.cssText.match(/url\("?([^")]+)"?\)/);
    const answer = await fetch(new URL(address, rule.parentStyleSheet.href ?? document.baseURI));
    const reader = new FileReader();
    const loaded = new Promise((done) => { reader.onload = done; });
    reader.readAsDataURL(await answer.blob());
    await loaded;
    return rule.cssText.replace(/url\([^)]*\)/, `url("${reader.result}")`);
  }));
}

function linesOf(text, font, width) {
  const pen = document.createElement("canvas").getContext("2d");
  pen.font = font;
  return text.split(/\s+/).reduce((lines, word) => {
    const longer = `${lines.at(-1)} ${word}`.trim();
    return pen.measureText(longer).width <= width || !lines.at(-1)
      ? [...lines.slice(0, -1), longer] : [...lines, word];
  }, [""]);
}

// The figure as it is drawn, with its heading and the page's ground, which it leaves to the page.
async function drawingOf(plot) {
  const { width, height, font } = plot._fullLayout;
  const { title, subtitle } = headingOf(plot);
  const make = (name, attributes, text = "") => {
    const part = document.createElementNS("http://www.w3.org/2000/svg", name);
    Object.entries(attributes).forEach(([key, value]) => part.setAttribute(key, value));
    part.textContent = text;
    return part;
  };
  const lines = [[title, 16, 600], [subtitle, 12.5, 400]].flatMap(([text, size, weight]) => (
    linesOf(asText(text), `${weight} ${size}px ${font.family}`, width - 16)
      .filter(Boolean).map((line) => [line, size, weight])
  ));
  const top = lines.length * LINE_PX + 2 * EDGE_PX;
  const drawing = make("svg", {
    width, height: height + top, "font-family": font.family, "text-rendering": "geometricPrecision",
  });
  drawing.append(make("style", {}, (await fontRules(font.family.split(",")[0])).join("\n")));
  const fill = getComputedStyle(document.querySelector(".stApp")).backgroundColor;
  drawing.append(make("rect", { width, height: height + top, fill }));
  lines.forEach(([line, size, weight], row) => drawing.append(make("text", {
    x: EDGE_PX, y: EDGE_PX + (row + 0.75) * LINE_PX, "font-size": size, "font-weight": weight,
    fill: getComputedStyle(plot).color,
  }, line)));
  for (const layer of plot.querySelectorAll(".main-svg")) {
    const copy = layer.cloneNode(true);
    copy.querySelectorAll(".hoverlayer, .zoomlayer, .draglayer").forEach((part) => part.remove());
    copy.setAttribute("y", top);
    copy.style.background = "none";
    drawing.append(copy);
  }
  return drawing;
}

async function savePicture(plot, format) {
  const drawing = await drawingOf(plot);
  const text = new XMLSerializer().serializeToString(drawing);
  if (format === "svg") {
    save(new Blob([text], { type: "image/svg+xml" }), fileName(plot, ".svg"));
    return;
  }
  const picture = new Image();
  picture.src = `data:image/svg+xml;charset=utf-8,${encodeURIComponent(text)}`;
  await picture.decode();
  const canvas = document.createElement("canvas");
  [canvas.width, canvas.height] = [picture.width * SCALE, picture.height * SCALE];
  canvas.getContext("2d").drawImage(picture, 0, 0, canvas.width, canvas.height);
  canvas.toBlob((blob) => save(blob, fileName(plot, ".png")));
}

function cell(value) {
  if (value === null || value === undefined || Number.isNaN(value)) return "";
  if (typeof value === "number") return String(value);
  let text = asText(String(value));
  if (/^'*[=+\-@\t\r\n]/.test(text)) text = `'${text}`; // no spreadsheet runs it as a formula
  return /[",\r\n]/.test(text) ? `"${text.replaceAll('"', '""')}"` : text;
}

function titled(axis, letter) {
  const text = asText(axis?.title?.text ?? "");
  return text && !text.startsWith("Click to enter") ? text : letter;
}

// A row of an axis that names its rows is called by its name.
function onAxis(axis, value) {
  const at = axis?.ticktext ? Array.from(axis.tickvals ?? []).indexOf(value) : -1;
  return at < 0 ? value : axis.ticktext[at];
}

function rowsOfTrace(plot, trace) {
  const [xaxis, yaxis] = [plot._fullLayout[axisKey(trace.xaxis, "x")],
    plot._fullLayout[axisKey(trace.yaxis, "y")]];
  const name = trace.name?.startsWith("trace ") ? "" : trace.name;
  const rows = [];
  if (trace.z) {
    trace.z.forEach((line, row) => Array.from(line).forEach((value, column) => rows.push(
      [name, onAxis(xaxis, trace.x?.[column] ?? column), onAxis(yaxis, trace.y?.[row] ?? row),
        value, "", ""])));
    return rows;
  }
  const n = Math.max(trace.x?.length ?? 0, trace.y?.length ?? 0, trace.values?.length ?? 0);
  const error = trace.error_x?.visible ? trace.error_x : null;
  const isEach = Array.isArray(trace.text) || ArrayBuffer.isView(trace.text);
  for (let row = 0; row < n; row += 1) {
    const [x, y] = [trace.x?.[row], trace.y?.[row]];
    const up = error?.array?.[row];
    rows.push([name, onAxis(xaxis, x), onAxis(yaxis, y), isEach ? trace.text[row] : "",
      up === undefined ? "" : x - (error.arrayminus?.[row] ?? up), up === undefined ? "" : x + up]);
  }
  return rows;
}

function csvOf(plot) {
  const full = plot._fullLayout;
  const header = ["series", titled(full.xaxis, "x"), titled(full.yaxis, "y"), "value or text",
    "low", "high"];
  const traces = plot._fullData.filter((trace) => trace.visible === true);
  const rows = traces.flatMap((trace) => rowsOfTrace(plot, trace));
  const isHidden = [false, full.xaxis?.visible === false, full.yaxis?.visible === false];
  const isUsed = header.map((_, column) => !isHidden[column] && rows.some((row) => cell(row[column])));
  return [header, ...rows].map((row) => row.filter((_, column) => isUsed[column]).map(cell).join(","))
    .join("\n") + "\n";
}

function save(blob, name) {
  const link = document.createElement("a");
  link.href = URL.createObjectURL(blob);
  link.download = name;
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 10_000);
}

function saveData(plot) {
  save(new Blob(["\ufeff", csvOf(plot)], { type: "text/csv" }), fileName(plot, ".csv"));
}

// The chart that follows a heading; null while it is being drawn.
function plotAfter(heading) {
  const next = heading.closest('[data-testid="stElementContainer"]')?.nextElementSibling;
  const plot = next?.querySelector(".js-plotly-plot");
  return plot?._fullLayout && plot.querySelector(".main-svg") ? plot : null;
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

const NAMES = { "nv-help": "About this figure", "nv-take": "Take this figure away" };

// A heading may be another figure's by now, with what hangs on it.
function nameParts(heading) {
  const title = heading.querySelector("strong")?.textContent ?? "";
  for (const [part, words] of Object.entries(NAMES)) {
    const summary = heading.querySelector(`.${part} > summary`);
    const name = `${words}: ${title}`;
    if (!summary || summary.getAttribute("aria-label") === name) continue;
    if (!summary.hasAttribute("aria-label")) closesItself(summary.parentElement);
    summary.setAttribute("aria-label", name);
  }
  const menu = heading.querySelector(".nv-take:not(:last-child)");
  if (menu) heading.append(menu);
}

function addMenu(heading) {
  if (!plotAfter(heading)) return;
  const menu = document.createElement("details");
  menu.className = "nv-take";
  const summary = document.createElement("summary");
  summary.innerHTML = ICON;
  summary.title = NAMES["nv-take"];
  menu.append(summary);
  for (const [format, label] of LABELS) {
    const button = document.createElement("button");
    button.type = "button";
    button.textContent = label;
    button.addEventListener("click", () => {
      const shown = plotAfter(heading); // it may have been drawn anew
      if (format === "csv") saveData(shown);
      else if (format === "full") shown.requestFullscreen();
      else savePicture(shown, format);
      menu.open = false;
      summary.focus();
    });
    menu.append(button);
  }
  heading.append(menu);
}

export default function () {
  if (window.nvcoreFigureMenu) return;
  window.nvcoreFigureMenu = true;
  let isAsked = false;
  const look = () => {
    isAsked = false;
    document.querySelectorAll(".nv-figure:not(:has(.nv-take))").forEach(addMenu);
    document.querySelectorAll(".nv-figure").forEach(nameParts);
    reachPoints();
    followTime();
  };
  document.addEventListener("nvcore-time", followTime);
  document.addEventListener("pointerdown", ({ target }) => {
    document.querySelectorAll(":is(.nv-take, .nv-help)[open]").forEach((details) => {
      if (!details.contains(target)) details.open = false;
    });
  });
  new MutationObserver(() => {
    if (isAsked) return;
    isAsked = true;
    requestAnimationFrame(look);
  }).observe(document.body, { childList: true, subtree: true });
  look();
}
