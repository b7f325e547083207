"use strict";
(async () => {
  const root = document.documentElement;
  const PAPER_PX = 695; // A4 less the margins of page.css
  const LEGEND_ROW_PX = 22;
  const LEAST_PX = 250;
  const PAPER_HEIGHT = 0.67; // of its height on the screen, if a chart's scales are free

  // Browsers unpack in their own time. A frame that is being written counts as loading, and with it
  // the page: who prints waits for the charts, a browser without a window too.
  const waiting = document.createElement("iframe");
  waiting.hidden = true;
  root.append(waiting);
  waiting.contentDocument.open();
  const unpack = (text) => {
    const bytes = Uint8Array.from(atob(text), (sign) => sign.charCodeAt(0));
    return new Response(new Blob([bytes]).stream().pipeThrough(new DecompressionStream("gzip"))).text();
  };

  try {
    const script = document.createElement("script");
    script.nonce = document.currentScript.nonce;
    script.textContent = await unpack(document.getElementById("plotly").textContent);
    document.head.append(script);
    const config = JSON.parse(document.getElementById("config").textContent);
    const drawn = new Set();
    const draw = (chart, onPaper = false) => {
      const { data, layout } = JSON.parse(chart.querySelector("script").textContent);
      if (onPaper) {
        layout.width = PAPER_PX;
        if (!layout.yaxis?.scaleanchor) {
          layout.height = Math.max(PAPER_HEIGHT * layout.height, Math.min(layout.height, LEAST_PX));
        }
        if (layout.margin.autoexpand === false) { // room for one more row of the legend
          layout.margin.t += LEGEND_ROW_PX;
          layout.height += LEGEND_ROW_PX;
        }
      }
      Plotly.newPlot(chart.querySelector(".plot"), data, layout, config);
      drawn.add(chart);
    };
    const drawAll = (onPaper) => drawn.forEach((chart) => draw(chart, onPaper));
    for (const chart of document.querySelectorAll(".chart")) {
      const fold = chart.closest("details");
      if (fold) fold.addEventListener("toggle", () => draw(chart), { once: true });
      else draw(chart);
    }
    addEventListener("beforeprint", () => drawAll(true));
    addEventListener("afterprint", () => drawAll(false));
    root.dataset.charts = "drawn";
  } catch (error) {
    document.getElementById("trouble").hidden = false;
    root.dataset.charts = "failed";
    console.error(error);
  }
  waiting.contentDocument.close();
  waiting.remove();
})();
