"""The figures of alerts, each from a comparison alone."""

from typing import Final

from nvcore.alerts.figures.in_time import alerts_in_time
from nvcore.alerts.figures.trade_off import alert_trade_off

FIGURES: Final = {"alert_trade_off": alert_trade_off, "alerts_in_time": alerts_in_time}
"""By their names in `nvcore.api.figures.Figures`."""
