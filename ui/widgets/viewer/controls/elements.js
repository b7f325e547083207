// What the elements around the canvas are made of.

export const ICONS = {
  first: "M6 5h2v14H6zM19 5v14L9 12z",
  last: "M16 5h2v14h-2zM5 5v14l10-7z",
  back: "M16 5v14L6 12z",
  forward: "M8 5v14l10-7z",
  // the corner marks that a missed pedestrian has in the picture, and the way to it
  missBack: "M7 7v10L1 12zM10 4h5v2h-3v3h-2zM22 4v5h-2V6h-3V4zM10 20v-5h2v3h3v2zM22 20h-5v-2h3v-3h2z",
  missForward: "M17 7v10l6-5zM2 4h5v2H4v3H2zM14 4v5h-2V6H9V4zM2 20v-5h2v3h3v2zM14 20H9v-2h3v-3h2z",
  play: "M7 4v16l13-8z",
  pause: "M6 5h4v14H6zM14 5h4v14h-4z",
  fit: "M3 3h7v2H5v5H3zM14 3h7v7h-2V5h-5zM3 14h2v5h5v2H3zM19 14h2v7h-7v-2h5z",
  full: "M14 3h7v7h-2V6.4l-5 5L12.600 10l5-5H14zM10 21H3v-7h2v3.600l5-5L11.400 14l-5 5H10z",
  light: "M12 3a9 9 0 1 0 0 18a9 9 0 1 0 0-18zM12 5v14a7 7 0 0 1 0-14z",
  follow: "M11 1h2v4h-2zM11 19h2v4h-2zM1 11h4v2H1zM19 11h4v2h-4zM12 6a6 6 0 1 0 0 12a6 6 0 1 0 0-12zM12 8a4 4 0 1 1 0 8a4 4 0 1 1 0-8zM12 10.500a1.500 1.500 0 1 0 0 3a1.500 1.500 0 1 0 0-3z",
  large: "M12 4l8 8h-5v8H9v-8H4z",
  cost: "M2 20 12 4l10 16H2zm4.500-2.600h11L12 8.600zM8.200 15.600h7.600L12 11.400z",
  labels: "M3 5h11l7 7-7 7H3zm3 5v4h4v-4z",
  close: "M6.400 5 12 10.600 17.600 5 19 6.400 13.400 12 19 17.600 17.600 19 12 13.400 6.400 19 5 17.600 10.600 12 5 6.400z",
};

// The text with the words of the objects, such as {one}: the pedestrian, sign or car.
export function worded(text, words) {
  return text.replace(/\{(\w+)\}/g, (_, name) => words[name]);
}

export function make(tag, attributes = {}, children = []) {
  const element = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) {
    if (name === "text") element.textContent = value;
    else element.setAttribute(name, value);
  }
  element.append(...children);
  return element;
}

export function svg(paths, size = 20) {
  const space = "http://www.w3.org/2000/svg";
  const element = document.createElementNS(space, "svg");
  const attributes = { viewBox: "0 0 24 24", width: size, height: size, "aria-hidden": "true", focusable: "false" };
  for (const [name, value] of Object.entries(attributes)) element.setAttribute(name, String(value));
  const path = document.createElementNS(space, "path");
  path.setAttribute("d", paths);
  path.setAttribute("fill", "currentColor");
  path.setAttribute("fill-rule", "evenodd");
  element.append(path);
  return element;
}

export function iconButton(name, label, key, act) {
  const title = key ? `${label} (${key})` : label;
  const button = make("button", { type: "button", "aria-label": label, title, class: "icon" }, [svg(ICONS[name])]);
  button.addEventListener("click", act);
  return button;
}

export function textButton(text, label, key, act) {
  const title = key ? `${label} (${key})` : label;
  const button = make("button", { type: "button", class: "icon text", text, "aria-label": label, title });
  button.addEventListener("click", act);
  return button;
}
