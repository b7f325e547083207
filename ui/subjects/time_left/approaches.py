"""Time left page: each urgent encounter up to contact, and margins of X against Y."""

from __future__ import annotations

from typing import Any

import pandas as pd

from nvcore.comparison.compare import Result
from nvcore.subjects.time_left.encounters import urgent_encounters
from nvcore.subjects.time_left.figures import MOST_ROWS, approach_plot, margins_plot
from ui.session import state
from ui.subjects.time_left.listed import open_encounter
from ui.subjects.time_left.numbers import key_of
from ui.widgets.charts import clicked_chart, kept_figure
from ui.widgets.choices import choose_first
from ui.widgets.text import docs_link


def urgent_of(result: Result) -> pd.DataFrame:
    """Return `urgent_encounters`, recomputed only for settings that affect them."""
    urgent: pd.DataFrame = state.cached(
        "urgent_encounters", key_of(result), lambda: urgent_encounters(result), most=8
    )
    return urgent


def draw(result: Result, urgent: pd.DataFrame) -> None:
    """Plot each urgent encounter as a line. A click opens that frame."""
    label = "Urgent encounters, the fastest impact first"
    first = choose_first(label, len(urgent), MOST_ROWS, "time_left_first", width=320)
    theme = state.theme()
    figure = kept_figure(
        "time_left_approaches",
        (*key_of(result), first, theme),
        lambda: approach_plot(result, urgent, theme=theme, first=first),
    )
    clicked = clicked_chart(
        figure,
        "time_left_approaches",
        help=state.say(
            "Contact is where the time to contact at the last chance says; the picture need not "
            "show it. A filled mark is where a system has confirmed the {one}, an open one "
            "right of contact says that it never does. Impact speeds follow from the time to "
            "contact as measured then, so marks at one place can differ in them. Click a mark to "
            "open its frame in the Timeline ({link}).",
            link=docs_link("Confirmed in time", "confirmed-in-time"),
        ),
    )
    _follow(result, clicked)


def draw_margins(result: Result, urgent: pd.DataFrame) -> None:
    """Plot by how much X and Y confirm each urgent encounter before the last chance."""
    theme = state.theme()
    figure = kept_figure(
        "time_left_margins",
        (*key_of(result), theme),
        lambda: margins_plot(result, urgent, theme=theme),
    )
    clicked = clicked_chart(
        figure,
        "time_left_margins",
        help="Margin: time from confirmation to the last chance, negative is too late. Below the "
        "dotted line X is first, above it Y. Click a mark to open the last chance.",
    )
    _follow(result, clicked)


def _follow(result: Result, clicked: Any) -> None:
    if clicked is not None:
        row, encounter = clicked
        open_encounter(result, encounter, row)
