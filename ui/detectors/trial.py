"""Detectors page: the detector on the current frame, threshold and overlap moved at once."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, Final

import numpy as np
import streamlit as st

from nvcore.detectors.base import Detections
from nvcore.detectors.candidates import MOST, counting, usual_threshold
from nvcore.detectors.figures import box_text, boxes_plot
from nvcore.detectors.registry import run_settings
from nvcore.figures.style import plain
from nvcore.pictures import Picture
from nvcore.schema import DetectionState
from nvcore.wording import count_text, minus
from ui.detectors import asking
from ui.detectors.confined import DetectorFacts, DetectorSpec
from ui.detectors.outcome import Outcome, outcome_of
from ui.session import state, store
from ui.widgets.charts import clicked_chart
from ui.widgets.text import plain as as_text

"""Threshold and overlap of each detector, by its name or path."""
LEAST_SPAN: Final = 0.1
STEPS: Final = 200
"""Of the slider of the threshold."""
MOST_DECIMALS: Final = 4
"""Of a threshold beside the slider's steps: a detector's own need not lie on one."""


@dataclass(frozen=True)
class Levels:
    """What counts: lowest score, and the overlap from which on the less confident box goes."""

    threshold: float
    overlap: float


def levels_of(spec: DetectorSpec, what: DetectorFacts) -> Levels:
    """Threshold and overlap as they are set; at first the detector's own."""
    overlap = what.about.settings["overlap"]
    assert isinstance(overlap, int | float)
    usual = Levels(usual_threshold(what.about), float(overlap))
    return store.DETECTOR_LEVELS.get().get(spec.text, usual)


def chosen_box(spec: DetectorSpec, boxes: Detections) -> int | None:
    """Row of the box that was clicked, else of the most confident one; None: there is none."""
    where, row = store.DETECTOR_BOX.get()
    if where == (spec, asking.place()) and row < len(boxes):
        return int(row)
    return 0 if len(boxes) else None


@st.fragment
def draw(
    spec: DetectorSpec, what: DetectorFacts, picture: Picture, *, has_run: bool = False
) -> None:
    """The picture with the boxes, beside the controls; a click chooses a box.

    Parameters
    ----------
    has_run
        Whether there is a run below, which says what it has not in common with the controls.
    """
    boxes, before = asking.found(spec, picture), levels_of(spec, what)
    left, right = st.columns([3, 1], gap="medium")
    with right:
        levels = _draw_levels(spec, what, boxes)
    if has_run and levels != before:
        st.rerun()  # of the whole page: this part alone is drawn while a slider moves
    is_counting = counting(boxes, what.about, threshold=levels.threshold, overlap=levels.overlap)
    dataset, row = state.opened().dataset, state.row_in_all()
    classes, params = what.about.labels, state.params()
    outcome = outcome_of(dataset, row, picture, boxes, is_counting, params, classes=classes)
    chosen = _clicked_box(spec, boxes, levels)
    with right:
        _draw_numbers(boxes, is_counting, levels)
        _draw_outcome(outcome)
        _draw_chosen(boxes, is_counting, outcome, chosen)
    with left:
        clicked = _draw_boxes(what, picture, boxes, is_counting, levels, outcome, chosen)
    if clicked is not None:
        row = clicked[0] if isinstance(clicked, list) else clicked
        store.DETECTOR_BOX.set(((spec, asking.place()), int(row)))
        st.rerun()


def _draw_levels(spec: DetectorSpec, what: DetectorFacts, boxes: Detections) -> Levels:
    """The two sliders, at what was set for this detector."""
    before = levels_of(spec, what)
    ends = np.append(boxes.score, before.threshold)
    step = 10.0 ** math.floor(math.log10(max(float(np.ptp(ends)), LEAST_SPAN) / STEPS * 2))
    low, high = math.floor(ends.min() / step) * step, math.ceil(ends.max() / step) * step
    threshold = st.slider(
        "Threshold",
        low,
        max(high, low + step),
        min(max(before.threshold, low), high),
        step,
        format=f"%.{max(0, -round(math.log10(step)), _decimals(before.threshold))}f",
        key=f"detector_threshold_{asking.key_of(spec, *asking.place())}",
        help="Lowest score of a box that counts. A run takes it as the threshold of the new "
        "system; the boxes below it are written, too, down to the detector's own, for the curves.",
    )
    facts = run_settings(what.about)["overlap"]
    assert facts.high is not None
    overlap = st.slider(
        "Overlap",
        0.0,  # a network's lower one says that its own default is wanted
        float(facts.high),
        before.overlap,
        0.05,
        key=f"detector_overlap_{asking.key_of(spec.text)}",
        help=plain(facts.meaning),
    )
    levels = Levels(threshold, overlap)
    store.DETECTOR_LEVELS.get()[spec.text] = levels
    return levels


def _decimals(value: float) -> int:
    """Decimals that say a value, `MOST_DECIMALS` at most."""
    return len(f"{value:.{MOST_DECIMALS}f}".rstrip("0").partition(".")[2])


def _draw_numbers(boxes: Detections, is_counting: np.ndarray, levels: Levels) -> None:
    n_above = int((boxes.score >= levels.threshold).sum())
    before, after = st.columns(2)
    before.metric("Before suppression", f"{n_above:,}")
    after.metric("After", f"{int(is_counting.sum()):,}")
    if len(boxes) >= MOST:
        st.caption(f"Of all windows the {MOST:,} most confident are kept.")
    if n_above:
        return
    if len(boxes):
        best = minus(f"{boxes.score[0]:.3g}")
        st.caption(
            f"No box reaches the threshold: the most confident has {best}. Objects "
            "may be smaller than what it looks for; see its settings."
        )
    else:
        st.caption("No window came through: there is no box at any threshold.")


def _draw_outcome(outcome: Outcome) -> None:
    """What the boxes that count would be in a comparison."""
    params = state.params()
    matched, false, missed = st.columns(3)
    matched.metric("Matched", f"{outcome.n_of(DetectionState.MATCHED):,}")
    false.metric("False", f"{outcome.n_of(DetectionState.FALSE_ALARM):,}")
    missed.metric("Missed", f"{outcome.n_missed:,}")
    is_by_overlap = params.match == "iou"
    rule = f"an IoU of at least {params.iou:.4g}" if is_by_overlap else "sideways position"
    st.caption(f"Matched with the truth as in the comparison: by {rule}.")


def _draw_chosen(
    boxes: Detections, is_counting: np.ndarray, outcome: Outcome, chosen: int | None
) -> None:
    """What is known of the box that was clicked."""
    if chosen is None:
        if is_counting.any():
            st.caption("Click the mark in the middle of a box to choose it.")
        return
    text = box_text(
        boxes,
        chosen,
        iou=float(outcome.iou[chosen]),
        is_counting=bool(is_counting[chosen]),
        states=outcome.states,
    )
    st.markdown(f"**Chosen box:** {as_text(text)}.")


def _clicked_box(spec: DetectorSpec, boxes: Detections, levels: Levels) -> int | None:
    """Row of the box of this frame that was clicked, unless it is below the threshold by now."""
    where, row = store.DETECTOR_BOX.get()
    is_here = where == (spec, asking.place()) and row < len(boxes)
    return int(row) if is_here and boxes.score[row] >= levels.threshold else None


def _draw_boxes(
    what: DetectorFacts,
    picture: Picture,
    boxes: Detections,
    is_counting: np.ndarray,
    levels: Levels,
    outcome: Outcome,
    chosen: int | None,
) -> Any:
    dataset, recording = state.opened().dataset, state.recording()
    frames = dataset.frame_columns
    figure = boxes_plot(
        picture,
        boxes,
        is_counting,
        theme=asking.theme_of(what.about),
        threshold=levels.threshold,
        title=asking.on_frame(what.about),
        truth=outcome.truth,
        ignored=outcome.ignored,
        states=outcome.states,
        size=(float(frames.width[recording]), float(frames.height[recording])),
        chosen=chosen,
    )
    alt = f"Boxes of {what.about.name}: {count_text(int(is_counting.sum()), 'box', 'boxes')} count"
    clicked = clicked_chart(figure, "detector_boxes", alt=alt)
    st.caption("Drag over a part of the picture to enlarge it; a double click shows all of it.")
    return clicked
