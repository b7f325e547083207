"""Overview page: the verdict, the scorecard, and the recordings side by side."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

import pandas as pd
import streamlit as st

from nvcore.comparison import Result
from nvcore.evidence.claims import Basis
from nvcore.evidence.companions import Companions, as_set_note
from nvcore.figures.paired import recordings_plot
from nvcore.findings import Finding
from nvcore.measures import MeasureTable
from nvcore.report.equal_alarms import (
    detected_text,
    equal_alarms_of,
    equal_alarms_title,
    weights_text,
)
from nvcore.report.verdict import verdict
from nvcore.report.words import sampling_note
from nvcore.tables.result import recordings_table
from nvcore.tables.scorecard import score_rows
from nvcore.wording import count_text
from ui.session import state
from ui.shell.navigate import open_frame, open_page
from ui.widgets.charts import clicked_chart
from ui.widgets.choices import choose_side_by_side, draw_measures
from ui.widgets.table_columns import measures_as_text
from ui.widgets.text import docs_link, plain

BASES: Final = {Basis.AS_SET: "As set", Basis.EQUAL_ALARMS: "At equal false alarms"}
WIDTHS: Final = {"measure": 250, "X": 70, "Y": 70, "X - Y": 70}


def verdict_box(
    result: Result,
    findings: Sequence[Finding],
    evidence: pd.DataFrame,
    companions: Companions | None,
    plan: str,
) -> None:
    """What the measures support, how much more it would take, and what it depends on."""
    conclusion = verdict(result, findings, evidence=evidence, companions=companions, plan=plan)
    points = (f"- **{plain(point.topic)}:** {plain(point.text)}" for point in conclusion.points)
    with st.container(border=True, key="verdict"):
        st.markdown(f"## {plain(conclusion.headline)}")
        st.markdown("\n".join(points))
        if conclusion.caveat:
            st.warning(plain(conclusion.caveat), icon=":material/warning:")
            if st.button("See the findings on the Data page"):
                open_page("data")
    st.caption(_extent(result))
    if note := sampling_note(result.dataset.frame_columns):
        st.caption(note)


def _extent(result: Result) -> str:
    venn = result.venn
    return (
        f"{count_text(len(result.dataset.recordings), 'recording')}, "
        f"{count_text(len(result.dataset.frames), 'frame')}, "
        f"{result.duration_s:,.1f} s. An encounter is one pedestrian from first to last annotated "
        f"frame; {venn.n_near:,} came near enough to count, {venn.distant:,} stayed distant. A "
        f"system detects it by matching it in at least {result.params.coverage:.0%} of the frames "
        "in which it is near. p, where given: how often recordings in which X and Y could be "
        "exchanged would differ as much, by itself and corrected for all measures "
        f"({docs_link('Significance', 'other-measures', doc='significance')})."
    )


def scorecard(result: Result, companions: Companions | None) -> None:
    """Every measure of X beside that of Y, the difference, and which way is better.

    At unequal operating points as set, and where the verdict is about another comparison, of that.

    Parameters
    ----------
    companions
        Of the comparison; None: not known yet, or not needed.
    """
    st.header("Scorecard")
    equal = equal_alarms_of(result, companions)
    if equal is None:
        draw_as_set_note(result)
        _draw_scorecard(result)
        return
    assert companions is not None
    basis = choose_side_by_side(
        "What is compared",
        BASES,
        "scorecard_basis",
        default=Basis.EQUAL_ALARMS,
        label_visibility="collapsed",
    )
    if basis is Basis.AS_SET:
        draw_as_set_note(result)
        _draw_scorecard(result)
        return
    text, button = st.columns([3, 2], vertical_alignment="center")
    text.markdown(plain(f"{equal_alarms_title(companions)}, as in the verdict."))
    moved = companions.moved
    button.button(
        "Set this threshold",
        key="set_equal_alarms",
        on_click=state.set_threshold,
        args=(moved, equal.system(moved).threshold),
        width="stretch",
        help="The whole page, and every other, is then at equal false alarms.",
    )
    _draw_scorecard(equal)
    st.caption(
        plain(
            f"Encounters detected by: {detected_text(equal)}. Severity, of encounters detected by "
            f"{weights_text(equal)}."
        )
    )


def draw_as_set_note(result: Result) -> None:
    """Above numbers of X and Y as set: that nothing is claimed from these, if that is so."""
    if note := as_set_note(result):
        st.markdown(f":material/balance: {plain(note)}")


def _draw_scorecard(result: Result) -> None:
    draw_measures(measures_as_text(score_rows(result)), "scorecard", WIDTHS)
    st.caption(
        "↑ higher is better, ↓ lower is better. Similarity, per frame, 1 is best: how well "
        "detections fit the pedestrians, near ones first. Saliency, in seconds, 0 is best: "
        "how long the most salient misses last, in full only when they are late "
        f"({docs_link('Metrics', 'similarity')}). {_rule(result)}"
    )
    with st.expander(f"How the {result.venn.n_near:,} encounters went"):
        table = measures_as_text(score_rows(result, MeasureTable.MISS_CLASSES))
        draw_measures(table, "classes", WIDTHS, first="miss class")


def _rule(result: Result) -> str:
    """When a detection matches, and what it is when it does not."""
    params = result.params
    how = (
        f"whom it overlaps by an IoU of {params.iou:g} or more"
        if params.match == "iou"
        else f"at whose sideways position it stands, to {params.lateral_tolerance:.0%} of the width"
    )
    return (
        f"A detection matches a pedestrian {how}; a looser box is a false alarm, and the "
        "pedestrian is missed (Advanced)."
    )


def by_recording(result: Result) -> None:
    """Mean similarity of each recording as paired points; a click opens it."""
    st.header("By recording")
    draw_as_set_note(result)
    names = (result.x.name, result.y.name)
    recording = clicked_chart(
        recordings_plot(recordings_table(result), names, theme=state.theme()), "by_recording"
    )
    if recording is not None:
        open_frame(int(recording), 0)
