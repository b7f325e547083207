"""Readings written as MOTChallenge text, a file for each recording."""

from __future__ import annotations

from pathlib import Path
from typing import Final

import numpy as np
import pandas as pd

from nvcore.inputs.readers.base import Reading, Role
from nvcore.inputs.writers.names import safe_names
from nvcore.output.csv_text import to_csv_bytes
from nvcore.schema import UNKNOWN_OCCLUSION

VISIBLE_SHARE: Final = {0: 1.0, 1: 0.8, 2: 0.4, UNKNOWN_OCCLUSION: -1.0}
"""MOTChallenge's visibility for each level of occlusion, read back as the same level."""


def mot_files(reading: Reading, path: Path, role: Role) -> dict[Path, bytes]:
    """A reading as a file, or of several recordings as one for each in the folder `path`."""
    boxes = reading.boxes
    columns: dict[str, object] = {
        "frame": boxes["frame"],
        "id": boxes["track"],
        "left": boxes["x"] + 1,
        "top": boxes["y"] + 1,
        "width": boxes["w"],
        "height": boxes["h"],
    }
    if role == "truth":
        columns["conf"] = (~boxes["ignore"]).astype(np.int64)
        columns["class"] = 1
        columns["visibility"] = boxes["occlusion"].map(VISIBLE_SHARE)
    else:
        has_scores = bool(boxes["score"].notna().any())
        columns["conf"] = boxes["score"] if has_scores else -1
        columns |= {"x": -1, "y": -1, "z": -1}
    table = pd.DataFrame(columns, index=boxes.index)
    names = reading.recordings["name"].tolist()
    parts = {path: table}
    if len(names) > 1:
        parts = {
            path / f"{file_name}.txt": table[(boxes["recording"] == name).to_numpy()]
            for name, file_name in zip(names, safe_names(names), strict=True)
        }
    return {
        target: to_csv_bytes(part, digits=None, header=False, missing="nan")
        for target, part in parts.items()
    }
