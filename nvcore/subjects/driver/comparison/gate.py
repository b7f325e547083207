"""Gate rules on the driver: undefined measures, notes, and the encounters that they count."""

from __future__ import annotations

from functools import partial
from typing import Final

import numpy as np

from nvcore.comparison.compare import Result
from nvcore.notes import Note
from nvcore.report.gate.added import RulesOf
from nvcore.report.gate.measures import CONDITIONS, MEASURE_OF
from nvcore.subjects.driver.comparison.judging import DriverRegion
from nvcore.subjects.driver.comparison.measures import KNOWN
from nvcore.subjects.driver.comparison.notes import (
    doubt_of,
    doubt_of_seen,
    known,
    no_claim,
    no_claim_of_weighted,
)
from nvcore.subjects.driver.comparison.settings import DRIVER
from nvcore.subjects.driver.comparison.steps import driver_in

OF_DRIVER: Final = frozenset(
    {
        *(name for name, only_if in CONDITIONS.items() if only_if is KNOWN),
        *(name for name, measure in MEASURE_OF.items() if DRIVER in measure.stages),
    }
)
"""Measures that depend on whom the driver sees, over encounters with known detectability."""
OF_URGENT: Final = frozenset(
    name
    for name in OF_DRIVER
    if name in ("driver.urgent", "driver.in_time", "driver.too_late") or "in_time_alone" in name
)
"""Subset of these measures that count urgent encounters only."""
OF_ANY_ESTIMATOR: Final = frozenset(
    {
        f"driver_venn.{DriverRegion.UNKNOWN}",
        *("driver.urgent", "driver.boxes_without_detectability"),
    }
)
"""Subset of these measures that look equally good for an estimator that learned nothing."""


def _notes(result: Result, name: str) -> tuple[Note, ...]:
    if name not in OF_DRIVER:
        measure = MEASURE_OF.get(name)
        return no_claim_of_weighted(result) if measure and doubt_of(result, measure) else ()
    if not driver_in(result).has_any:
        return ()
    return known(result, of_urgent=name in OF_URGENT), *no_claim(result)


def _is_in(result: Result, *, regions: tuple[DriverRegion, ...]) -> np.ndarray:
    return np.isin(driver_in(result).region, regions)


RULES: Final = RulesOf(
    undefined=lambda result: OF_DRIVER - OF_ANY_ESTIMATOR if doubt_of_seen(result) else set(),
    notes=_notes,
    counted={
        **{
            f"driver_venn.{region.value}": partial(_is_in, regions=(region,))
            for region in DriverRegion
        },
        "unprotected_x": partial(_is_in, regions=(DriverRegion.Y, DriverRegion.NOBODY)),
        "unprotected_y": partial(_is_in, regions=(DriverRegion.X, DriverRegion.NOBODY)),
    },
    is_open=lambda result: driver_in(result).is_within_sd,
)
