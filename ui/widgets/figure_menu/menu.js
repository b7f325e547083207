// Every figure of the page gets a menu: picture (PNG, twice the size), drawing (SVG), data (CSV).

const LABELS = [["png", "Picture (PNG)"], ["svg", "Drawing (SVG)"], ["csv", "Data as drawn (CSV)"]];
const HEADING_PX = 58;
const ICON = `<svg viewBox="0 0 24 24" width="16" height="16" aria-hidden="true">
<path d="M12 4v11m-4.5-4.5L12 15l4.5-4.5M5 19.5h14" fill="none" stroke="currentColor"
stroke-width="2" stroke-linecap="round" stroke-linejoin="round"/></svg>`;

function headingOf(plot) {
  const [title = "Figure", subtitle = ""] = plot.layout.meta ?? [];
  return { title, subtitle };
}

function asText(html) {
  const box = document.createElement("template");
  box.innerHTML = html.replace(/<br\s*\/?>/g, " ");
  return box.content.textContent;
}

function fileName(plot, suffix) {
  const words = asText(headingOf(plot).title).toLowerCase().match(/[\p{L}\p{N}]+/gu) ?? ["figure"];
  return `${words.join("-").slice(0, 60)}${suffix}`;
}

// Plotly's own export, with the heading and the page's ground, which the chart leaves to the page.
function savePicture(plot, format) {
  const { title, subtitle } = headingOf(plot);
  const layout = plot.layout;
  const before = {
    paper: layout.paper_bgcolor, title: layout.title, margin: layout.margin, height: layout.height,
  };
  const ink = getComputedStyle(plot).color;
  const second = subtitle ? `<br><span style="font-size:12.5px">${subtitle}</span>` : "";
  layout.paper_bgcolor = getComputedStyle(document.querySelector(".stApp")).backgroundColor;
  layout.title = { ...before.title, text: `${title}${second}`, font: { size: 16, color: ink } };
  layout.margin = { ...before.margin, t: (before.margin?.t ?? 24) + HEADING_PX };
  const options = plot._context.toImageButtonOptions;
  Object.assign(options, {
    format, scale: format === "png" ? 2 : 1, filename: fileName(plot, ""),
    width: plot._fullLayout.width, height: plot._fullLayout.height + HEADING_PX,
  });
  try {
    plot.querySelector(".modebar-btn").click(); // copies the layout before it returns
  } finally {
    layout.paper_bgcolor = before.paper;
    layout.title = before.title;
    layout.margin = before.margin;
    layout.height = before.height;
  }
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

function axisKey(name, letter) {
  return `${letter}axis${(name ?? letter).slice(1)}`;
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

function saveData(plot) {
  const link = document.createElement("a");
  link.href = URL.createObjectURL(new Blob(["\ufeff", csvOf(plot)], { type: "text/csv" }));
  link.download = fileName(plot, ".csv");
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 10_000);
}

// The chart that follows a heading; null while it is being drawn.
function plotAfter(heading) {
  const next = heading.closest('[data-testid="stElementContainer"]')?.nextElementSibling;
  const plot = next?.querySelector(".js-plotly-plot");
  return plot?._fullLayout && plot.querySelector(".modebar-btn") ? plot : null;
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
  document.addEventListener("pointerdown", (event) => {
    if (!details.contains(event.target)) details.open = false;
  });
}

function nameHelp(details) {
  const summary = details.querySelector("summary");
  const title = details.closest(".nv-figure").querySelector("strong").textContent;
  summary.setAttribute("aria-label", `About this figure: ${title}`);
  closesItself(details);
}

function addMenu(heading) {
  const plot = plotAfter(heading);
  if (!plot) return;
  const menu = document.createElement("details");
  menu.className = "nv-take";
  const name = asText(headingOf(plot).title);
  const summary = document.createElement("summary");
  summary.innerHTML = ICON;
  summary.title = "Take this figure away";
  summary.setAttribute("aria-label", `Take this figure away: ${name}`);
  menu.append(summary);
  for (const [format, label] of LABELS) {
    const button = document.createElement("button");
    button.type = "button";
    button.textContent = label;
    button.addEventListener("click", () => {
      const shown = plotAfter(heading); // it may have been drawn anew
      if (format === "csv") saveData(shown);
      else savePicture(shown, format);
      menu.open = false;
      summary.focus();
    });
    menu.append(button);
  }
  closesItself(menu);
  heading.append(menu);
}

export default function () {
  if (window.nvcoreFigureMenu) return;
  window.nvcoreFigureMenu = true;
  let isAsked = false;
  const look = () => {
    isAsked = false;
    document.querySelectorAll(".nv-help > summary:not([aria-label])").forEach((of) => nameHelp(of.parentElement));
    document.querySelectorAll(".nv-figure:not(:has(.nv-take))").forEach(addMenu);
    reachPoints();
    followTime();
  };
  document.addEventListener("nvcore-time", followTime);
  new MutationObserver(() => {
    if (isAsked) return;
    isAsked = true;
    requestAnimationFrame(look);
  }).observe(document.body, { childList: true, subtree: true });
  look();
}
