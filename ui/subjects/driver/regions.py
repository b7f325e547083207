"""Driver page: encounters by whether driver, X and Y see them, as a diagram and in words."""

from __future__ import annotations

from typing import Final

import streamlit as st

from nvcore.common.wording import capitalised
from nvcore.comparison.compare import Result
from nvcore.subjects.driver.comparison.encounters import (
    REGION_NAMES,
    driver_venn_table,
    over_driver_threshold,
)
from nvcore.subjects.driver.comparison.figures import driver_threshold_plot, driver_venn_plot
from nvcore.subjects.driver.comparison.judging import DriverRegion
from nvcore.subjects.driver.comparison.steps import driver_in
from ui.session import state, store
from ui.widgets.charts import clicked_chart, draw_chart
from ui.widgets.table import TableColumn, draw_table
from ui.widgets.text import docs_link

USEFUL: Final = (DriverRegion.X, DriverRegion.Y)
"""Regions in which one system is worth most. They are explained unless another is selected."""
COLUMNS: Final = {
    "who": TableColumn("Seen by", is_head=True),
    "encounters": TableColumn("Encounters"),
    "severity_x": TableColumn("Severity X (s)", form=".2f"),
    "severity_y": TableColumn("Severity Y (s)", form=".2f"),
}


def draw(result: Result) -> DriverRegion | None:
    """Draw the diagram and a list of its regions. Return the selected region, or None for all."""
    left, right = st.columns([2, 3], gap="medium")
    names = result.names
    with left:
        figure = driver_venn_plot(
            driver_in(result).counts, names, theme=state.theme(), objects=result.objects
        )
        clicked = clicked_chart(figure, "driver_venn")
    if clicked in [*DriverRegion]:
        store.DRIVER_REGION.set(DriverRegion(clicked))
    table = driver_venn_table(result)
    has_unknown = driver_in(result).counts[DriverRegion.UNKNOWN] > 0
    table = table if has_unknown else table[table["region"] != DriverRegion.UNKNOWN]
    with right:
        draw_table(table, COLUMNS, key="driver_regions", name="Who sees", is_sortable=False)
        chosen: DriverRegion | None = st.selectbox(
            "Encounters seen by",
            [DriverRegion(region) for region in table["region"]],
            index=None,
            format_func=REGION_NAMES.__getitem__,
            placeholder="any or none of them: all",
            key=store.DRIVER_REGION.key,
            persist_state="session",
        )
        told = USEFUL if chosen is None else (chosen,)
        meanings = table.set_index("region")["meaning"]
        lines = [f"**{capitalised(REGION_NAMES[region])}**: {meanings[region]}" for region in told]
        st.caption("  \n".join(lines))
    return chosen


def draw_over_threshold(result: Result) -> None:
    """Plot what the driver leaves to X and Y against the detectability threshold, folded."""
    with st.expander("Over the threshold"):
        figure = driver_threshold_plot(
            over_driver_threshold(result),
            result.names,
            threshold=result.params.driver_threshold,
            theme=state.theme(),
            objects=result.objects,
        )
        draw_chart(
            figure,
            "driver_over_threshold",
            help=state.say(
                "The driver sees the {one} where detectability reaches the threshold in a "
                "frame up to the first that counts. How many encounters that leaves for X and Y to "
                "warn of depends on the threshold, not on the systems ({link}).",
                link=docs_link(
                    state.say("{what} the driver sees"), "whom-the-driver-sees", doc="driver"
                ),
            ),
        )
