"""Signs of two limits, and two systems that read them; countable by hand."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from builders import Box, make_dataset, result_of

from nvcore.comparison.compare import Result
from nvcore.dataset.schema import NO_LABEL

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


def write_limits(folder: Path) -> Path:
    """A session of the same in files: X reads one of three signs wrong, Y names no class."""
    head = "recording,frame,x,y,w,h"
    places = [f"drive,{i},100,100,40,40" for i in range(3)]
    kinds = {"truth": ("30", "30", "50"), "x": ("30", "50", "50")}
    for name, limits in kinds.items():
        rows = [f"{place},speed limit {limit}" for place, limit in zip(places, limits, strict=True)]
        (folder / f"{name}.csv").write_text("\n".join([f"{head},class", *rows, ""]))
    (folder / "y.csv").write_text("\n".join([head, *places, ""]))
    session = folder / "session.toml"
    session.write_text(
        '[defaults]\nsize = "640x480"\nfps = 10\n[truth]\npath = "truth.csv"\n'
        '[[system]]\nname = "Ray"\npath = "x.csv"\n[[system]]\nname = "Yon"\npath = "y.csv"\n'
        '[compare]\nobjects = "speed sign"\n'
    )
    return session
