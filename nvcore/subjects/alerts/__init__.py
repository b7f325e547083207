"""Alerts: which detections reach the driver, and which of the resulting alerts were justified."""

from __future__ import annotations

from collections.abc import Sequence
from typing import ClassVar

from nvcore.common import subject


class Alerts(subject.Subject):
    """Alerts to the driver."""

    name = "alerts"
    needs = ("time_left", "driver")
    names: ClassVar = {"nvcore.subjects.alerts.calls.python": ("judge_alerts",)}

    def settings(self) -> subject.AddedSettings:
        from nvcore.subjects.alerts.settings import ALERTS, AlertSettings

        return subject.AddedSettings((AlertSettings,), shown=(ALERTS,))

    def session_keys(self) -> subject.AddedKeys:
        from nvcore.subjects.alerts.session import SystemAlerts

        return subject.AddedKeys(system=(SystemAlerts,))

    def inputs(self) -> Sequence[subject.Input]:
        from nvcore.subjects.alerts.inputs import INPUT

        return (INPUT,)

    def scores(self) -> subject.AddedScores:
        from nvcore.subjects.alerts.measures import COUNTS, MEASURES
        from nvcore.subjects.alerts.steps import STEPS, AlertsView

        return subject.AddedScores(STEPS, AlertsView, MEASURES, COUNTS)

    def tables(self) -> subject.AddedTables:
        from nvcore.subjects.alerts.columns import COLUMNS

        return subject.AddedTables(COLUMNS)

    def figures(self) -> subject.AddedFigures:
        from nvcore.subjects.alerts.figures import FIGURES

        return subject.AddedFigures(FIGURES)

    def report(self) -> subject.AddedReport:
        from nvcore.subjects.alerts.notes import doubt_of
        from nvcore.subjects.alerts.section import POINTS, SECTIONS

        return subject.AddedReport(POINTS, SECTIONS, (doubt_of,))

    def commands(self) -> Sequence[subject.Command]:
        from nvcore.subjects.alerts.calls.commands import alerts

        return (alerts,)
