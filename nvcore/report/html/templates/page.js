"use strict";
(async () => {
  const root = document.documentElement;
  const PAPER_PX = 695; // A4 less the margins of page.css
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
    const draw = (chart, onPaper = false) => {
      const { data, layout } = JSON.parse(chart.querySelector("script").textContent);
      if (onPaper) {
        layout.width = PAPER_PX;
        if (!layout.yaxis?.scaleanchor) {
          layout.height = Math.max(PAPER_HEIGHT * layout.height, Math.min(layout.height, LEAST_PX));
        }
      }
      Plotly.newPlot(chart.querySelector(".plot"), data, layout, config);
    };
    const isSeen = (chart) => chart.closest("details")?.open ?? true;
    const charts = [...document.querySelectorAll(".chart")];
    const drawAll = (onPaper) => charts.filter(isSeen).forEach((chart) => draw(chart, onPaper));
    for (const chart of charts) {
      chart.closest("details")?.addEventListener("toggle", () => isSeen(chart) && draw(chart));
    }
    drawAll(false);
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
