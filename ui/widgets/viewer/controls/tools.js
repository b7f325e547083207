// What changes how the picture is seen: zoom, brightness and contrast, following a pedestrian.

import { iconButton, make, textButton, worded } from "./elements.js";
import { factorAt, placeOf } from "../drawing/light.js";
import { LARGEST_ZOOM } from "../drawing/view.js";

export function makeViewTools(actions) {
  const zoomIn = textButton("+", "Zoom in", "+", actions.zoomIn);
  const zoomOut = textButton("−", "Zoom out", "−", actions.zoomOut);
  const scale = make("button", {
    type: "button", class: "icon scale", text: "100 %", title: "Scale, 100 % is the whole picture. Press to fit it (f)",
    "aria-label": "Scale 100 %: fit the picture",
  });
  scale.addEventListener("click", actions.fit);
  const light = iconButton("light", "Brightness and contrast", "b", actions.light);
  light.setAttribute("aria-expanded", "false");
  const follow = iconButton("follow", FOLLOW, "t", actions.follow);
  follow.setAttribute("aria-pressed", "false");
  return { zoomIn, zoomOut, scale, light, follow };
}

const FOLLOW = "Follow the chosen {one}";

export function nameFollow(button, words) {
  const label = worded(FOLLOW, words);
  button.title = `${label} (t)`;
  button.setAttribute("aria-label", label);
}

export function showScale({ parts, view }) {
  const percent = `${Math.round(100 * view.zoom)} %`;
  parts.scale.textContent = percent;
  parts.scale.setAttribute("aria-label", `Scale ${percent}: fit the picture`);
  parts.zoomIn.disabled = view.zoom >= LARGEST_ZOOM;
  parts.zoomOut.disabled = view.zoom <= 1;
  parts.picture.classList.toggle("movable", view.zoom > 1);
}

// Sliders over the picture, so that they are there in full screen too.
export function makeLightPanel(light, change, close) {
  const slider = (name, label) => {
    const field = make("input", { type: "range", min: "-1", max: "1", step: "0.05", "aria-label": label });
    field.value = String(placeOf(light[name]));
    const shown = make("output", { text: "" });
    const show = () => { shown.textContent = `${Math.round(100 * light[name])} %`; };
    field.addEventListener("input", () => {
      light[name] = factorAt(Number(field.value));
      show();
      change();
    });
    show();
    const reset = () => {
      field.value = "0";
      show();
    };
    return { row: make("label", {}, [make("span", { text: label }), field, shown]), reset };
  };
  const sliders = [slider("brightness", "Brightness"), slider("contrast", "Contrast")];
  const reset = make("button", { type: "button", class: "icon", text: "Reset" });
  reset.addEventListener("click", () => {
    light.reset();
    for (const one of sliders) one.reset();
    change();
  });
  const closer = iconButton("close", "Close", "b", close);
  return make("div", { class: "light", role: "group", "aria-label": "Brightness and contrast" }, [
    ...sliders.map((one) => one.row), reset, closer,
  ]);
}
