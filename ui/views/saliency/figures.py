"""Saliency page: composition of saliency, events on the recency curve, X against Y."""

from __future__ import annotations

import streamlit as st

from nvcore.comparison.compare import Result
from nvcore.comparison.measures.table import has_several_recordings
from nvcore.figures.dots import recordings_plot
from nvcore.figures.saliency import parts_plot, plane_plot, recency_plot
from nvcore.report.words import saliencies, saliency_caveat
from nvcore.settings.params import Params
from nvcore.tables.result import recordings_table, worst_events
from ui.session import state, store
from ui.shell.navigate import open_row
from ui.widgets.buttons import button
from ui.widgets.charts import Clicked, draw_chart
from ui.widgets.text import docs_link, plain


def what_it_is(params: Params) -> str:
    """Explain the meaning of saliency with these settings."""
    is_each, in_seconds = params.saliency_of == "each", params.recency_unit == "seconds"
    is_risk = params.saliency_weight == "risk"
    return state.say(
        "How long {many} are missed ({link}, seconds, 0 is best). Late misses count most, as they "
        "are remembered best. A *saliency event* is a run of frames in which one {one} "
        "{what_of}. It counts by its {weight} times its *recency*, a weight of 0 to 1 that follows "
        "from {passed} of the {scope} when it ends. {Many} far away can have events, too. {caveat}",
        link=docs_link("saliency", "saliency"),
        what_of="is missed by more than the tolerance" if is_each else "is the most salient miss",
        weight="weighted distance, summed over time," if is_risk else "*duration*",
        passed="the seconds left" if in_seconds else "the share that has passed",
        scope="encounter" if params.saliency_scope == "encounter" else "recording",
        caveat=" ".join(map(state.say, saliency_caveat(params))),
    )


def draw_numbers(result: Result) -> None:
    """Draw the saliency of X and Y over all recordings, each with an explanation."""
    kind = "largest event" if result.params.saliency_aggregate == "max" else "sum of all events"
    if has_several_recordings(result):
        kind = f"{kind}, mean over recordings"
    if result.is_short:
        kind += " (means little here: see above)"
    for column, (letter, system), how in zip(
        st.columns(2, gap="medium"), result.sides, saliencies(result), strict=True
    ):
        column.metric(
            f"Late misses of {letter.upper()} (saliency, {kind})", f"{system.saliency_s:.2f} s"
        )
        column.markdown(state.say(how))
        if not system.events.empty:
            with column:
                _draw_way(result, letter)


def _draw_way(result: Result, letter: str) -> None:
    """Draw a description of a system's most salient event, and a button that opens it."""
    worst = worst_events(result, letter, n=1).iloc[0]
    when = "late" if worst["recency"] >= 0.5 else "early"
    st.caption(
        f"The most salient: {result.objects.singular} {worst['track']} in "
        f"{plain(worst['recording'])}, missed {worst['duration_s']:.1f} s, {when} in the "
        f"{result.params.saliency_scope} (saliency {worst['saliency_s']:.2f} s)."
    )
    if button("Show in timeline", key=f"saliency_show_{letter}", icon=":material/movie:"):
        open_row(int(worst["first_row"]))


def draw_events(result: Result, recording: int | None) -> None:
    """Plot the events on the recency curve, and the composition of the largest ones.

    The events are those of one recording, or of all if `recording` is None.
    """
    theme = state.theme()
    left, right = st.columns(2, gap="medium")
    with left:
        draw_chart(
            recency_plot(result, theme=theme, recording=recording),
            "saliency_curve",
            on_click=_ask_for_row,
            help="X is drawn just above the curve, Y just below it.",
        )
    with right:
        parts = parts_plot(result, theme=theme, recording=recording)
        draw_chart(parts, "saliency_parts", on_click=_ask_for_row)


def draw_recordings(result: Result) -> None:
    """Plot X against Y by recording: saliency, and saliency with similarity."""
    names, theme = result.names, state.theme()
    left, right = st.columns(2, gap="medium")
    with left:
        draw_chart(
            recordings_plot(recordings_table(result), names, theme=theme, measure="saliency"),
            "saliency_recordings",
            on_click=_choose_recording,
            help="Click a recording to see only its events below.",
        )
    with right:
        means = "Large open marks: means. " if has_several_recordings(result) else ""
        draw_chart(
            plane_plot(result, theme=theme),
            "saliency_plane",
            on_click=_ask_for_row,
            help=f"{means}Click the mark of a recording to see the system's most salient event in "
            "it in the Timeline.",
        )


def _ask_for_row(clicked: Clicked) -> None:
    store.SALIENCY_ROW.set(int(clicked.value))


def _choose_recording(clicked: Clicked) -> None:
    store.SALIENCY_RECORDING.set(int(clicked.value))
