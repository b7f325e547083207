"""What the driver knows of rules: on how many encounters a measure of his view rests, and which."""

from __future__ import annotations

from functools import partial
from typing import Final

import numpy as np

from nvcore.comparison import Result
from nvcore.driver.comparison.doubts import doubt_of, doubt_of_estimator, doubt_of_seen
from nvcore.driver.comparison.facts import NoClaim
from nvcore.driver.comparison.kinds import DriverRegion
from nvcore.driver.comparison.measures import KNOWN
from nvcore.driver.comparison.said import known, no_claim
from nvcore.driver.comparison.settings import DRIVER
from nvcore.driver.comparison.steps import driver_in
from nvcore.report.gate.added import RulesOf
from nvcore.report.gate.measures import CONDITIONS, MEASURE_OF
from nvcore.sentences.facts import Fact

OF_DRIVER: Final = frozenset(
    {
        *(name for name, only_if in CONDITIONS.items() if only_if is KNOWN),
        *(name for name, measure in MEASURE_OF.items() if DRIVER in measure.stages),
    }
)
"""Measures that rest on whom the driver sees: of the encounters of which it is known."""
OF_URGENT: Final = frozenset(
    name
    for name in OF_DRIVER
    if name in ("driver.urgent", "driver.in_time", "driver.too_late") or "in_time_alone" in name
)
"""Those of them that count urgent encounters alone."""
OF_ANY_ESTIMATOR: Final = frozenset(
    {
        f"driver_venn.{DriverRegion.UNKNOWN}",
        *("driver.urgent", "driver.boxes_without_detectability"),
    }
)
"""Those of them that are as good with an estimator that learned nothing."""


def _facts(result: Result, name: str) -> tuple[Fact, ...]:
    if name not in OF_DRIVER:
        measure = MEASURE_OF.get(name)
        why = doubt_of_estimator(result) if measure and doubt_of(result, measure) else None
        return (NoClaim("weighted", why),) if why else ()
    if not driver_in(result).has_any:
        return ()
    return known(result, of_urgent=name in OF_URGENT), *no_claim(result)


def _is_in(result: Result, *, regions: tuple[DriverRegion, ...]) -> np.ndarray:
    return np.isin(driver_in(result).region, regions)


RULES: Final = RulesOf(
    undefined=lambda result: OF_DRIVER - OF_ANY_ESTIMATOR if doubt_of_seen(result) else set(),
    facts=_facts,
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
