"""Notes on the driver for the verdict and the first page of the report."""

from __future__ import annotations

from typing import Final

from nvcore.dataset import Dataset
from nvcore.driver.comparison.columns import driver_views
from nvcore.driver.comparison.notes import (
    driver_notes,
    limits,
    weighted_claims,
    weighting,
    weighting_notes,
)
from nvcore.report.remarks import Remarks
from nvcore.report.verdict import PointOf
from nvcore.wording import capitalised

POINTS: Final = (
    PointOf("Weighting", weighting_notes, after="Operating points", is_warning=True),
    PointOf("The driver", driver_notes, after="Time left"),
)


def _views(dataset: Dataset) -> list[str]:
    """List for each recording which data on the driver it has: pictures, light meter, gaze."""
    views = driver_views(dataset)
    words_of = {
        "pictures of visible light": views["has_visible"],
        "light meter": views["light_by"] == "meter",
        "gaze": views["has_gaze"],
    }
    return [
        capitalised(", ".join(text for text, is_there in words_of.items() if is_there[i]))
        for i in range(len(dataset.recordings))
    ]


REMARKS: Final = Remarks(weighting, limits, weighted_claims, ("Driver's view", _views))
