"""Estimates of what drivers see unaided: picture features, estimators, and trials with people."""

from __future__ import annotations

from collections.abc import Sequence
from typing import ClassVar

from nvcore.common import subject


class Driver(subject.Subject):
    """What the driver sees unaided."""

    name = "driver"
    needs = ("time_left",)
    names: ClassVar = {
        "nvcore.subjects.driver.calls.python": (
            *("driver_features", "estimate_driver", "evaluate_driver", "image_features"),
            "train_driver",
        )
    }
    formats: ClassVar = {
        "nvcore-driver": "an estimator of what the driver sees, which nvcore driver estimate takes"
    }
    extras: ClassVar = {"driver": ("av", "cv2", "sklearn")}

    def settings(self) -> subject.AddedSettings:
        from nvcore.subjects.driver.comparison.settings import DRIVER, DriverSettings

        return subject.AddedSettings((DriverSettings,), shown=(DRIVER,))

    def session_keys(self) -> subject.AddedKeys:
        from nvcore.subjects.driver.inputs.session import DriverEntry, DriverTables

        return subject.AddedKeys(recording=(DriverEntry,), tables=(DriverTables,))

    def inputs(self) -> Sequence[subject.Input]:
        from nvcore.subjects.driver.inputs.joining import INPUT

        return (INPUT,)

    def scores(self) -> subject.AddedScores:
        from nvcore.subjects.driver.comparison.measures import COUNTS, MEASURES
        from nvcore.subjects.driver.comparison.steps import MISS_WEIGHTS, STEPS, driver_view

        return subject.AddedScores(STEPS, driver_view, MEASURES, COUNTS, (MISS_WEIGHTS,))

    def tables(self) -> subject.AddedTables:
        from nvcore.subjects.driver.comparison.columns import COLUMNS, ENTRIES

        return subject.AddedTables(COLUMNS, ENTRIES)

    def checks(self) -> subject.AddedChecks:
        from nvcore.subjects.driver.findings import CAVEATS, audit_detectability

        return subject.AddedChecks((audit_detectability,), caveats=(CAVEATS,))

    def report(self) -> subject.AddedReport:
        from nvcore.subjects.driver.comparison.gate import RULES
        from nvcore.subjects.driver.comparison.notes import doubt_of
        from nvcore.subjects.driver.comparison.report import POINTS, REMARKS, SECTIONS

        return subject.AddedReport(POINTS, SECTIONS, (doubt_of,), (REMARKS,), (RULES,))

    def commands(self) -> Sequence[subject.Command]:
        from nvcore.subjects.driver.calls.commands import driver

        return (driver,)

    def models(self) -> Sequence[subject.Models]:
        from nvcore.subjects.driver.evaluation.estimator_report import MODELS

        return (MODELS,)
