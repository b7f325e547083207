"""Of which class each box is, where boxes of several classes count."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np
import pandas as pd

from nvcore.objects import Objects, labels_in_order
from nvcore.schema import NO_LABEL, names_as_categories


def labels_of(counted: Iterable[str], objects: Objects) -> dict[str, str]:
    """The label of each class that counts, by its name; without those that say none.

    Examples
    --------
    >>> from nvcore.objects import SPEED_SIGN
    >>> labels_of(["speed limit 30", "50", "speed limit"], SPEED_SIGN)
    {'speed limit 30': '30', '50': '50'}
    """
    labels = {str(name): objects.label_of(str(name)) for name in counted}
    return {name: label for name, label in labels.items() if label}


def codes_of(kind: Any, label_of: Mapping[str, str]) -> np.ndarray:
    """Place of each row's label among the different values of `label_of`; int32, (n,).

    Parameters
    ----------
    kind
        Class of each row, as text or categories; NO_LABEL where it is not in `label_of`.
    """
    place = {label: number for number, label in enumerate(dict.fromkeys(label_of.values()))}
    names = names_as_categories(kind, len(kind))
    of_name = [place.get(label_of.get(str(name), ""), NO_LABEL) for name in names.categories]
    codes: np.ndarray = np.array([*of_name, NO_LABEL], np.int32)[names.codes]
    return codes


def labelled(
    kind: np.ndarray, is_counted: np.ndarray, objects: Objects
) -> tuple[np.ndarray, tuple[str, ...]]:
    """Label of each row as `Reading` has it, and what the labels are.

    Parameters
    ----------
    kind
        Class of each row, object, shape (n,).
    is_counted
        Whether the row's class counts, bool, shape (n,).
    objects
        In whose words.

    Returns
    -------
    codes, labels
        Places among the labels, int32, (n,); NO_LABEL where the class counts not or says none.
    """
    label_of = labels_of(pd.unique(kind[is_counted]), objects)
    return codes_of(kind, label_of), tuple(dict.fromkeys(label_of.values()))


def merged(parts: Iterable[tuple[str, ...]]) -> tuple[tuple[str, ...], list[np.ndarray]]:
    """The labels of several readings in one list, and the places in it of each reading's.

    Returns
    -------
    labels, places
        Of each reading int32, (its labels + 1,): the last, NO_LABEL, is of boxes without one.
    """
    parts = list(parts)
    labels = labels_in_order(label for part in parts for label in part)
    place = {label: number for number, label in enumerate(labels)}
    return labels, [np.array([*map(place.get, part), NO_LABEL], np.int32) for part in parts]
