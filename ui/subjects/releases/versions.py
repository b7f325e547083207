"""What changed page: the versions that are compared, tests between them, measures of all."""

from __future__ import annotations

import pandas as pd
import streamlit as st

from nvcore.comparison.compare import Result
from nvcore.report.gate import parse_rules
from nvcore.subjects.releases.figures import version_plot
from nvcore.subjects.releases.section import tests_table
from nvcore.subjects.releases.versions import measures_of_versions, version_lines
from ui.session import state, store
from ui.session.results import comparison_key, measure_evidence
from ui.streamlit_inside.types import DeltaGenerator
from ui.widgets.charts import draw_chart
from ui.widgets.section import draw_table_of
from ui.widgets.text import docs_link, plain

OLD, NEW = store.widget("releases_old"), store.widget("releases_new")
IN_A_ROW = 3


def draw_choice(result: Result) -> None:
    """Draw the choice of both versions, and a button for the latest ones of each product."""
    with st.container(horizontal=True, vertical_alignment="bottom", key="releases_choice"):
        for label, entry, name in zip(("Old", "New"), (OLD, NEW), result.names, strict=True):
            entry.set(name)
            st.selectbox(label, result.dataset.systems, key=entry.key, on_change=_choose, width=200)
        for number, (*_, old, new) in enumerate(version_lines(result.dataset)):
            if (old, new) != result.names:
                key, label = f"releases_pair_{number}", plain(f"{old} → {new}")
                st.button(label, key=key, on_click=state.compare_systems, args=(old, new))


def _choose() -> None:
    """Compare the chosen versions. Choosing the other one's name swaps them."""
    old, new, before = OLD.get(), NEW.get(), state.systems()
    if old == new:
        new, old = before
    state.compare_systems(str(old), new)


def draw_tests(result: Result) -> None:
    """Draw the table of the tests between both versions."""
    st.header("Tests", anchor=False)
    link = docs_link("Significance", "significance", doc="significance")
    table = tests_table(result, measure_evidence(result))
    draw_table_of(table, key="releases-tests", explanation=f"{link}.")


def draw_measures(result: Result) -> None:
    """Draw a chart of each measure over the versions, with the limit of the gate."""
    rules = state.opened().session.rules
    key = (*comparison_key(result), rules)
    measures: pd.DataFrame = state.cached(
        "releases_measures", key, lambda: measures_of_versions(result, parse_rules(rules))
    )
    st.header("Versions", anchor=False, help="Dashed: limit of the gate. Cross: breaks the rule.")
    n = measures["version"].nunique()
    places: list[DeltaGenerator] = []
    for number, first in enumerate(range(0, len(measures), n)):
        places = places or st.columns(IN_A_ROW, gap="medium")
        with places.pop(0):
            of_one = measures.iloc[first : first + n]
            figure = version_plot(result, of_one, theme=state.theme())
            draw_chart(figure, f"releases_version_{number}")
