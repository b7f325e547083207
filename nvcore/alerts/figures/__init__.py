"""The figures of alerts, each from a comparison alone."""

from __future__ import annotations

from typing import Final

import plotly.graph_objects as go

from nvcore.alerts.figures.in_time import in_time_plot
from nvcore.alerts.figures.trade_off import trade_off_plot
from nvcore.alerts.steps import alerts_in
from nvcore.comparison import Result
from nvcore.palette import Theme


def alert_trade_off(result: Result, *, theme: Theme) -> go.Figure:
    """Urgent encounters alerted in time against unwanted alerts, over the score threshold."""
    view = alerts_in(result)
    names = result.x.name, result.y.name
    return trade_off_plot(
        view.curve, names, n_urgent=view.n_urgent, duration_s=result.duration_s, theme=theme
    )


def alerts_in_time(result: Result, *, theme: Theme) -> go.Figure:
    """Urgent encounters in which the driver reacts in time, by kind of alert."""
    judged = alerts_in(result).in_time_for_drivers
    return in_time_plot(judged, (result.x.name, result.y.name), theme=theme)


FIGURES: Final = {"alert_trade_off": alert_trade_off, "alerts_in_time": alerts_in_time}
"""By their names in `nvcore.api.figures.Figures`."""
