"""Detectors page: the detector on the current frame, with threshold and overlap."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Final

import numpy as np
import streamlit as st

from nvcore.common.wording import count_text, minus
from nvcore.dataset.schema import DetectionState
from nvcore.figures.style import plain
from nvcore.pictures import Picture
from nvcore.settings.params import Params
from nvcore.subjects.detectors.base import Detections
from nvcore.subjects.detectors.candidates import MOST, counting, usual_threshold
from nvcore.subjects.detectors.figures import box_text, boxes_plot
from nvcore.subjects.detectors.registry import run_settings
from ui.session import state, store
from ui.subjects.detectors import asking
from ui.subjects.detectors.confined import DetectorFacts, DetectorSpec
from ui.subjects.detectors.outcome import Outcome, outcome_of
from ui.widgets.charts import clicked_chart
from ui.widgets.text import plain as as_text

LEAST_SPAN: Final = 0.1
"""Smallest range of the threshold's slider."""
STEPS: Final = 200
"""Steps of that slider."""
MOST_DECIMALS: Final = 4
"""Decimals of a threshold beside the slider's steps: a detector's own need not lie on one."""


@dataclass(frozen=True)
class Levels:
    """Lowest score that counts, and overlap from which on the less confident box is suppressed."""

    threshold: float
    overlap: float


def levels_of(spec: DetectorSpec, what: DetectorFacts) -> Levels:
    """Return threshold and overlap as they are set, at first the detector's own."""
    overlap = what.about.settings["overlap"]
    assert isinstance(overlap, int | float)
    usual = Levels(usual_threshold(what.about), float(overlap))
    return store.DETECTOR_LEVELS.get().get(spec.text, usual)


def chosen_box(spec: DetectorSpec, boxes: Detections) -> int | None:
    """Return the row of the clicked box, else of the most confident one, if any."""
    clicked = _clicked_box(spec, boxes)
    return clicked if clicked is not None or not len(boxes) else 0


def _clicked_box(spec: DetectorSpec, boxes: Detections) -> int | None:
    where, row = store.DETECTOR_BOX.get()
    return int(row) if where == (spec, asking.place()) and row < len(boxes) else None


@st.fragment
def draw(
    spec: DetectorSpec, what: DetectorFacts, picture: Picture, *, has_run: bool = False
) -> None:
    """Draw the picture with the boxes beside the controls. A click chooses a box.

    Parameters
    ----------
    has_run
        Whether there is a run below, which names its differences from the controls.
    """
    boxes, before = asking.found(spec, picture), levels_of(spec, what)
    left, right = st.columns([3, 1], gap="medium")
    with right:
        levels = _draw_levels(spec, what, boxes)
    if has_run and levels != before:
        st.rerun()  # of the whole page: this part alone is drawn while a slider moves
    is_counting = counting(boxes, what.about, threshold=levels.threshold, overlap=levels.overlap)
    dataset, recording, params = state.opened().dataset, state.recording(), state.params()
    outcome = outcome_of(
        *(dataset, state.row_in_all(), picture, boxes, is_counting, params),
        classes=what.about.labels,
    )
    chosen = _clicked_box(spec, boxes)
    if chosen is not None and boxes.score[chosen] < levels.threshold:
        chosen = None
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
    n_counting = int(is_counting.sum())
    with right:
        _draw_numbers(boxes, n_counting, levels)
        _draw_outcome(outcome, params)
        if chosen is not None:
            text = box_text(
                boxes,
                chosen,
                iou=float(outcome.iou[chosen]),
                is_counting=bool(is_counting[chosen]),
                states=outcome.states,
            )
            st.markdown(f"**Chosen box:** {as_text(text)}.")
        elif n_counting:
            st.caption("Click the mark in the middle of a box to choose it.")
    with left:
        alt = f"Boxes of {what.about.name}: {count_text(n_counting, 'box', 'boxes')} count"
        clicked = clicked_chart(figure, "detector_boxes", alt=alt)
        st.caption("Drag over a part of the picture to enlarge it; a double click shows all of it.")
    if clicked is not None:
        row = clicked[0] if isinstance(clicked, list) else clicked
        store.DETECTOR_BOX.set(((spec, asking.place()), int(row)))
        st.rerun()


def _draw_levels(spec: DetectorSpec, what: DetectorFacts, boxes: Detections) -> Levels:
    """Draw the two sliders, at the values of this detector."""
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
    store.DETECTOR_LEVELS.set({**store.DETECTOR_LEVELS.get(), spec.text: levels})
    return levels


def _decimals(value: float) -> int:
    """Return how many decimals a value needs, at most `MOST_DECIMALS`."""
    return len(f"{value:.{MOST_DECIMALS}f}".rstrip("0").partition(".")[2])


def _draw_numbers(boxes: Detections, n_counting: int, levels: Levels) -> None:
    n_above = int((boxes.score >= levels.threshold).sum())
    _draw_metrics({"Before suppression": n_above, "After": n_counting})
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


def _draw_outcome(outcome: Outcome, params: Params) -> None:
    matched, false = map(outcome.n_of, (DetectionState.MATCHED, DetectionState.FALSE_ALARM))
    _draw_metrics({"Matched": matched, "False": false, "Missed": outcome.n_missed})
    is_by_overlap = params.match == "iou"
    rule = f"an IoU of at least {params.iou:.4g}" if is_by_overlap else "sideways position"
    st.caption(f"Matched with the truth as in the comparison: by {rule}.")


def _draw_metrics(numbers: dict[str, int]) -> None:
    for place, (label, number) in zip(st.columns(len(numbers)), numbers.items(), strict=True):
        place.metric(label, f"{number:,}")
