"""The scene of `field_scene` as CSV files, boxes written in any layout, and a session of them."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pandas as pd
from field_scene import FPS, PERSON, SIZE, detections, truth

from nvcore.inputs.box_layouts import parse_layout
from nvcore.inputs.session import Session, Source, SystemSource


def written(folder: Path, name: str, table: pd.DataFrame, layout: str) -> str:
    """The pedestrians of a table as CSV without names for the numbers' meaning; its file."""
    table = table[table["name"] == PERSON]
    whole = tuple(np.full(len(table), float(side)) for side in SIZE * 2)
    box = tuple(table[column].to_numpy(float) for column in "xywh")
    numbers = parse_layout(layout).numbers(box, np.zeros(len(table)), whole)
    columns = {"frame": table["frame"], **dict(zip("xywh", numbers, strict=False))}
    others = {name: table[name] for name in ("track", "score") if name in table}
    pd.DataFrame({**columns, **others}).to_csv(folder / f"{name}.csv", index=False)
    return f"{name}.csv"


def session_of(folder: Path, **layouts: str) -> Session:
    """The scene, its sources written in these layouts and read as left, top, width, height."""
    tables = {"truth": truth(), "x": detections("x"), "y": detections("y")}
    files = {
        name: written(folder, name, table, layouts.get(name, "sizes"))
        for name, table in tables.items()
    }
    return Session(
        folder=folder,
        truth=Source(files["truth"]),
        systems=tuple(SystemSource(files[name], name=name) for name in "xy"),
        size=SIZE,
        fps=FPS,
    )
