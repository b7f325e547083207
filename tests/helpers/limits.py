"""Signs of two limits, and two systems that read them; countable by hand."""

from __future__ import annotations

from typing import Any

from builders import Box, make_dataset, result_of

from nvcore.comparison import Result
from nvcore.schema import NO_LABEL

LABELS = ("30", "50")
_LABEL = {"30": 0, "50": 1, "": NO_LABEL}


def sign(frame: int, limit: str, **more: Any) -> Box:
    return Box(frame, 10, 10, 20, 20, label=_LABEL[limit], **more)


def limits_read(**params: Any) -> Result:
    """Signs of 30, 30, 30, 50, 50 and one of which nobody knows, each in a frame of its own.

    X reads them as 30, 30, 50, 50, nothing and 50, and sees a seventh that is not there. Y finds
    the first two and names no class.
    """
    truth = [sign(i, limit) for i, limit in enumerate(("30", "30", "30", "50", "50", ""))]
    read = ("30", "30", "50", "50", "", "50", "30")
    x = [sign(i, limit, score=0.9) for i, limit in enumerate(read)]
    y = [sign(i, "", score=0.9) for i in range(2)]
    return result_of(make_dataset(truth, x, y, labels=LABELS), **params)
