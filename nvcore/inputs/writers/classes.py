"""Classes of boxes, by names that the readers take for the same classes again."""

from __future__ import annotations

import numpy as np

from nvcore.errors import InputError
from nvcore.findings import Remedy, Step
from nvcore.inputs.readers.base import Reading
from nvcore.objects import Objects
from nvcore.schema import NO_LABEL

PERSON = "person"
"""COCO's name for pedestrians."""


def class_names(reading: Reading, objects: Objects) -> np.ndarray | None:
    """Name of the class of each box, object, (n,); None: there are not several classes.

    Boxes without a class have the objects' own name, which counts, too.
    """
    if len(reading.labels) < 2:
        return None
    names = [*(_name(label, objects) for label in reading.labels), objects.singular]
    of_box: np.ndarray = np.array(names, object)[_places(reading)]
    return of_box


def categories(reading: Reading, objects: Objects) -> tuple[dict[str, int], np.ndarray]:
    """COCO's categories of the truth: their ids by name, and the id of each box, (n,)."""
    ids = {PERSON if objects.are_pedestrians else objects.singular: 1}
    of_label = []
    for label in reading.labels:
        is_first = label == objects.singular
        of_label.append(1 if is_first else ids.setdefault(_name(label, objects), len(ids) + 1))
    return ids, np.array([*of_label, 1])[_places(reading)]


def category_ids(reading: Reading, truth: Reading | None, objects: Objects) -> list[int | str]:
    """The truth's category of each box of COCO results, (n,); 1 where there is only one class.

    Raises
    ------
    InputError
        If the truth has categories but none for one of the classes; or if there are several
        classes, and the truth is not given.
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
        classes = ", ".join(_name(label, objects) for label in missing)
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


def _name(label: str, objects: Objects) -> str:
    return f"{objects.singular} {label}" if objects.is_numbered else label


def _places(reading: Reading) -> np.ndarray:
    """Place of each box's label; that of boxes without one is the last."""
    label = reading.boxes["label"].to_numpy()
    return np.where(label == NO_LABEL, len(reading.labels), label)
