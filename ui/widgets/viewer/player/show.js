// Streamlit calls the default function again at every change of the data, with the same parent.

import { ClipViewer } from "./clip.js";
import { Viewer } from "./viewer.js";

const viewers = new WeakMap();

export default function show({ data, parentElement, setStateValue, setTriggerValue }) {
  let viewer = viewers.get(parentElement);
  if (!viewer) {
    viewer = data.only ? new ClipViewer() : new Viewer();
    viewers.set(parentElement, viewer);
    parentElement.append(viewer.holder);
  }
  viewer.update(
    data, (settled) => setStateValue("settled", settled), (chosen) => setTriggerValue("chosen", chosen),
    (look) => setTriggerValue("look", look),
  );
  // Also called for a call that a newer one has overtaken; only a viewer that is gone is ended.
  return () => setTimeout(() => {
    if (viewer.root.isConnected) return;
    viewer.destroy();
    viewers.delete(parentElement);
  }, 0);
}
