"""Time left page: effect of the car's speed."""

from __future__ import annotations

from functools import partial
from typing import Final

import pandas as pd
import streamlit as st

from nvcore.comparison.compare import Result
from nvcore.settings.params import settings_for
from nvcore.settings.stages import THRESHOLD
from nvcore.subjects.time_left.figures import OverSpeed, over_speed_plot
from nvcore.subjects.time_left.notes import orders
from nvcore.subjects.time_left.settings import TIME_LEFT
from nvcore.subjects.time_left.steps import time_left_in
from ui.session import state
from ui.widgets.charts import draw_chart, kept_figure
from ui.widgets.text import docs_link, plain

MEASURES: Final[tuple[OverSpeed, ...]] = ("share_in_time", "mean_impact_kmh")


def draw(result: Result) -> None:
    """Plot share in time and mean impact speed against speed, and say where the order reverses."""
    key, curve = _curve(result)
    if not curve["urgent"].any():
        st.caption("No encounter is urgent at any speed.")
        return
    st.markdown("  \n".join(plain(state.say(order)) for order in orders(curve)))
    names, theme = result.names, state.theme()
    speed_kmh = time_left_in(result).assumed_speed_kmh
    help_text = state.say(
        "Each speed in place of all others, those of recordings as well, with the approach as "
        "it was recorded: the same seconds are more metres at a higher speed, at which nobody "
        "knows whether the systems detect as well. At a higher speed more {many} are "
        "urgent, and more are too near when first known and left out: so the share may rise "
        "with speed. Where the order turns is not tested: a single encounter may do it "
        "({link}).",
        link=docs_link("Time left", "time-left"),
    )
    for column, measure in zip(st.columns(2, gap="medium"), MEASURES, strict=True):
        make = partial(
            over_speed_plot, curve, names, speed_kmh=speed_kmh, theme=theme, measure=measure
        )
        with column:
            figure = kept_figure(f"time_left_{measure}", (key, speed_kmh, theme), make)
            draw_chart(figure, f"time_left_{measure}", help=help_text)


def _curve(result: Result) -> tuple[tuple[object, ...], pd.DataFrame]:
    """Return the cache key and the table of `Result.over_speed`, which no speed setting affects."""
    names = [name for name in settings_for(THRESHOLD, TIME_LEFT) if name != "speed_kmh"]
    settings = tuple(getattr(result.params, name) for name in names)
    key = settings, result.x.name, result.y.name
    return key, state.cached("over_speed", key, lambda: time_left_in(result).over_speed, most=8)
