// A figure taken away: as picture, drawing or table of what is drawn.

import { asText, axisKey, headingOf } from "./figure.js";

const [LINE_PX, EDGE_PX, SCALE] = [20, 8, 2];

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

export async function savePicture(plot, format) {
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

export function saveData(plot) {
  save(new Blob(["\ufeff", csvOf(plot)], { type: "text/csv" }), fileName(plot, ".csv"));
}
