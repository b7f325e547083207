"""How detectable a pedestrian is from frame to frame, against what the driver needs to see him."""

from __future__ import annotations

from typing import Final

import pandas as pd
import plotly.graph_objects as go

from nvcore.figures.marks import marks, steady_marker
from nvcore.figures.style import LOOK, axis, draw, empty_figure, faded
from nvcore.palette import Theme
from nvcore.wording import count_text

HEIGHT_PX: Final = 300


def detectability_course_plot(course: pd.DataFrame, *, threshold: float, theme: Theme) -> go.Figure:
    """Detectability over time, with its uncertainty.

    A click on a mark gives its row of the frames table as `customdata`.

    Parameters
    ----------
    course
        Of `nvcore.tables.encounters.driver.detectability_course`.
    threshold
        From which the driver is taken to see him, 0..1.
    """
    known = course[course["detectability"].notna()]
    if known.empty:
        text = "It is not known how detectable this pedestrian is, in any frame."
        return empty_figure(text, theme=theme)
    look = LOOK[theme]
    sd = known["sd"].fillna(0.0)
    low = (known["detectability"] - sd).clip(0, 1)
    high = (known["detectability"] + sd).clip(0, 1)
    band = go.Scatter(
        x=[*known["time_s"], *known["time_s"][::-1]],
        y=[*high, *low[::-1]],
        fill="toself",
        fillcolor=faded(look.muted, 0.2),
        mode="none",
        hoverinfo="skip",
        name="± 1 standard deviation",
        showlegend=bool((sd > 0).any()),
    )
    parts = [
        (known[known["is_up_to_relevant"]], "up to the first frame that counts", "circle"),
        (known[~known["is_up_to_relevant"]], "later, or distant", "circle-open"),
    ]
    traces = [band]
    for frames, name, symbol in parts:
        traces.append(
            marks(
                frames["time_s"],
                frames["detectability"],
                None,
                hover="%{x:.2f} s: %{y:.2f}<extra></extra>",
                customdata=frames["row"],
                name=name,
                showlegend=len(frames) > 0,
                **steady_marker(color=look.ink, size=6, symbol=symbol),
            )
        )
    figure = draw(
        traces,
        theme,
        title="Detectability over time",
        subtitle=f"{count_text(len(known), 'frame')} in which it is known, of {len(course):,}",
        height=HEIGHT_PX,
        xaxis=axis(theme, "time (s)"),
        yaxis=axis(theme, "share of drivers who see him", range=[-0.04, 1.04], fixedrange=True),
    )
    figure.add_hline(
        y=threshold,
        line={"color": look.muted, "width": 1.5, "dash": "dash"},
        annotation_text=f"sees from {threshold:g} on",
        annotation_position="bottom right",
    )
    return figure
