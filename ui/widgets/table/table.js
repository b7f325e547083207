// A table of which only the rows in sight are elements: thousands of rows cost what twenty do.

import { UNDEFINED, formatted } from "./number_format.js";

const ROW_PX = 29;
const AROUND = 8; // rows drawn above and below those in sight
const MOST_TEXT_PX = 300;
const MOST_STRETCH = 1.35; // a small table does not fill a wide page
const PADDING_PX = 18;
const ARROW_PX = 14;
const byText = new Intl.Collator(undefined, { numeric: true }).compare;
const pen = document.createElement("canvas").getContext("2d");
const tables = new WeakMap();

// JSON has no infinite numbers: they come as texts.
const INFINITE = { "∞": Infinity, "−∞": -Infinity };
const numeric = (value) => INFINITE[value] ?? value;

function element(tag, parent, properties = {}) {
  return parent.appendChild(Object.assign(document.createElement(tag), properties));
}

class Table {
  constructor(parent) {
    this.root = element("div", parent, { className: "nv-table" });
    this.scroller = element("div", this.root, { className: "nv-rows" });
    this.table = element("table", this.scroller);
    this.table.setAttribute("role", "grid");
    this.table.tabIndex = -1;
    this.widths = element("colgroup", this.table);
    this.head = element("tr", element("thead", this.table));
    this.above = element("tbody", this.table, { className: "space", ariaHidden: "true" });
    this.body = element("tbody", this.table, { className: "rows" });
    this.below = element("tbody", this.table, { className: "space", ariaHidden: "true" });
    this.at = [-1, 0]; // the cell that Tab leads to: its line, -1 for the headings, and its column
    this.sort = null;
    this.scroller.addEventListener("scroll", () => { this.drawRows(); this.hint(); });
    new ResizeObserver(() => this.setHeight()).observe(this.head); // it is out of sight at first, or wraps
    new ResizeObserver(() => this.hint()).observe(this.scroller);
    this.table.addEventListener("click", (event) => this.onClick(event));
    this.table.addEventListener("keydown", (event) => this.onKey(event));
  }

  update(data, tell) {
    const isNewRow = data.selected !== this.data?.selected;
    this.data = { ...data, values: data.values.map((values, i) => (data.columns[i].isNumber ? values.map(numeric) : values)) };
    this.tell = (clicked) => tell({ ...clicked, version: data.version });
    const { sortedBy } = data;
    if (sortedBy) this.sort = { column: data.names.indexOf(sortedBy.column), isDescending: sortedBy.isDescending };
    else if (this.sort && this.sort.column >= data.columns.length) this.sort = null;
    this.table.setAttribute("aria-label", data.name);
    this.table.setAttribute("aria-rowcount", data.nRows + 1);
    this.table.setAttribute("aria-colcount", data.columns.length);
    this.table.className = data.clicks ? `by-${data.clicks}` : "";
    this.root.style.setProperty("--row", `${ROW_PX}px`);
    this.at = [Math.min(this.at[0], data.nRows - 1), Math.min(this.at[1], data.columns.length - 1)];
    this.order();
    this.setWidths();
    this.drawHead();
    this.setHeight();
    if (isNewRow && data.selected !== null) this.reveal(this.rows.indexOf(data.selected));
    this.drawRows();
  }

  text(column, row) {
    const value = this.data.values[column][row];
    if (value === null) return UNDEFINED;
    const { form } = this.data.columns[column];
    if (typeof value !== "number") return value;
    return form || !Number.isFinite(value) ? formatted(value, form) : String(value).replace("-", "−");
  }

  // The longest text of a column; of numbers with a format it is that of the least or the largest.
  longest(column) {
    const values = this.data.values[column];
    let rows = [...values.keys()];
    if (this.data.columns[column].form) {
      const known = rows.filter((row) => values[row] !== null);
      const end = (way) => known.reduce((a, b) => (way * (values[b] - values[a]) > 0 ? b : a), known[0] ?? rows[0]);
      rows = rows.length ? [end(1), end(-1)] : [];
    }
    return rows.reduce((long, row) => {
      const text = this.text(column, row);
      return text.length > long.length ? text : long;
    }, "");
  }

  // What cannot be compared is last, whichever way the others stand.
  order() {
    this.rows = [...Array(this.data.nRows).keys()];
    if (!this.sort || this.data.sortedBy) return;
    const values = this.data.values[this.sort.column];
    const way = this.sort.isDescending ? -1 : 1;
    this.rows.sort((a, b) => {
      const [one, other] = [values[a], values[b]];
      if (one === null || other === null) return Number(one === null) - Number(other === null);
      if (one === other) return 0;
      return way * (typeof one !== "number" ? byText(one, other) : one > other ? 1 : -1);
    });
  }

  setHeight() {
    this.scroller.style.maxHeight = `${this.head.offsetHeight + ROW_PX * this.data.lines + 2}px`;
  }

  setWidths() {
    const { font, fontFamily, fontSize } = getComputedStyle(this.root);
    pen.font = font || `${fontSize} ${fontFamily}`;
    this.px = this.data.columns.map((column, i) => {
      const word = column.label.split(" ").reduce((long, part) => (part.length > long.length ? part : long), "");
      const ofHead = 1.1 * pen.measureText(word).width + (this.data.isSortable ? ARROW_PX : 0);
      const ofRows = Math.min(1.04 * pen.measureText(this.longest(i)).width, MOST_TEXT_PX);
      return Math.ceil(Math.max(ofHead, ofRows) + PADDING_PX);
    });
    const whole = this.px.reduce((sum, px) => sum + px, 0);
    this.scroller.style.width = `min(100%, ${Math.round(MOST_STRETCH * whole)}px)`;
    this.table.style.width = `max(${whole}px, 100%)`;
    this.widths.replaceChildren();
    for (const px of this.px) element("col", this.widths).style.width = `${px}px`;
    this.hint();
  }

  // Whether there are columns further to the right.
  hint() {
    const { scrollLeft, clientWidth, scrollWidth } = this.scroller;
    this.root.classList.toggle("goes-on", scrollLeft + clientWidth < scrollWidth - 1);
  }

  cell(tag, parent, column, text) {
    const { isHead, isNumber } = this.data.columns[column];
    const cell = element(tag, parent, { textContent: text, tabIndex: -1 });
    cell.classList.toggle("number", isNumber);
    cell.setAttribute("aria-colindex", column + 1);
    if (isHead) {
      cell.classList.add("head");
      const before = this.px.slice(0, column).filter((_, i) => this.data.columns[i].isHead);
      cell.style.left = `${before.reduce((sum, px) => sum + px, 0)}px`;
    }
    return cell;
  }

  drawHead() {
    const hadFocus = this.head.contains(this.root.getRootNode().activeElement);
    this.head.replaceChildren();
    this.head.setAttribute("aria-rowindex", 1);
    this.data.columns.forEach((column, i) => {
      const cell = this.cell("th", this.head, i, column.label);
      cell.scope = "col";
      cell.title = column.help;
      cell.classList.toggle("sorts", this.data.isSortable);
      if (this.sort?.column === i) cell.setAttribute("aria-sort", this.sort.isDescending ? "descending" : "ascending");
    });
    this.mark();
    if (hadFocus) this.cellAt(...this.at)?.focus({ preventScroll: true });
  }

  // Lines of the table that are elements: those in sight, and some around them.
  drawRows() {
    const { nRows: n, lines, columns, selected } = this.data;
    const top = Math.floor(this.scroller.scrollTop / ROW_PX);
    const [first, end] = [Math.max(0, top - AROUND), Math.min(n, top + lines + AROUND)];
    const hadFocus = this.body.contains(this.root.getRootNode().activeElement);
    this.first = first;
    for (const [part, count] of [[this.above, first], [this.below, n - end]]) {
      part.replaceChildren();
      if (count) element("td", element("tr", part), { colSpan: columns.length }).style.height = `${count * ROW_PX}px`;
    }
    this.body.replaceChildren();
    this.rows.slice(first, end).forEach((row, i) => {
      const line = element("tr", this.body);
      line.setAttribute("aria-rowindex", first + i + 2);
      line.classList.toggle("last", first + i === n - 1);
      if (this.data.clicks === "row") line.setAttribute("aria-selected", row === selected);
      columns.forEach((column, j) => {
        const text = this.text(j, row);
        const cell = this.cell(column.isHead ? "th" : "td", line, j, text);
        if (column.isHead) cell.scope = "row";
        if (text.length > 24) cell.title = text;
      });
    });
    this.mark();
    // keys go on from the cell that had the focus, also where it is out of sight
    if (hadFocus) (this.cellAt(...this.at) ?? this.table).focus({ preventScroll: true });
  }

  cellAt(line, column) {
    return (line < 0 ? this.head : this.body.rows[line - this.first])?.cells[column];
  }

  // Tab leads to one cell only; where that is out of sight, to the first heading.
  mark() {
    this.marked?.setAttribute("tabindex", -1);
    this.marked = this.cellAt(...this.at) ?? this.head.cells[0];
    this.marked?.setAttribute("tabindex", 0);
  }

  reveal(line) {
    const [top, height] = [line * ROW_PX, this.data.lines * ROW_PX];
    if (line < 0 || (top >= this.scroller.scrollTop && top + ROW_PX <= this.scroller.scrollTop + height)) return;
    this.above.replaceChildren(); // room to scroll in before the rows are there
    element("td", element("tr", this.above)).style.height = `${this.data.nRows * ROW_PX}px`;
    this.scroller.scrollTop = top < this.scroller.scrollTop ? top : top + ROW_PX - height;
  }

  moveTo(line, column) {
    this.at = [
      Math.max(-1, Math.min(line, this.data.nRows - 1)),
      Math.max(0, Math.min(column, this.data.columns.length - 1)),
    ];
    this.reveal(this.at[0]);
    this.drawRows();
    const cell = this.cellAt(...this.at);
    cell?.focus({ preventScroll: true });
    cell?.scrollIntoView({ block: "nearest", inline: "nearest" });
  }

  onClick({ target }) {
    const cell = target.closest("th, td");
    if (!cell || cell.closest(".space") || String(document.getSelection()).length) return;
    this.at = [cell.parentElement === this.head ? -1 : this.first + cell.parentElement.sectionRowIndex, cell.cellIndex];
    this.mark();
    this.take();
  }

  // What a click on the cell, or the Enter key, does.
  take() {
    const [line, column] = this.at;
    const { names, clicks, isSortable, sortedBy } = this.data;
    if (line >= 0) {
      if (clicks) this.tell({ row: this.rows[line], column: names[column] });
    } else if (isSortable && sortedBy) {
      this.tell({ row: null, column: names[column] });
    } else if (isSortable) {
      const isSame = this.sort?.column === column;
      this.sort = isSame && this.sort.isDescending ? null : { column, isDescending: isSame };
      this.order();
      this.drawHead();
      this.drawRows();
    }
  }

  onKey(event) {
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    const [line, column] = this.at;
    const { lines } = this.data;
    const moves = {
      ArrowUp: [line - 1, column], ArrowDown: [line + 1, column], ArrowLeft: [line, column - 1],
      ArrowRight: [line, column + 1], PageUp: [line - lines, column], PageDown: [line + lines, column],
      Home: [line, 0], End: [line, this.data.columns.length - 1],
    };
    if (moves[event.key]) this.moveTo(...moves[event.key]);
    else if (event.key === "Enter" || event.key === " ") this.take();
    else return;
    event.preventDefault();
    event.stopPropagation();
  }
}

export default function ({ data, parentElement, setTriggerValue }) {
  if (!tables.has(parentElement)) tables.set(parentElement, new Table(parentElement));
  tables.get(parentElement).update(data, (clicked) => setTriggerValue("clicked", clicked));
}
