"""Driver page: what another threshold of seeing would change."""

from __future__ import annotations

import streamlit as st

from nvcore.comparison import Result
from nvcore.driver.comparison.encounters import over_driver_threshold
from nvcore.driver.comparison.figures.over_threshold import driver_threshold_plot
from ui.session import state
from ui.widgets.charts import draw_chart
from ui.widgets.text import docs_link


def draw(result: Result) -> None:
    """Whom the driver sees and what that leaves to X and Y over the threshold, folded away."""
    with st.expander("Over the threshold"):
        figure = driver_threshold_plot(
            over_driver_threshold(result),
            (result.x.name, result.y.name),
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
                link=docs_link(state.say("{what} the driver sees"), "whom-he-sees", doc="driver"),
            ),
        )
