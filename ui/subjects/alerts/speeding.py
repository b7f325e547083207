"""Alerts page: alerts of excessive speed, based on the limits that a system reads from signs."""

from __future__ import annotations

from typing import Final

import streamlit as st

from nvcore.common.wording import minus, number
from nvcore.comparison.compare import Result
from nvcore.subjects.alerts.speeding import ROWS, Speeding
from nvcore.subjects.alerts.steps import alerts_in
from ui.subjects.alerts.listed import draw_beside_viewer
from ui.widgets.choices import download_csv
from ui.widgets.html import MeasureRow, measures_html
from ui.widgets.table import TableColumn
from ui.widgets.text import docs_link

SHOWN: Final = ("alerted", "missed", "false", "median_late_s", "right_limit")
"""Rows of `ROWS` that the page shows."""
COLUMNS: Final = {
    "subject": TableColumn(
        "Of", "Whose alert it is: of X, of Y, or called for by the truth.", is_head=True
    ),
    "recording": TableColumn("Recording"),
    "start_s": TableColumn("Start (s)", "When it begins.", ".2f"),
    "state": TableColumn(
        "What", "Right: overlaps one that the truth calls for; false or missed: why."
    ),
    "limit_kmh": TableColumn("Limit", "Limit stored then, km/h.", ".0f"),
    "true_limit_kmh": TableColumn("True", "Limit by the truth then, km/h.", ".0f"),
    "top_kmh": TableColumn("Speed", "Highest speed in it, km/h.", ".0f"),
}


def draw(result: Result) -> None:
    """Draw alerts of excessive speed by X and Y, if the objects are speed signs."""
    speeding = alerts_in(result).speeding
    if speeding is None:
        return
    st.header("Above the limit")
    link = docs_link("speed alerts", "speed-alerts", doc="objects")
    st.caption(
        "A system stores the limit that it read last. Once the car has been above it for "
        f"{result.params.speeding_after_s:g} s the driver is alerted ({link})."
    )
    summary = speeding.summary().to_dict("records")
    rows = [
        MeasureRow(
            ROWS[name][0].format(true=summary[0]["true"]),
            tuple(minus(number(row[name], ROWS[name][1])) for row in summary),
        )
        for name in SHOWN
    ]
    left, _ = st.columns(2, gap="medium")
    left.html(measures_html(rows, key="speeding", head=("X", "Y")))
    _draw_episodes(result, speeding)


def _draw_episodes(result: Result, speeding: Speeding) -> None:
    episodes = speeding.episodes
    if episodes.empty:
        st.info("The car is never above a limit for so long.")
        return
    names = result.dataset.recordings["name"].to_numpy()
    table = episodes.assign(
        subject=episodes["subject"].map({"x": "X", "y": "Y", "truth": "truth"}),
        state=episodes["state"].astype(str).str.replace("_", " "),
        cause=episodes["cause"].astype(str).str.replace("_", " "),
        recording=names[episodes["recording"]],
    )
    what = table["state"].replace("true", "called for")
    what += (": " + table["cause"]).where(table["cause"] != "", "")
    shown = table.assign(state=what, row=episodes["first_row"], encounter_row=-1)
    draw_beside_viewer(result, shown, COLUMNS, key="speeding", name="Speed alerts")
    download_csv("speeding.csv", lambda: table, "speeding.csv", "speeding_csv")
