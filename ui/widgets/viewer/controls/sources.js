// Above the picture, where a recording has two of them: which one is seen, and as what eyes see it.

import { make } from "./elements.js";
import { LOOKS } from "../data/look.js";

const MODEL = "model, not measured";
const BY_HAND_HINT = "The time since the light has changed by a slider, in place of that of the recording";
const TUNNEL_HINT = "Simulate a change from bright to dark at this frame, and see the eyes adapt while it plays. "
  + "Press again to end it";

export function makeSources(actions) {
  const choice = make("select", { "aria-label": "Picture", title: "Which picture (v)" },
    LOOKS.map(([value, text]) => make("option", { value, text })));
  choice.addEventListener("change", () => actions.look({ picture: choice.value }));
  const slider = (label, attributes, change) => {
    const field = make("input", { type: "range", "aria-label": label, title: label, ...attributes });
    const shown = make("output", {});
    field.addEventListener("input", () => change(Number(field.value)));
    return { part: make("label", { class: "slide" }, [field, shown]), field, shown };
  };
  const blend = slider("Share of visible light", { min: "0", max: "1", step: "0.05" }, (value) => actions.look({ blend: value }));
  const since = slider("Seconds since the light has changed", { min: "0", max: "10", step: "0.1" },
    (value) => actions.look({ sinceS: value, isByHand: true }));
  const adapting = make("button", {
    type: "button", class: "icon text", "aria-pressed": "false",
  });
  adapting.addEventListener("click", () => actions.adapting());
  const tunnel = make("button", {
    type: "button", class: "icon text", text: "A tunnel ends here", title: TUNNEL_HINT, "aria-pressed": "false",
  });
  tunnel.addEventListener("click", () => actions.tunnel());
  const byHand = make("button", {
    type: "button", class: "icon text", text: "By hand", title: BY_HAND_HINT, "aria-pressed": "false",
  });
  byHand.addEventListener("click", () => actions.byHand());
  const clock = make("span", { class: "clock" });
  const model = make("span", { text: MODEL });
  // over the picture: there it moves nothing, and stays in full screen
  const seen = make("div", { class: "seen", hidden: "" }, [clock, model]);
  const root = make("div", { class: "sources", role: "group", "aria-label": "Pictures", hidden: "" }, [
    choice, blend.part, adapting, byHand, since.part, tunnel,
  ]);
  return { root, choice, blend, adapting, byHand, since, tunnel, seen, clock, model };
}

export function showSources({ root, choice, blend, adapting, byHand, since, tunnel, model }, look) {
  root.hidden = look.visible === null;
  choice.value = look.picture;
  blend.part.hidden = look.mode !== "blended";
  blend.field.value = String(look.blend);
  blend.shown.textContent = `${Math.round(100 * look.blend)} %`;
  const sight = look.visible?.sight;
  adapting.hidden = !look.needsVisible || !sight;
  adapting.textContent = sight?.label ?? "";
  adapting.title = sight ? `${sight.hint} (d)` : "";
  model.title = sight?.hint ?? "";
  adapting.setAttribute("aria-pressed", String(look.isAdapting));
  const isAdapting = look.needsVisible && look.isAdapting;
  const isSet = look.changeAt !== null;
  byHand.hidden = !isAdapting || isSet || !look.hasClock;
  byHand.setAttribute("aria-pressed", String(look.isByHand));
  since.part.hidden = !isAdapting || isSet || look.followsClock;
  tunnel.hidden = !isAdapting || !look.visible.can_simulate;
  tunnel.setAttribute("aria-pressed", String(isSet));
  since.field.value = String(look.sinceS);
  since.shown.textContent = `${look.sinceS.toFixed(1)} s`;
}

// That it is a model's picture, and the time since the change of light in the row that is painted; where a
// slider says that, it does.
export function showClock({ seen, clock }, look, row, endS) {
  seen.hidden = !(look.needsVisible && look.isAdapting);
  const isKnown = !seen.hidden && (look.changeAt !== null || look.followsClock);
  clock.hidden = !isKnown;
  clock.textContent = isKnown ? `${look.isSimulatedAt(row, endS) ? "simulated: " : ""}${sinceText(look, row, endS)}` : "";
}

function sinceText(look, row, endS) {
  const seconds = look.seenAt(row, endS);
  if (seconds !== null) return `${seconds.toFixed(2)} s after the change`;
  if (!look.followsClock) return "before the change";
  return Number.isNaN(look.ownSeconds(row)) ? "change of light not known" : "eyes adapted";
}
