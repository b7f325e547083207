from __future__ import annotations

import numpy as np

from nvcore.comparison.compare import Result
from nvcore.comparison.measures.entry import HIGHER, Measure, MeasureTable
from nvcore.comparison.scoring import Inputs, ScoringStep, SystemResult
from nvcore.settings.stages import ENCOUNTERS
from toy.settings import LONG


def _find(at: Inputs) -> np.ndarray:
    return at.encounters.n_frames >= at.params.toy_frames


def is_long(result: Result) -> np.ndarray:
    return result.made["long"]


def _count(result: Result, system: SystemResult) -> int:
    return int((is_long(result) & system.encounters["is_detected"]).sum())


STEPS = (ScoringStep("long", _find, (LONG,), of="truth"),)
MEASURES = (
    Measure(
        key="toy_detected",
        label="long encounters detected",
        form="d",
        better=HIGHER,
        stages=(LONG, ENCOUNTERS),
        is_worsened_by_alarms=False,
        of=_count,
        unit="encounters",
        meaning="Long encounters that the system detected.",
        tables=(MeasureTable.SCORECARD,),
    ),
)
