// The elements around the canvas: legend with layer switches, transport, help. Text from files is
// only ever set as text.

import { iconButton, make, textButton, worded } from "./elements.js";
import { makeSources } from "./sources.js";
import { makeViewTools } from "./tools.js";
import { SOURCE } from "../data/boxes.js";
import { drawBoxes, missedBy } from "../drawing/drawing.js";

const SPEEDS = [0.25, 0.5, 1, 2, 4];

const KEYS = [
  ["Space", "play or pause"],
  ["← →", "one frame back or forward"],
  ["Shift + ← →", "one second back or forward"],
  ["Home End", "first or last frame"],
  ["n p", "next or previous miss begins; with Shift while a list is open, whose entries they lead to"],
  ["k Shift + k", "choose the next or previous {one} of the frame, and say what it counts and costs"],
  ["x y g", "show or hide X, Y, ground truth"],
  ["l", "show or hide labels"],
  ["c", "what missing {a_one} would cost, by where the {feet_are}"],
  ["t", "follow the chosen {one}, four times as large in a corner"],
  ["b", "brightness and contrast"],
  ["v d", "where there are pictures of visible light: the next way to see them; as eyes see them that adapt"],
  ["+ −", "zoom (also Ctrl + wheel; drag to move)"],
  ["f", "fit the picture"],
  ["?", "this help"],
];

// Those of the keys that are told below the picture.
const USUAL_KEYS = [
  [["space"], "play"], [["←", "→"], "frame"], [["x", "y", "g"], "hide X, Y, truth"],
  [["k"], "why"], [["?"], "all keys"],
];

const SAMPLES = [
  [{ source: "truth", state: 8 | 2 | 4 }, "{one} found by both (ground truth, thin)"],
  [{ source: "x", state: 1 }, "detection of X"],
  [{ source: "y", state: 1 }, "detection of Y"],
  [{ source: "truth", state: 8 | 4 }, "missed by X"],
  [{ source: "truth", state: 8 | 16 | 32 }, "missed by both; ▼ the miss that costs a system most here"],
  [{ source: "y", state: 2 }, "false alarm (crossed out)"],
  [{ source: "truth", state: 0 }, "too far to count, or ignored (dotted)"],
];

// An icon with the word "miss": the icon alone would be taken for fast forward.
function wordedButton(name, label, key, act) {
  const button = iconButton(name, label, key, act);
  button.classList.add("worded");
  button.append(make("span", { text: "miss" }));
  return button;
}

// A switch of the legend: line sample, name, what the system does in this frame.
function legendButton(layer, act) {
  const button = make("button", { type: "button", "aria-pressed": "true", class: `layer ${layer}` }, [
    make("span", { class: "sample", "aria-hidden": "true" }),
    make("span", { class: "name" }),
    make("span", { class: "counts" }),
  ]);
  button.addEventListener("click", act);
  return button;
}

export function makeControls(actions) {
  const parts = {};
  parts.legend = make("div", { class: "legend", role: "group", "aria-label": "Layers" });
  for (const layer of ["x", "y", "truth"]) {
    parts[layer] = legendButton(layer, () => actions.toggle(layer));
    parts.legend.append(parts[layer]);
  }
  parts.picture = make("canvas", { class: "picture", role: "img", "aria-label": "Loading" });
  parts.message = make("div", { class: "message", hidden: "" });
  parts.sources = makeSources(actions);
  parts.stage = make("div", { class: "stage" }, [parts.picture, parts.message, parts.sources.seen]);
  parts.strip = make("canvas", { class: "strip", role: "slider", "aria-label": "Position in the recording" });
  parts.tip = make("div", { class: "tip", hidden: "", "aria-hidden": "true" });
  parts.stripHolder = make("div", { class: "strip-holder" }, [parts.strip, parts.tip]);
  parts.play = iconButton("play", "Play", "space", actions.playPause);
  parts.play.classList.add("play");
  parts.labels = iconButton("labels", "Labels", "l", () => actions.toggle("labels"));
  parts.cost = iconButton("cost", "Cost of a miss, by place", "c", () => actions.toggle("cost"));
  parts.cost.setAttribute("aria-pressed", "false");
  parts.speed = make("select", { "aria-label": "Speed", title: "Speed" },
    SPEEDS.map((speed) => make("option", { value: String(speed), text: `${speed}×` })));
  parts.speed.value = "1";
  parts.speed.addEventListener("change", () => actions.speed(Number(parts.speed.value)));
  parts.readout = make("div", { class: "readout" }, [
    make("span", { class: "frame" }), make("span", { class: "time" }), make("span", { class: "row" }),
  ]);
  Object.assign(parts, makeViewTools(actions));
  parts.full = iconButton("full", "Full screen", "", actions.fullScreen);
  parts.help = make("button", { type: "button", class: "icon text", text: "?", "aria-label": "Keys and legend", title: "Keys and legend (?)" });
  parts.help.addEventListener("click", actions.help);
  parts.bar = make("div", { class: "bar", role: "toolbar", "aria-label": "Transport" }, [
    iconButton("first", "First frame", "Home", actions.first),
    wordedButton("missBack", "Previous miss", "p", actions.previousMiss),
    textButton("−1 s", "One second back", "Shift + ←", actions.secondBack),
    iconButton("back", "Previous frame", "←", actions.previous),
    parts.play,
    iconButton("forward", "Next frame", "→", actions.next),
    textButton("+1 s", "One second forward", "Shift + →", actions.secondForward),
    wordedButton("missForward", "Next miss", "n", actions.nextMiss),
    iconButton("last", "Last frame", "End", actions.last),
    parts.speed, parts.readout,
    make("div", { class: "view-tools" }, [
      parts.zoomOut, parts.scale, parts.zoomIn, parts.light, parts.follow, parts.labels, parts.cost, parts.full, parts.help,
    ]),
  ]);
  parts.large = iconButton("large", "Back to the large picture", "", actions.large);
  parts.closeDock = iconButton("close", "Close the small viewer", "", actions.closeDock);
  parts.dock = make("div", { class: "dock" }, [parts.large, parts.closeDock]);
  parts.missKeys = make("span", {});
  const keys = USUAL_KEYS.map((usual) => make("span", {}, keyTexts(...usual)));
  keys.splice(2, 0, parts.missKeys);
  parts.keys = make("div", { class: "keys", "aria-hidden": "true" }, keys); // "?" tells them too
  parts.spoken = make("div", { class: "spoken", role: "status", "aria-live": "polite" });
  parts.root = make("div", {
    class: "viewer", role: "group", tabindex: "0", "aria-label": "Frame viewer; press ? for its keys",
  }, [parts.legend, parts.sources.root, parts.dock, parts.stage, parts.stripHolder, parts.bar, parts.keys, parts.spoken]);
  return parts;
}

function keyTexts(names, meaning) {
  return [...names.flatMap((name) => [make("kbd", { text: name }), " "]), meaning];
}

// While a list is walked through, n and p lead along it, and Shift with them to misses.
export function showMissKeys({ bar, missKeys }, isListed) {
  const shift = isListed ? "Shift + " : "";
  missKeys.replaceChildren(...keyTexts([`${shift}n`, `${shift}p`], "next, previous miss"));
  for (const [label, key] of [["Next miss", "n"], ["Previous miss", "p"]]) {
    bar.querySelector(`[aria-label="${label}"]`).title = `${label} (${shift}${key})`;
  }
}

export function makeHelp(palette, words, close) {
  const closer = iconButton("close", "Close", "Esc", close);
  const keys = make("dl", {}, KEYS.flatMap(([key, meaning]) =>
    [make("dt", { text: key }), make("dd", { text: worded(meaning, words) })]));
  const samples = make("ul", {}, SAMPLES.map(([sample, meaning]) =>
    make("li", {}, [drawSample(sample, palette), make("span", { text: worded(meaning, words) })])));
  const note = make("p", {
    text: "The keys work while the picture is in sight and nothing is being typed; arrows and space move a slider or press a button while that has the focus. Playback is in real time. Recordings sampled more slowly than four frames a second play at four frames a second.",
  });
  return make("div", { class: "help", role: "dialog", "aria-label": "Keys and legend" }, [
    closer, make("div", { class: "columns" }, [keys, samples]), note,
  ]);
}

// The legend is drawn by the code that draws the picture, so that they cannot differ.
function drawSample(sample, palette) {
  const isMiss = sample.source === "truth" && missedBy(sample.state) !== "";
  const width = 84;
  const height = isMiss ? 66 : 44;
  const ratio = window.devicePixelRatio || 1;
  const canvas = make("canvas", { "aria-hidden": "true" });
  canvas.width = width * ratio;
  canvas.height = height * ratio;
  canvas.style.width = `${width}px`;
  canvas.style.height = `${height}px`;
  const ctx = canvas.getContext("2d");
  ctx.scale(ratio, ratio);
  const found = {
    start: 0, stop: 1,
    boxes: {
      x: [31], y: [isMiss ? 38 : 7], w: [22], h: [isMiss ? 22 : 30], score: [NaN], track: [-1],
      source: [SOURCE[sample.source]], state: [sample.state],
    },
  };
  const layers = { truth: true, x: true, y: true, labels: false };
  drawBoxes(ctx, found, { scale: 1, x: 0, y: 0 }, layers, palette, { x: 0, y: 0, w: width, h: height });
  return canvas;
}
