// A figure of the page. It stays where it is while its data change: Plotly draws what is different.
// Figures in sight come first, the others when the browser has nothing else to do.

import { drawCursor } from "./cursor.js";
import { Heading } from "./heading.js";
import { makeReachable, namePlot } from "./points.js";

const charts = new WeakMap();
let plotly = null; // a promise of Plotly, which comes once for all figures

function loadPlotly(address) {
  plotly ??= new Promise((done, failed) => {
    const script = document.createElement("script");
    script.src = address;
    script.onload = () => done(window.Plotly);
    script.onerror = () => {
      plotly = null; // the next change tries again
      failed(new Error(`${address} did not load`));
    };
    document.head.append(script);
  });
  return plotly;
}

function lengthOf(values) {
  return values?.bdata?.length ?? values?.length ?? 0;
}

// Where there are as many points as before, a part that was zoomed to stays in sight.
function revisionOf({ data, layout }) {
  const ranges = Object.keys(layout).filter((name) => /^[xy]axis/.test(name)).map((name) => layout[name].range);
  return JSON.stringify([data.map((trace) => lengthOf(trace.x ?? trace.z)), ranges]);
}

function isInSight(element) {
  const { top, bottom, width } = element.getBoundingClientRect();
  return width > 0 && bottom > 0 && top < window.innerHeight;
}

class Chart {
  constructor(parent) {
    this.plot = /** @type {any} */ (document.createElement("div"));
    this.plot.className = "nv-plot";
    this.heading = new Heading(this.plot);
    parent.append(this.heading.element, this.plot);
    this.onTime = () => drawCursor(this.plot);
    document.addEventListener("nvcore-time", this.onTime);
    this.words = "";
    this.drawn = { spec: "", width: 0 };
    this.waiting = null;
    this.sizes = new ResizeObserver(() => {
      if (this.plot.clientWidth && this.plot.clientWidth !== this.drawn.width) this.ask();
    });
    this.plot.addEventListener("fullscreenchange", () => this.ask());
    this.sizes.observe(this.plot);
  }

  update(data, tell) {
    this.data = data;
    const words = JSON.stringify([data.meta, data.help, data.alt, data.isClicked]);
    if (words !== this.words) { // else nothing of the page changes, nor does a link lose the focus
      this.words = words;
      this.heading.update(data.meta, data.help);
      namePlot(this.plot, data);
    }
    this.plot.nvClick = data.isClicked ? tell : null;
    this.plot.style.height = `${data.height}px`;
    if (data.spec !== this.drawn.spec || this.plot.layout?.meta?.join() !== data.meta.join()) this.ask();
  }

  ask() {
    if (this.waiting !== null) return;
    const isFirst = !this.drawn.spec;
    if (isFirst || isInSight(this.plot)) this.waiting = requestAnimationFrame(() => this.draw());
    else {
      this.waiting = 0;
      requestIdleCallback(() => this.draw(), { timeout: 500 });
    }
  }

  async draw() {
    const library = await loadPlotly(this.data.plotly).catch(() => null);
    this.waiting = null;
    if (!this.drawn.spec) this.plot.textContent = library ? "" : "The figure did not load. Reload the page.";
    if (!library) return;
    const width = this.plot.clientWidth;
    if (!width || !this.plot.isConnected) return; // folded: its width will tell
    const { spec, config, meta, isClicked } = this.data;
    const figure = JSON.parse(spec);
    if (document.fullscreenElement === this.plot) figure.layout.height = window.innerHeight;
    Object.assign(figure.layout, { meta, width, uirevision: revisionOf(figure) });
    if (isClicked) figure.layout.dragmode ??= "pan";
    this.drawn = { spec, width };
    await library.react(this.plot, figure.data, figure.layout, config);
    if (this.heading.menu.hidden) this.hear();
    drawCursor(this.plot);
  }

  // What a figure can do once it has been drawn.
  hear() {
    this.heading.menu.hidden = false;
    if (this.data.isClicked) makeReachable(this.plot);
    this.plot.on("plotly_afterplot", this.onTime);
    this.plot.on("plotly_relayouting", this.onTime);
  }

  end() {
    document.removeEventListener("nvcore-time", this.onTime);
    this.sizes.disconnect();
    window.Plotly?.purge(this.plot);
  }
}

export default function ({ data, parentElement, setTriggerValue }) {
  let chart = charts.get(parentElement);
  if (!chart) {
    chart = new Chart(parentElement);
    charts.set(parentElement, chart);
  }
  chart.update(data, (clicked) => setTriggerValue("clicked", clicked));
  // Also called for a call that a newer one has overtaken; only a figure that is gone is ended.
  return () => setTimeout(() => {
    if (chart.plot.isConnected) return;
    chart.end();
    charts.delete(parentElement);
  }, 0);
}
