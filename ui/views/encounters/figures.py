"""Encounters page: miss classes, encounters that both systems miss, and the gain of a fusion."""

from __future__ import annotations

from collections.abc import Hashable
from functools import partial
from typing import Final

import pandas as pd
import streamlit as st

from nvcore.comparison.compare import Result
from nvcore.figures.encounters import LABELS, fusion_plot, lead_time_plot, miss_classes_plot
from nvcore.notes import Note
from nvcore.report.words import fusion_gains, misses
from nvcore.tables.encounters.miss_classes import ALL_CLASSES, fusion_table, miss_class_totals
from ui.session import state
from ui.views.encounters.filters import set_classes
from ui.widgets.charts import Clicked, draw_chart
from ui.widgets.table import TableColumn, draw_table
from ui.widgets.table_columns import class_words
from ui.widgets.text import UNDEFINED, docs_link, plain, short_names

MANY_BOXES: Final = 300_000
"""Number of boxes from which a fusion is computed only on request."""


def draw_classes(result: Result, encounters: pd.DataFrame) -> None:
    """Draw miss classes and lead times of the encounters that pass the filters."""
    names, theme = result.names, state.theme()
    left, right = st.columns(2, gap="medium")
    with left:
        draw_chart(
            miss_classes_plot(encounters, names, theme=theme, objects=result.objects),
            "encounters_classes",
            on_click=_choose_class,
            help="Click a bar to list its encounters.",
        )
    with right:
        draw_chart(
            lead_time_plot(encounters, theme=theme, objects=result.objects),
            "encounters_lead",
            help=state.say(
                "{link}: how much earlier X matches {a_one} than Y, counted from the moment the "
                "{one} is near enough to count.",
                link=docs_link("Lead time", "lead-time"),
            ),
        )


def _choose_class(clicked: Clicked) -> None:
    kind = clicked.value
    set_classes(*((kind, None) if clicked.curve == 0 else (None, kind)))


def draw_exclusivity(result: Result) -> None:
    """Draw whether X and Y miss the same pedestrians, in words and as a table of miss classes."""
    x, y = map(plain, short_names(result).values())
    st.markdown(
        "\n".join(f"- {plain(state.say(fact))}" for fact in misses(result)),
        help=f"{docs_link('Jaccard index', 'exclusivity')}: share of all misses that both have, "
        "0 to 1. Phi: how much the misses of X and Y go together, −1 to 1, 0 if not at all. "
        "McNemar's p: how often chance alone gives so uneven a split. The filters have no effect "
        "here.",
    )
    st.markdown(
        f"**Miss class of {x} (X, rows) against that of {y} (Y, columns)**",
        help="Click a count to list these encounters.",
    )
    counts = miss_class_totals(result)
    kinds = [*counts.index]
    draw_table(
        counts.set_axis([f"X {_class_name(kind)}" for kind in kinds]).reset_index(names="x"),
        {"x": TableColumn("Miss class", is_head=True)}
        | {str(kind): TableColumn(f"Y {_class_name(kind)}") for kind in counts},
        key="encounters_pairs",
        name="Miss classes",
        on_click=partial(_choose_pair, kinds),
        clicks="cell",
        is_sortable=False,
    )


def _class_name(kind: Hashable) -> str:
    return ALL_CLASSES if kind == ALL_CLASSES else class_words(kind) or UNDEFINED


def _choose_pair(kinds: list[str], row: int, column: str) -> None:
    y = column if column in kinds else ALL_CLASSES
    set_classes(*(None if kind == ALL_CLASSES else kind for kind in (kinds[row], y)))


def draw_fusion(result: Result) -> None:
    """Draw what fusing X and Y (``X or Y``, ``X and Y``) would gain and cost."""
    if len(result.dataset.boxes) >= MANY_BOXES and not st.toggle(
        "Work it out",
        key="encounters_fuse",
        persist_state="session",
        help="With so many boxes this takes a few seconds after every change of a parameter.",
    ):
        return
    with st.spinner("Fusing the systems"):
        fusion = fusion_table(result)
    left, right = st.columns(2, gap="medium")
    with left:
        draw_chart(
            fusion_plot(fusion, theme=state.theme()),
            "encounters_fusion",
            help=f"{docs_link('Fusion', 'fusion')}: \u201cX or Y\u201d shows what either detects, "
            "\u201cX and Y\u201d what both detect. A false-alert episode is a run of false alarms "
            "that a driver would notice as one. The filters have no effect here. "
            f"{plain(state.say(Note('encounters.fusion_rule')))}",
        )
    with right:
        gains = (state.say(gain) for gain in fusion_gains(fusion))
        st.markdown("\n".join(f"- {sentence}" for sentence in gains))
        draw_table(
            fusion.assign(system=fusion["system"].map(LABELS)),
            {
                "system": TableColumn("System", is_head=True),
                "encounters_detected": TableColumn("Encounters"),
                "false_alert_episodes": TableColumn("False-alert episodes"),
                "mean_similarity": TableColumn("Mean similarity", form=".3f"),
            },
            key="encounters_fusion_table",
            name="What a fusion brings",
            is_sortable=False,
        )
