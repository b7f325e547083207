"""Overview page: the scorecard, and a comparison by recording."""

from __future__ import annotations

import math
from collections.abc import Sequence

import pandas as pd
import streamlit as st

from nvcore.common.wording import percent
from nvcore.comparison.compare import Result
from nvcore.comparison.measures.entry import MeasureTable
from nvcore.comparison.measures.table import count_recordings
from nvcore.figures.dots import recordings_plot
from nvcore.notes import Note
from nvcore.tables.result import recordings_table
from nvcore.tables.scorecard import LEADING, ScoreRow, pick_rows, score_rows
from ui.session import state
from ui.shell.navigate import open_frame
from ui.widgets.charts import clicked_chart, kept_figure
from ui.widgets.html import measures_html, score_row
from ui.widgets.text import docs_link, plain


class Scorecard:
    """Scorecard that is drawn at once and redrawn when the intervals are known.

    Until it is drawn, its place shows the content of the last run. A run that ends early leaves
    the page as it is.
    """

    def __init__(self, result: Result) -> None:
        self._result = result
        st.header("Scorecard", help=_help(result))
        self._place = st.container()
        self._rows = score_rows(result)
        every = st.expander(
            f"All {len(self._rows)} measures", key="all_measures", on_change="rerun"
        )
        self._whole = every.container() if every.open else None
        if every.open:
            with every:
                _draw_classes(result)

    def draw(self, evidence: pd.DataFrame | None) -> None:
        """Draw the table. With evidence, omit decimals that the intervals do not support."""
        leading = pick_rows(self._result, self._rows, LEADING)
        self._place = self._place.html(self._table(evidence, leading, "scorecard"))
        if self._whole is not None:
            self._whole = self._whole.html(self._table(evidence, self._rows, "all_measures"))

    def _table(self, evidence: pd.DataFrame | None, of: Sequence[ScoreRow], key: str) -> str:
        widths = {} if evidence is None else _widths(evidence)
        rows = [
            score_row(row, width=widths.get(row.key, math.nan), is_short=self._result.is_short)
            for row in of
        ]
        little = _little(self._result)
        return measures_html(
            rows, key=key, note=f"● better in these recordings, by chance or not.{little}"
        )


def _widths(evidence: pd.DataFrame) -> dict[str, float]:
    """Return the width of each measure's 95 % interval of the difference, by key."""
    widths = evidence["high"] - evidence["low"]
    return dict(zip(evidence["figure"], widths, strict=True))


def _little(result: Result) -> str:
    return f" {state.say(Note('sections.means_little'))}." if result.is_short else ""


def _help(result: Result) -> str:
    little = _little(result)
    return state.say(
        "↑ higher is better, ↓ lower is better; the better value has a dot, which says nothing "
        "of chance.{little} Similarity, per frame, 1 is best: how well detections fit the "
        "{many}, near ones first. Saliency, in seconds, 0 is best: how long the most salient "
        "misses last, in full only when they are late ({link}). {rule}",
        little=plain(little),
        link=docs_link("Metrics", "similarity"),
        rule=_rule(result),
    )


def _draw_classes(result: Result) -> None:
    """Draw the number of near encounters by miss class."""
    st.markdown(f"How the {result.venn.n_near:,} encounters went")
    rows = [
        score_row(row, is_short=result.is_short)
        for row in score_rows(result, MeasureTable.MISS_CLASSES)
    ]
    st.html(measures_html(rows, key="classes", first="Miss class"))


def _rule(result: Result) -> str:
    """Explain when a detection matches, and how it counts if it does not."""
    params = result.params
    how = (
        state.say("{whom} it overlaps by an IoU of {iou:g} or more", iou=params.iou)
        if params.match == "iou"
        else "at whose sideways position it stands, to "
        f"{percent(params.lateral_tolerance)} of the width"
    )
    if params.match_class == "same":
        how += ", and whose class it names"
    return state.say(
        "A detection matches {a_one} {how}; a looser box is a false alarm, and the {one} is missed "
        "(Advanced).",
        how=how,
    )


def by_recording(result: Result) -> None:
    """Plot each recording's mean similarity for X and Y. A click opens the recording."""
    names = result.names
    if count_recordings(result) == 1:
        x, y = (f"{system.summary.mean:.3f}" for _, system in result.sides)
        st.markdown(f"There is one recording: mean similarity X {x}, Y {y} (1 is best).")
        return
    theme = state.theme()
    figure = kept_figure(
        "by_recording",
        (result.params, *names, theme),
        lambda: recordings_plot(recordings_table(result), names, theme=theme),
    )
    recording = clicked_chart(figure, "by_recording")
    if recording is not None:
        open_frame(int(recording), 0)
