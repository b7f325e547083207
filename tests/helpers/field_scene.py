"""A scene to be written as other tools write it, and what a comparison of it has to find.

40 frames of 640 x 480 px at 10 Hz: three pedestrians (110 boxes), two cars, a bicycle. X and Y
detect all the vehicles, X the first pedestrian always and the third late, Y the first one late;
Y has six false alarms where nobody is. Boxes of detections lie within two pixels of the truth's.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import cache
from pathlib import Path
from types import MappingProxyType
from typing import Any, Final

import numpy as np
import pandas as pd

from nvcore.comparison.compare import Result

N_FRAMES: Final = 40
SIZE: Final = (640, 480)
FPS: Final = 10
PERSON: Final = "person"

_OBJECTS: Final = (
    # name, track, first frame, box at frame 0, its change from frame to frame
    (PERSON, 1, 0, (60, 180, 50, 130), (6, -1, 1, 2)),
    (PERSON, 2, 0, (420, 200, 36, 96), (-3, 0, 0, 0)),
    (PERSON, 3, 10, (300, 190, 40, 110), (2, 0, 0, 0)),
    ("car", 4, 0, (20, 320, 160, 90), (2, 0, 0, 0)),
    ("car", 5, 0, (460, 300, 150, 100), (0, 1, 0, 0)),
    ("bicycle", 6, 0, (560, 230, 60, 70), (-4, 0, 0, 0)),
)
_FIRST_DETECTED: Final[Mapping[str, Mapping[int, int]]] = {"x": {2: 40, 3: 20}, "y": {1: 8}}


def truth() -> pd.DataFrame:
    """Rows frame, name, track, x, y, w, h (0-based px), in the order of frames."""
    return _truth().copy()


def detections(system: str) -> pd.DataFrame:
    """Rows frame, name, x, y, w, h, score of the system ``x`` or ``y``."""
    return _detections(system).copy()


@cache
def _truth() -> pd.DataFrame:
    rows = [
        (
            frame,
            name,
            track,
            *(start + frame * step for start, step in zip(box, steps, strict=True)),
        )
        for name, track, first, box, steps in _OBJECTS
        for frame in range(first, N_FRAMES)
    ]
    table = pd.DataFrame(rows, columns=["frame", "name", "track", *"xywh"])
    return table.sort_values(["frame", "track"], ignore_index=True)


@cache
def _detections(system: str) -> pd.DataFrame:
    table = truth()
    first = table["track"].map(_FIRST_DETECTED[system]).fillna(0)
    table = table[table["frame"] >= first].drop(columns="track")
    if system == "y":
        alarms = [(frame, PERSON, 200, 20, 30, 80) for frame in range(0, 30, 5)]
        table = pd.concat([table, pd.DataFrame(alarms, columns=table.columns)])
    table = table.sort_values("frame", kind="stable", ignore_index=True)
    rng = np.random.default_rng(["x", "y"].index(system))
    moved = table[[*"xywh"]] + rng.uniform(-1.5, 1.5, (len(table), 4))
    table = table.astype(dict.fromkeys("xywh", float))
    table[[*"xywh"]] = moved.round(2)
    return table.assign(score=rng.uniform(0.55, 0.98, len(table)).round(3))


def found(result: Result) -> dict[str, Any]:
    """What a comparison found: boxes matched, false alarms and encounters detected, of X and Y."""
    systems, venn = (result.x, result.y), result.venn
    return {
        "matched": tuple(int(system.matches.is_matched.sum()) for system in systems),
        "false_alarms": tuple(int(system.matches.is_false_alarm.sum()) for system in systems),
        "encounters": (venn.both + venn.x_only, venn.both + venn.y_only),
    }


RIGHT: Final = {"matched": (60, 102), "false_alarms": (0, 6), "encounters": (2, 3)}
"""What `found` gives where the files are read as their makers meant them."""


def write_yolo(
    folder: Path,
    side: str,
    name_of: Callable[[int], str],
    ids: Mapping[str, int] = MappingProxyType({PERSON: 0}),
) -> Path:
    """Boxes of ``truth``, ``x`` or ``y`` as YOLO text, a file a frame, named by `name_of`.

    Those of the classes in `ids`, by which they are numbered.
    """
    folder.mkdir(parents=True, exist_ok=True)
    for frame, text in enumerate(_yolo_texts(side, tuple(ids.items()))):
        (folder / name_of(frame)).write_text(text)
    return folder


@cache
def _yolo_texts(side: str, ids: tuple[tuple[str, int], ...]) -> list[str]:
    number_of = dict(ids)
    table = truth() if side == "truth" else detections(side)
    table = table[table["name"].isin([*number_of])]
    table = table.reindex(columns=["frame", "name", *"xywh", "score"])
    width, height = SIZE
    lines: list[list[str]] = [[] for _ in range(N_FRAMES)]
    for frame, name, x, y, w, h, score in table.itertuples(index=False):
        lines[frame].append(
            f"{number_of[name]} {(x + w / 2) / width:.6f} {(y + h / 2) / height:.6f} "
            f"{w / width:.6f} {h / height:.6f}" + ("" if side == "truth" else f" {score:.3f}")
        )
    return ["\n".join(texts) for texts in lines]


_COCO_IDS: Final = MappingProxyType({PERSON: 1, "car": 2, "bicycle": 3})


def coco_truth(
    name_of: Callable[[int], str], *, first_id: int = 1, ids: Mapping[str, int] = _COCO_IDS
) -> dict[str, Any]:
    """The truth as COCO, with these category ids; ids of images count from `first_id`."""
    rows = truth().itertuples(index=False)
    size = dict(zip(("width", "height"), SIZE, strict=True))
    return {
        "images": [
            {"id": frame + first_id, "file_name": name_of(frame), **size}
            for frame in range(N_FRAMES)
        ],
        "annotations": [
            {
                "id": number,
                "image_id": frame + first_id,
                "category_id": ids[name],
                "track_id": track,
                "bbox": box,
            }
            for number, (frame, name, track, *box) in enumerate(rows, 1)
        ],
        "categories": [{"id": key, "name": name} for name, key in ids.items()],
    }


def coco_results(
    system: str,
    of_frame: Callable[[int], Mapping[str, Any]],
    ids: Mapping[str, int] = MappingProxyType({PERSON: 1}),
) -> list[dict[str, Any]]:
    """Detections as COCO results; `of_frame` gives what they say of their picture.

    Those of the classes in `ids`, by which they are numbered.
    """
    rows = detections(system).itertuples(index=False)
    return [
        {**of_frame(frame), "category_id": ids[name], "bbox": box, "score": score}
        for frame, name, *box, score in rows
        if name in ids
    ]
