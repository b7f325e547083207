"""Size of a recording from the sizes of its pictures."""

from __future__ import annotations

from collections.abc import Callable

import pandas as pd

from nvcore.findings import Finding
from nvcore.inputs.readers.base import Role, recordings_table, rows_finding


def recordings_with_sizes(
    pictures: pd.DataFrame, role: Role, place: Callable[[int], tuple[str, str]]
) -> tuple[pd.DataFrame, list[Finding]]:
    """Recordings with the size of their first picture, and pictures of another size.

    Parameters
    ----------
    pictures
        Columns recording, width, height; one row per picture, NaN where not given.
    role
        What the files hold.
    place
        Row -> name of its file, and what to write before its size in the example.
    """
    sides = ["width", "height"]
    sizes = pictures.groupby("recording", sort=False)[sides]
    differs = (pictures[sides] != sizes.transform("first")) & pictures[sides].notna()

    def example(row: int) -> tuple[str, str]:
        file, where = place(row)
        width, height = pictures[sides].iloc[row]
        return file, f"{where}{width:g} x {height:g}"

    first = sizes.first()
    recordings = recordings_table(
        first.index, width=first["width"].to_numpy(), height=first["height"].to_numpy()
    )
    return recordings, rows_finding(
        differs.any(axis=1).to_numpy(),
        "picture-size",
        "Pictures differ in size from the first of their recording, whose size is taken.",
        "Give each size a recording of its own, or scale the boxes to one size.",
        role=role,
        place=example,
    )
