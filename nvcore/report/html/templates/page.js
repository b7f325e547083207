"use strict";
// Everything here runs while the page is parsed, so that it may be printed at once.
{
  const root = document.documentElement;
  const PAPER_PX = 695; // A4 less the margins of page.css
  const LEGEND_ROW_PX = 22;
  const LEAST_PX = 250;
  const PAPER_HEIGHT = 0.67; // of its height on the screen, if a chart's scales are free

  /** The bytes of a gzip member without extra fields (RFC 1951, 1952). */
  const gunzip = (packed) => {
    const end = packed.length;
    const out = new Uint8Array(new DataView(packed.buffer).getUint32(end - 4, true));
    const ORDER = [16, 17, 18, 0, 8, 7, 9, 6, 10, 5, 11, 4, 12, 3, 13, 2, 14, 1, 15];
    let next = 10, held = 0, n_held = 0, size = 0;
    const bits = (n) => {
      for (; n_held < n; n_held += 8) held |= packed[next++] << n_held;
      const value = held & ((1 << n) - 1);
      held >>>= n;
      n_held -= n;
      return value;
    };
    const code = (lengths) => {
      const counts = new Uint16Array(16), starts = new Uint16Array(16);
      for (const length of lengths) counts[length]++;
      counts[0] = 0;
      for (let i = 1; i < 16; i++) starts[i] = starts[i - 1] + counts[i - 1];
      const symbols = new Uint16Array(lengths.length);
      lengths.forEach((length, symbol) => { if (length) symbols[starts[length]++] = symbol; });
      return () => {
        for (let length = 1, value = 0, first = 0, index = 0; ; length++) {
          value |= bits(1);
          const count = counts[length];
          if (value - count < first) return symbols[index + value - first];
          index += count;
          first = (first + count) << 1;
          value <<= 1;
        }
      };
    };
    const codes = () => {
      const n_literals = bits(5) + 257, n_distances = bits(5) + 1, n_orders = bits(4) + 4;
      const orders = new Uint8Array(19);
      for (let i = 0; i < n_orders; i++) orders[ORDER[i]] = bits(3);
      const next_length = code(orders), lengths = new Uint8Array(n_literals + n_distances);
      for (let i = 0; i < lengths.length; ) {
        const length = next_length();
        if (length < 16) lengths[i++] = length;
        else if (length === 16) lengths.fill(lengths[i - 1], i, (i += 3 + bits(2)));
        else i += length === 17 ? 3 + bits(3) : 11 + bits(7);
      }
      return [code(lengths.subarray(0, n_literals)), code(lengths.subarray(n_literals))];
    };
    for (let is_last = 0; !is_last; ) {
      is_last = bits(1);
      if (bits(2) !== 2) throw new Error("Plotly is packed in another way");
      const [literal, distance] = codes();
      for (let symbol; (symbol = literal()) !== 256; ) {
        if (symbol < 256) {
          out[size++] = symbol;
          continue;
        }
        const l = symbol - 257, n_extra = l < 8 || l === 28 ? 0 : (l >> 2) - 1;
        let n = l < 8 ? l + 3 : l === 28 ? 258 : ((4 + (l & 3)) << n_extra) + 3 + bits(n_extra);
        const d = distance(), n_more = d < 4 ? 0 : (d >> 1) - 1;
        const back = d < 4 ? d + 1 : ((2 + (d & 1)) << n_more) + 1 + bits(n_more);
        for (; n; n--, size++) out[size] = out[size - back];
      }
    }
    return new TextDecoder().decode(out);
  };

  try {
    const packed = atob(document.getElementById("plotly").textContent);
    const script = document.createElement("script");
    script.nonce = document.currentScript.nonce;
    script.textContent = gunzip(Uint8Array.from(packed, (sign) => sign.charCodeAt(0)));
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
}
