"""Write readings as COCO truth or results, with names of classes that readers know."""

from __future__ import annotations

import json
from collections.abc import Mapping

import numpy as np
import pandas as pd

from nvcore.common.errors import InputError
from nvcore.common.findings import Remedy, Step
from nvcore.dataset.schema import NO_LABEL, NO_TRACK, UNKNOWN_OCCLUSION
from nvcore.inputs.evaluated_frames import own_frames
from nvcore.inputs.readers.base import Reading, Role, image_list
from nvcore.settings.objects import Objects

PERSON = "person"
"""COCO's name for pedestrians."""


def attribute_texts(reading: Reading) -> np.ndarray:
    """Return the attributes of each box, NaN if it has none. Object, shape (n,)."""
    places = reading.boxes[["file", "line"]]
    if reading.attributes is None:
        return np.full(len(places), np.nan, dtype=object)
    texts = places.merge(reading.attributes, how="left", on=["file", "line"])["attributes"]
    return texts.to_numpy(dtype=object)


def coco_bytes(reading: Reading, role: Role, truth: Reading | None, objects: Objects) -> bytes:
    """Serialize a reading as COCO. For `truth` see `nvcore.inputs.writers.write`.

    Raises
    ------
    InputError
        If a box has no finite coordinates, or is in no image or no category of `truth`.
    """
    boxes = reading.boxes
    sides = boxes[["x", "y", "w", "h"]].to_numpy()
    has_gap = ~np.isfinite(sides).all(axis=1)
    if has_gap.any():
        first = boxes[has_gap].iloc[0]
        raise InputError(
            f"COCO cannot hold boxes without finite coordinates; there are {int(has_gap.sum())}, "
            f"the first in frame {first['frame']} of {first['recording']} (line {first['line']}); "
            "mend them, or write csv"
        )
    if role == "truth":
        document: object = _coco_truth(reading, sides, objects)
    else:
        document = _coco_results(reading, sides, truth, objects)
    return (json.dumps(document, allow_nan=False) + "\n").encode()


def _coco_truth(reading: Reading, sides: np.ndarray, objects: Objects) -> dict[str, object]:
    boxes = reading.boxes
    images = _image_list(reading)
    videos = {name: number for number, name in enumerate(images["recording"].unique(), 1)}
    facts = reading.recordings.set_index("name")
    sizes = {name: _facts_of(facts, name, ("width", "height")) for name in videos}
    places = images[["recording", "frame", "image_id"]].itertuples(index=False, name=None)
    entries = [
        {
            "id": image_id,
            "file_name": _file_name(recording, frame),
            "video_id": videos[recording],
            "frame_index": frame,
            **sizes[recording],
        }
        for recording, frame, image_id in places
    ]
    ids = _ids(boxes, images)
    id_of, category = categories(reading, objects)
    columns = {
        "id": np.arange(1, len(boxes) + 1),  # 0 counts as "no match" in COCO's own evaluation
        "image_id": ids,
        "category_id": category,
        "bbox": sides.tolist(),
        "area": sides[:, 2] * sides[:, 3],
        "iscrowd": 0,
        "ignore": boxes["ignore"].astype(int),
        "track_id": _known(boxes["track"], NO_TRACK),
        "distance_m": _known(boxes["distance_m"]),
        "occlusion": _known(boxes["occlusion"], UNKNOWN_OCCLUSION),
        "detectability": _known(boxes["detectability"]),
        "attributes": attribute_texts(reading),
    }
    return {
        "videos": [
            {"id": number, "name": name} | _facts_of(facts, name, ("width", "height", "fps"))
            for name, number in videos.items()
        ],
        "images": entries,
        "annotations": _rows(columns, boxes.index),
        "categories": [{"id": number, "name": name} for name, number in id_of.items()],
    }


def _coco_results(
    reading: Reading, sides: np.ndarray, truth: Reading | None, objects: Objects
) -> list[dict[str, object]]:
    boxes = reading.boxes
    if truth is not None and truth.images is not None:
        key, places = "image_id", _ids(boxes, truth.images)
    else:
        key = "image_filepath"
        names = zip(boxes["recording"].tolist(), boxes["frame"].tolist(), strict=True)
        places = [_file_name(recording, frame) for recording, frame in names]
    columns = {
        key: places,
        "category_id": category_ids(reading, truth, objects),
        "bbox": sides.tolist(),
        "score": _known(boxes["score"]),
        "track_id": _known(boxes["track"], NO_TRACK),
    }
    return _rows(columns, boxes.index)


def _known(column: pd.Series, unknown: int | None = None) -> pd.Series:
    """Replace numbers of a column that are not finite, or equal `unknown`, by None."""
    is_known = np.isfinite(column) if unknown is None else column != unknown
    return column.astype(object).where(is_known, None)


def _rows(columns: Mapping[str, object], index: pd.Index) -> list[dict[str, object]]:
    """Convert columns to one JSON object per row, without missing values."""
    table = pd.DataFrame(columns, index=index).astype(object)
    rows = table.where(table.notna(), None).itertuples(index=False, name=None)
    return [
        {name: value for name, value in zip(columns, row, strict=True) if value is not None}
        for row in rows
    ]


def _image_list(reading: Reading) -> pd.DataFrame:
    """Return the evaluated images, numbered from 1 unless the reading has its own ids."""
    images = reading.images
    if images is None:
        listed_frames = own_frames(reading, reading.recordings["name"])
        images = image_list([*listed_frames], [frames for frames, _ in listed_frames.values()])
    elif not images["image_id"].duplicated().any():
        return images
    return images.assign(image_id=np.arange(1, len(images) + 1))


def _ids(boxes: pd.DataFrame, images: pd.DataFrame) -> list[object]:
    """Return the image id of every box."""
    keys = ["recording", "frame"]
    listed = images[[*keys, "image_id"]].astype({"image_id": object})
    image_id = boxes[keys].merge(listed, how="left", on=keys)["image_id"]
    unknown = image_id.isna().to_numpy()
    if unknown.any():
        first = boxes[unknown].iloc[0]
        raise InputError(
            f"{int(unknown.sum())} boxes are in frames that the image list does not have, the "
            f"first in frame {first['frame']} of {first['recording']}; give the truth "
            "that they belong to"
        )
    return image_id.tolist()


def _file_name(recording: str, frame: int) -> str:
    return f"{recording}/{frame:06d}.png"


def _facts_of(facts: pd.DataFrame, recording: str, names: tuple[str, ...]) -> dict[str, object]:
    """Return the known facts of a recording, with whole numbers as int."""
    if recording not in facts.index:
        return {}
    values = facts.loc[recording, list(names)].to_numpy(dtype=float).tolist()
    return {
        name: int(value) if value.is_integer() else value
        for name, value in zip(names, values, strict=True)
        if np.isfinite(value)
    }


def class_names(reading: Reading, objects: Objects) -> np.ndarray | None:
    """Return the class name of each box, object, (n,), or None unless there are several.

    Boxes without a class get the name of the objects, which counts, too.
    """
    if len(reading.labels) < 2:
        return None
    names = [*(_class_name(label, objects) for label in reading.labels), objects.singular]
    of_box: np.ndarray = np.array(names, object)[_places(reading)]
    return of_box


def categories(reading: Reading, objects: Objects) -> tuple[dict[str, int], np.ndarray]:
    """Return COCO's category ids of the truth by name, and the id of each box, (n,)."""
    ids = {PERSON if objects.are_pedestrians else objects.singular: 1}
    of_label = []
    for label in reading.labels:
        is_first = label == objects.singular
        of_label.append(
            1 if is_first else ids.setdefault(_class_name(label, objects), len(ids) + 1)
        )
    return ids, np.array([*of_label, 1])[_places(reading)]


def category_ids(reading: Reading, truth: Reading | None, objects: Objects) -> list[int | str]:
    """Return the truth's category id of each box of COCO results, or 1 for a single class.

    Raises
    ------
    InputError
        If the truth has categories but none for one of the classes, or if there are several
        classes and the truth is not given.
    """
    ids: dict[str, int | str] = {}
    if truth is not None and truth.numbering == "coco" and truth.categories:
        for key, name in truth.categories.items():
            ids.setdefault(objects.label_of(name), int(key) if key.isdecimal() else key)
    elif truth is not None:
        ids |= {objects.label_of(name): key for name, key in categories(truth, objects)[0].items()}
    missing = [label for label in reading.labels if label not in ids]
    has_categories = truth is not None and truth.numbering == "coco" and len(truth.categories) > 0
    if missing and (has_categories or len(reading.labels) > 1):
        classes = ", ".join(_class_name(label, objects) for label in missing)
        raise InputError(
            "results of COCO number their classes as the truth does: it is needed; or write csv"
            if truth is None
            else f"the truth has no category for {classes}, which results of COCO could name; "
            "write csv",
            steps=(Step(Remedy.OPTION, "", "truth"),) if truth is None else (),
        )
    labels = [*reading.labels, objects.label_of(objects.singular)]
    of_label = np.array([ids.get(label, 1) for label in labels], object)
    of_box: list[int | str] = of_label[_places(reading)].tolist()
    return of_box


def _class_name(label: str, objects: Objects) -> str:
    return f"{objects.singular} {label}" if objects.is_numbered else label


def _places(reading: Reading) -> np.ndarray:
    """Return the index of each box's label, one past the last for boxes without a label."""
    label = reading.boxes["label"].to_numpy()
    return np.where(label == NO_LABEL, len(reading.labels), label)
