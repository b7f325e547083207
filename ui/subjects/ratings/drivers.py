"""Ratings page: drivers of the ratings, and the alpha that the ratings imply."""

from __future__ import annotations

from typing import Final

import numpy as np
import pandas as pd
import streamlit as st

from nvcore.common.wording import capitalised, count_text
from nvcore.comparison.compare import Result
from nvcore.subjects.ratings.drivers import DRIVERS, RatingDrivers, find_drivers
from ui.session import state
from ui.widgets.choices import download_csv
from ui.widgets.table import TableColumn, draw_table
from ui.widgets.text import UNDEFINED, docs_link

MOST_KEPT: Final = 8


def draw(result: Result, ranks: pd.DataFrame, clips: pd.DataFrame, ratings_key: object) -> None:
    """Draw the implied alpha and the drivers' weights. `ratings_key` identifies the ranks."""
    drivers = state.workspace().cached(
        "rating_drivers",
        (ratings_key, clips[[*DRIVERS]].to_numpy().tobytes()),
        lambda: find_drivers(ranks, clips),
        most=MOST_KEPT,
    )
    st.header("What drives the ratings?")
    st.markdown(alpha_text(drivers, result.params.alpha))
    table = drivers.table
    shown = pd.DataFrame(
        {
            "driver": table["driver"].map(DRIVERS),
            "sd": table["sd"],
            "value": table["value"],
            "interval": [
                UNDEFINED if np.isnan(low) else f"{low:.2f} to {high:.2f}"
                for low, high in zip(table["low"], table["high"], strict=True)
            ],
            "reason": [capitalised(reason) for reason in table["reason"]],
        }
    )
    columns = {
        "driver": TableColumn("Of a clip", is_head=True),
        "sd": TableColumn("SD over clips", form=".3g"),
        "value": TableColumn(
            "Odds ×",
            "By what the odds are multiplied that somebody finds this clip more annoying than "
            "another, for one SD more, all other rows equal. 1: no part in it.",
            ".2f",
        ),
        "interval": TableColumn("95 % interval", is_number=True),
        "reason": TableColumn("Why there is none"),
    }
    if not table["reason"].any():
        del columns["reason"]
    draw_table(
        shown, columns, key="rating_drivers", name="Drivers of the ratings", is_sortable=False
    )
    st.caption(
        f"From {count_text(drivers.n_clips, 'clip')} of "
        f"{count_text(drivers.n_recordings, 'recording')}, ranked by "
        f"{count_text(drivers.n_people, 'participant')}. Intervals are {intervals_text(drivers)} "
        f"({docs_link('how', 'what-drives-the-ratings', doc='ratings')})."
    )
    download_csv("Drivers (CSV)", lambda: drivers.with_alpha, "drivers.csv", "rating_drivers_csv")


def intervals_text(drivers: RatingDrivers) -> str:
    """Name what the intervals speak of: people, or only those who rated."""
    if drivers.is_of_people:
        return "of the mean of people, from resampling recordings and participants"
    return f"of {_raters(drivers)} only, from resampling the recordings"


def _raters(drivers: RatingDrivers) -> str:
    if drivers.is_of_people:
        return "people"
    n = drivers.n_people
    return "this participant" if n == 1 else f"these {count_text(n, 'participant')}"


def alpha_text(drivers: RatingDrivers, alpha: float) -> str:
    """Describe the alpha that the ratings imply, compared with the one in use."""
    who = _raters(drivers)
    weigh = "weighs" if drivers.n_people == 1 else "weigh"
    if drivers.reason:
        return (
            f"Which alpha {who} {weigh} misses and false alarms by **cannot be told from these "
            f"ratings**: {drivers.reason}."
        )
    is_inside = drivers.low <= alpha <= drivers.high
    an_alpha = "an alpha" if drivers.n_people == 1 else "a mean alpha"
    return (
        f"{capitalised(who)} {weigh} misses and false alarms by {an_alpha} of "
        f"**{drivers.alpha:.2f}** (95 %: {drivers.low:.2f} to {drivers.high:.2f}). "
        f"The {alpha:g} in use "
        f"{'agrees with that' if is_inside else 'is outside of it'}."
    )
