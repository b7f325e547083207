"use strict";
(async () => {
  const root = document.documentElement;
  const unpack = async (text) => {
    const bytes = Uint8Array.from(atob(text), (sign) => sign.charCodeAt(0));
    const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("gzip"));
    return new Response(stream).text();
  };
  try {
    const script = document.createElement("script");
    script.nonce = document.currentScript?.nonce || document.querySelector("script[nonce]").nonce;
    script.textContent = await unpack(document.getElementById("plotly").textContent);
    document.head.append(script);
    const config = JSON.parse(document.getElementById("config").textContent);
    for (const chart of document.querySelectorAll(".chart")) {
      const { data, layout } = JSON.parse(chart.querySelector("script").textContent);
      const plot = chart.querySelector(".plot");
      await Plotly.newPlot(plot, data, layout, config);
      const image = chart.querySelector(".printed");
      image.src = await Plotly.toImage(plot, { format: "svg", width: 760, height: layout.height });
      image.classList.toggle("tall", layout.height > 600);
      image.hidden = false;
      image.style.display = "none";
      chart.classList.add("drawn");
    }
    root.dataset.charts = "drawn";
  } catch (error) {
    document.getElementById("trouble").hidden = false;
    root.dataset.charts = "failed";
    console.error(error);
  }
})();
