"""A comparison without any finding, and ways to spoil it, for the tests of the audit."""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np
import pandas as pd
from builders import Box, make_dataset

from nvcore.auditing import audit
from nvcore.common.findings import Finding
from nvcore.dataset import Dataset
from nvcore.settings.params import Params

N = 40
"""Frames of the clean comparison."""
SIZE = {"width": 640.0, "height": 480.0}


def walk(*, first: int = 0, stop: int = N, step: int = 1, **more: Any) -> list[Box]:
    """One pedestrian walking right, one box a frame; scores go from 0.5 to 0.9."""
    return [
        Box(f, 100 + 3 * f, 200, 40, 100, score=0.5 + 0.4 * (f % 9) / 8, **more)
        for f in range(first, stop, step)
    ]


def truth_walk(**more: Any) -> list[Box]:
    return walk(**{"track": 1, **more})


def drawn(boxes: Any, off: float) -> list[Box]:
    """The boxes as a system draws them: never the very same as somebody else's."""
    return [box._replace(x=box.x + off) for box in boxes]


def dataset(truth: Any = None, x: Any = None, y: Any = None, **more: Any) -> Dataset:
    """The clean comparison, with what a test replaces in it.

    X stands 1/8 px to the right of what is given, Y 1/8 px to the left.
    """
    if "places" not in more and "frames" not in more:
        more = {"n_frames": N, **more}
    if "places" not in more:
        more = {**SIZE, **more}
    return make_dataset(
        truth_walk() if truth is None else truth,
        drawn(walk() if x is None else x, 0.125),
        drawn(walk() if y is None else y, -0.125),
        **more,
    )


def with_lines(made: Dataset) -> Dataset:
    """The same dataset as if it came from three files: box i of each from line i + 1."""
    source = made.boxes["source"]
    line = made.boxes.groupby("source").cumcount() + 1
    files = ["gt.txt", "x.txt", "y.txt"]
    inputs = pd.DataFrame({"subject": ["truth", "x", "y"], "file": files})
    boxes = made.boxes.assign(file=source.astype("int32"), line=line.astype("int32"))
    return dataclasses.replace(made, boxes=boxes, inputs=inputs)


def with_left_out(made: Dataset, *rows: tuple[str, str, int, str]) -> Dataset:
    """The dataset with rows (subject, recording, frame, reason) left out, lines from 1."""
    table = pd.DataFrame(rows, columns=["subject", "recording", "frame", "reason"])
    lines = np.arange(1, len(rows) + 1)
    files = table["subject"].map({"truth": 0, "x": 1, "y": 2})
    box = {"x": 1.0, "y": 1.0, "w": 0.0, "h": np.nan}
    return dataclasses.replace(
        with_lines(made), left_out=table.assign(file=files, line=lines, **box)
    )


def codes(made: Dataset, params: Params | None = None, **names: str) -> list[str]:
    return [finding.code for finding in audit(made, params, **names)]


def find(made: Dataset, code: str, params: Params | None = None, **names: str) -> Finding:
    """The only finding of that code."""
    (finding,) = [finding for finding in audit(made, params, **names) if finding.code == code]
    return finding


def reported(
    made: Dataset, code: str, params: Params | None = None, **names: str
) -> tuple[str, str, int]:
    """Severity, subject and count of the only finding of that code."""
    finding = find(made, code, params, **names)
    return str(finding.severity), finding.subject, finding.count
