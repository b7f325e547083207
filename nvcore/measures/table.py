"""Every measure, in the order of ``summary.json`` and of all tables."""

from __future__ import annotations

from itertools import chain
from typing import Final

from nvcore.measures.entry import Measure
from nvcore.measures.of_alarms import ALARM_MEASURES
from nvcore.measures.of_curves import CURVE_MEASURES
from nvcore.measures.of_driver import DRIVER_MEASURES
from nvcore.measures.of_encounters import ENCOUNTER_MEASURES
from nvcore.measures.of_frames import FRAME_MEASURES
from nvcore.subjects import contributed

MEASURES: Final[tuple[Measure, ...]] = (
    *FRAME_MEASURES,
    *ENCOUNTER_MEASURES,
    *chain(*contributed("measures")),
    *DRIVER_MEASURES,
    *ALARM_MEASURES,
    *CURVE_MEASURES,
)
