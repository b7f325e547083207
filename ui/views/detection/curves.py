"""Detection page: curves with operating points, and a table of measures."""

from __future__ import annotations

from typing import Final, Literal

import numpy as np
import streamlit as st

from nvcore.common.errors import ParameterError
from nvcore.common.wording import capitalised, count_text, minus
from nvcore.comparison.compare import Result
from nvcore.figures.curves import CurveKind, curve_plot
from nvcore.metrics.detection.curve_summary import CurveSummary, summarise_curve
from nvcore.metrics.detection.curves import DetectionCurve, detection_curve
from nvcore.metrics.detection.miss_rate import explain_few
from nvcore.metrics.detection.windows import WindowGrid, scale_steps, windows_per_image
from nvcore.settings.protocols import Protocol
from nvcore.settings.stages import MATCH
from nvcore.tables.scorecard import curve_rows
from ui.session import state
from ui.session.results import miss_rate_evidence
from ui.views.detection.protocol import filtered
from ui.widgets.charts import clicked_chart
from ui.widgets.choices import choose_side_by_side
from ui.widgets.html import measures_html, score_row
from ui.widgets.text import docs_link, plain

KIND_WORDS: Final[dict[CurveKind, str]] = {
    "miss_rate": "Miss rate",
    "precision_recall": "Precision and recall",
    "roc": "ROC per image",
    "roc_windows": "ROC per window",
    "f1": "F1",
}
EXPLAINED: Final[dict[CurveKind, str]] = {
    "miss_rate": "Lower is better. The log-average miss rate (LAMR) is the geometric mean of the "
    "miss rates at nine references from 0.01 to 1 false positives per image.",
    "precision_recall": "Higher is better. Recall: share of the {many} detected. Precision: "
    "share of the detections that are right.",
    "roc": "Higher is better: the share of {many} detected against false positives per image.",
    "roc_windows": "As per image, but over the windows that a sliding-window detector looks at.",
    "f1": "Higher is better: the harmonic mean of precision and recall at every threshold.",
}
COUNTS: Final[dict[Literal["whole", "area"], str]] = {
    "whole": "whole windows, exactly",
    "area": "by the area formula",
}
MOST_SCALES: Final = 200


def draw(result: Result, protocol: Protocol) -> None:
    """Draw the curves of X and Y under a protocol, and their measures."""
    curves = [_curve(result, system.name, protocol) for _, system in result.sides]
    thresholds = [system.threshold for _, system in result.sides]
    summaries = [*map(summarise_curve, curves, thresholds)]
    kind = choose_side_by_side(
        "Curve", KIND_WORDS, "curve_kind", default="miss_rate", label_visibility="collapsed"
    )
    windows = _windows(result, protocol) if kind == "roc_windows" else None
    figure = curve_plot(
        curves,
        thresholds,
        kind,
        theme=state.theme(),
        windows_per_image=windows,
        summaries=summaries,
        published=result.dataset.settings.published,
        objects=result.objects,
    )
    clicked = clicked_chart(
        figure,
        f"curves_{kind}",
        help=f"{state.say(EXPLAINED[kind])} Click a curve to count from that score on.",
    )
    if kind == "miss_rate":
        _draw_notes(summaries)
    if clicked is not None:
        letter, threshold = clicked
        if threshold is not None:  # a point without scores
            state.set_threshold(letter, float(threshold))
            st.rerun()
    _draw_table(summaries)
    if kind != "miss_rate":
        _draw_notes(summaries)
    remarks = [
        explain_few(curves[0].n_truth, result.objects),
        *(note for summary in summaries for note in summary.notes),
    ]
    _draw_evidence(result, [remark for remark in remarks if remark])


def _draw_notes(summaries: list[CurveSummary]) -> None:
    """Draw notes on the log-average miss rates."""
    for letter, summary in zip("XY", summaries, strict=True):
        if summary.notes:
            notes = "; ".join(summary.notes)
            st.caption(plain(f"Log-average miss rate of {letter}: {notes}."))


def _draw_evidence(result: Result, remarks: list[str]) -> None:
    """Draw the evidence that the difference in the log-average miss rate is more than chance.

    Parameters
    ----------
    remarks
        Remarks that the page shows already, which are not repeated here.
    """
    evidence = miss_rate_evidence(result)
    if np.isnan(evidence.difference):  # the table above states the reason
        return
    words = "Difference of the log-average miss rates, X minus Y:"
    parts = [f"{words} {minus(f'{100 * evidence.difference:+.2f}')} pp"]
    if np.isfinite(evidence.low):
        ends = minus(f"{100 * evidence.low:+.2f} to {100 * evidence.high:+.2f}")
        parts.append(f"95 % interval {ends} pp")
    elif np.isfinite(evidence.p):
        parts.append("no interval (see below)")
    if np.isfinite(evidence.p):
        parts.append(f"p = {evidence.p:.2g}, not corrected for other measures")
    text = f"{', '.join(parts)} ({count_text(evidence.n, evidence.unit.removesuffix('s'))})."
    st.markdown(plain(text))
    notes = [
        note for note in evidence.note.split("; ") if note and not note.endswith(tuple(remarks))
    ]
    for note in notes:
        st.caption(plain(f"{capitalised(note)}."))
    link = docs_link("Significance", "significance", doc="significance")
    st.caption(f"{plain(evidence.method)} ({link})." if evidence.method else f"See {link}.")


def _curve(result: Result, system: str, protocol: Protocol) -> DetectionCurve:
    rule = result.params.only_for(MATCH)
    return state.cached(
        "curves",
        (system, protocol, rule),
        lambda: detection_curve(result.dataset, system, rule, protocol),
        most=8,
    )


def _windows(result: Result, protocol: Protocol) -> float | None:
    """Return windows per image, as given or computed from window size, stride and scales."""
    known, width, height, stride, scales, way = st.columns([1.3, 1, 1, 1, 1.6, 1.4])
    n_windows: int | None = known.number_input(
        "Windows per image",
        1,
        None,
        None,
        key="windows_given",
        persist_state="session",
        placeholder="count them",
        help="As your detector reports it; empty: counted.",
    )
    width_px, height_px, stride_px = (
        float(
            place.number_input(
                label, 1, 2000, value, key=f"window_{label}", persist_state="session"
            )
        )
        for place, label, value in (
            (width, "Width (px)", 32),
            (height, "Height (px)", 64),
            (stride, "Stride (px)", 4),
        )
    )
    steps = scales.text_input(
        "Scales: first, last, step",
        "1, 2, 0.1",
        key="window_scales",
        persist_state="session",
        help="By which the picture is shrunk.",
    )
    count = way.selectbox(
        "Counted",
        list(COUNTS),
        format_func=COUNTS.__getitem__,
        key="window_count",
        persist_state="session",
    )
    if n_windows:
        return float(n_windows)
    try:
        first, last, step = (float(part) for part in steps.split(","))
        if step > 0 and (last - first) / step > MOST_SCALES:
            st.warning(f"These are more than {MOST_SCALES} scales: choose a larger step.")
            return None
        grid = WindowGrid(
            width_px, height_px, stride_px, scales=scale_steps(first, last, step), count=count
        )
    except ValueError:
        st.warning("Scales are three numbers, such as 1, 2, 0.1: first, last and step.")
        return None
    except ParameterError as error:
        st.warning(plain(f"Scales: {error}."))
        return None
    counted = windows_per_image(result.dataset, filtered(result.dataset, protocol).is_counted, grid)
    if counted > 0:
        st.caption(f"{counted:,.0f} windows per image.")
        return counted
    pictures = result.dataset.recordings[["width", "height"]].max()
    st.warning(
        f"No window of {grid.width:g} x {grid.height:g} px has a place to slide in: the largest "
        f"picture is {pictures['width']:g} x {pictures['height']:g} px."
    )
    return None


def _draw_table(summaries: list[CurveSummary]) -> None:
    st.header("In numbers")
    st.html(measures_html([score_row(row) for row in curve_rows(*summaries)], key="curve_figures"))
    for letter, summary in zip("XY", summaries, strict=True):
        if summary.why_undefined is not None:
            why = plain(summary.why_undefined)
            st.caption(f"{letter} has no averages and no areas ({why}).")
    st.caption(
        state.say(
            "Absorbed: neither right nor wrong, as they lie on {many} or regions that are ignored."
        )
    )
    st.caption(
        "↑ higher is better, ↓ lower is better "
        f"({docs_link('how each is computed', 'areas', doc='detection')})."
    )
