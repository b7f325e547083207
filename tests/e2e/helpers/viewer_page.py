"""The viewer with a slider, a button that seeks, and a choice of recordings.

"start anew" puts everything back and mounts another viewer, as if the page were opened again.
"""

from __future__ import annotations

import numpy as np
import streamlit as st
import viewer_scene as scene

from ui.widgets.drawing import Look, VisiblePictures
from ui.widgets.viewer import ListedBox, viewer

RECORDINGS = [
    *("video", "boxes only", "sampled", "long", "slow", "ended", "empty", "two pictures"),
    "light known",
]

st.set_page_config(layout="wide")
START = {"seek": (5, 0), "alpha": 0.7, "kind": RECORDINGS[0], "hi": 100.0, "show": True, "runs": 0}
START.update(chosen=None, list=False, look=Look())
state = st.session_state


def start_anew() -> None:
    """Put all back, with another viewer."""
    state.update(START)
    state.visit += 1


for name, value in {**START, "visit": 1}.items():
    state.setdefault(name, value)

columns = st.columns(4)
alpha = columns[0].slider("alpha", 0.0, 1.0, step=0.05, key="alpha")
if columns[1].button("seek 123"):
    state.seek = (123, state.seek[1] + 1)
kind = columns[2].selectbox("recording", RECORDINGS, key="kind")
hi = columns[3].number_input("hi", 50.0, 100.0, key="hi")
columns[3].button("start anew", on_click=start_anew)
is_listed = columns[3].checkbox("list", key="list")

if not columns[1].checkbox("show", key="show"):
    st.stop()
n_rows = {"empty": 0, "long": scene.N_LONG}.get(kind, scene.N_ROWS)
rows = np.arange(n_rows)
has_picture = (rows < scene.FIRST_WITHOUT_PICTURE) & (kind not in ("boxes only", "long"))
fps = 2.0 if kind == "sampled" else scene.FPS
frames = scene.FIRST_FRAME + rows
traces = scene.similarities(alpha, n_rows)
spans = (scene.MISSED_BY_X, scene.MISSED_BY_Y, scene.MISSED_BY_BOTH)
pairs = [[(span.start, span.stop) for span in (own, spans[2])] for own in spans[:2]]
visible = None
if kind in ("two pictures", "light known"):
    # dark from row 10 on, light again from row 40 on
    seen_s = np.where(rows < 10, np.inf, (rows + 1 - 10) / fps) if kind == "light known" else None
    if seen_s is not None:
        seen_s[:3], seen_s[40:] = np.nan, np.inf
    visible = VisiblePictures(scene.VISIBLE_AREA, has_picture, seen_s)
    if seen_s is not None:
        # and dark for a moment within row 5, which no row's end shows
        visible = visible._replace(change_s=(scene.FIRST_FRAME + np.array([5.5, 10])) / fps)
settled = viewer(
    token="gone" if kind == "ended" else "token-of-the-test",
    recording=RECORDINGS.index(kind),
    n_rows=n_rows,
    width=scene.WIDTH,
    height=scene.HEIGHT,
    fps=fps,
    frames=frames,
    times_s=frames / fps,
    has_picture=has_picture,
    version=f"alpha {alpha}",
    traces=traces,
    low=0.5,
    intervals=pairs,
    misses=[span.start for span in spans] if n_rows else [],
    names=("<img src=x onerror=alert(1)>", "YOLOv3 visible"),
    seek=state.seek,
    lo=0.0,
    hi=hi,
    theme=st.context.theme.type or "light",
    height_px=520,
    key=f"viewer_{state.visit}",
    chosen=state.chosen,
    on_choose=lambda encounter: state.update(chosen=encounter),
    visible=visible,
    on_look=lambda look: state.update(look=look),
    listed=ListedBox(5, scene.LISTED) if is_listed else None,
)
state.runs += 1
st.text(f"settled {settled} alpha {alpha} kind {kind} run {state.runs} visit {state.visit}")
st.text(f"chosen {state.chosen}")
st.text(f"look {state.look}")
