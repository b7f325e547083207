"""Models as files: `.npz` of plain arrays and a block of JSON, never pickle."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from nvcore.dataset.provenance import trained_on_from
from nvcore.detectors.base import DetectorError
from nvcore.detectors.classifier import MAX_CLASSES, N_VALUES, Classifier
from nvcore.detectors.icf.boosting import Trees
from nvcore.detectors.icf.cascade import Calibration
from nvcore.detectors.icf.features import N_COLUMNS
from nvcore.detectors.icf.model import IcfModel
from nvcore.detectors.icf.regions import EVERYWHERE, Band
from nvcore.detectors.icf.settings import MAX_FEATURES, MAX_TREES, IcfSettings
from nvcore.errors import ParameterError
from nvcore.output import arrays as archives
from nvcore.output.arrays import BadArchiveError

FORMAT: Final = "nvcore-icf"
VERSION: Final = 1
MAX_BYTES: Final = 1 << 26
"""Size of a model file, and of all that is in it."""
_WHAT: Final = "a detector that nvcore train wrote"
_MOST: Final = {
    "n": MAX_TREES,
    "features": MAX_FEATURES,
    "stages": 64,
    "channels": 64,
    "rounds": 20,
    "classes": MAX_CLASSES,
}
_ARRAYS: Final[dict[str, tuple[str, tuple[str | int, ...]]]] = {
    "features": ("<i4", ("features", N_COLUMNS)),
    "node_feature": ("<i4", ("n", 3)),
    "node_threshold": ("<i4", ("n", 3)),
    "leaves": ("<f8", ("n", 4)),
    "trace": ("<f8", ("n",)),
    "stage_ends": ("<i4", ("stages",)),
    "stage_floors": ("<f8", ("stages",)),
    "powers": ("<f8", ("channels",)),
    "error": ("<f8", ("errors",)),
    "round_ends": ("<i4", ("rounds",)),
    "band": ("<f8", ("band",)),
    "class_weights": ("<f8", (N_VALUES + 1, "classes")),
}
"""Type and shape of each array; equal words are equal lengths."""
_OF_CLASSES: Final = "class_weights"
"""Only in models with a classifier."""
_MOST_WEIGHT: Final = 1e6
_FACTS: Final[dict[str, type]] = {
    "format": str,
    "version": int,
    "name": str,
    "label": str,
    "settings": dict,
    "is_colour": bool,
    "n_objects": int,
    "n_background": int,
    "seed": int,
    "trained_on": list,
}
_GREATEST: Final = 1 << 63
LONGEST_NAME: Final = 200
"""Of a model, and of what it detects."""


def to_bytes(model: IcfModel) -> bytes:
    """The model as the content of a file; equal models give equal bytes."""
    return archives.pack(_members(model))


def fingerprint(model: IcfModel) -> str:
    """sha256 over the model and its settings, as hexadecimal digits."""
    return archives.fingerprint_of(_members(model))


def read_file(path: Path) -> IcfModel:
    """The model in a file.

    Raises
    ------
    DetectorError
        If the file cannot be read, or is no such model.
    """
    try:
        with path.open("rb") as file:
            content = file.read(MAX_BYTES + 1)
    except OSError as error:
        raise DetectorError(f"cannot be opened ({error.strerror})", file=path.name) from error
    return from_bytes(content, path.name)


def from_bytes(content: bytes, name: str) -> IcfModel:
    """The model that `to_bytes` wrote.

    Parameters
    ----------
    name
        Of the file, for errors.

    Raises
    ------
    DetectorError
        If it is damaged, or anything in it is not as it must be.
    """
    try:
        with archives.damage_of(_WHAT):
            about, arrays = archives.unpack(
                content, _ARRAYS, what=_WHAT, most_bytes=MAX_BYTES, optional=(_OF_CLASSES,)
            )
            return _checked(about, arrays)
    except (BadArchiveError, DetectorError) as error:
        text = error.message if isinstance(error, DetectorError) else str(error)
        raise DetectorError(text, file=name) from error
    except ParameterError as error:
        raise DetectorError(f"{error}; train the model again", file=name) from error


def _members(model: IcfModel) -> dict[str, NDArray[Any]]:
    """Everything of a model, as arrays by name."""
    band = [] if model.band == EVERYWHERE else list(asdict(model.band).values())
    values = {
        "features": model.features,
        "node_feature": model.trees.feature,
        "node_threshold": model.trees.threshold,
        "leaves": model.trees.leaves,
        "trace": model.calibration.trace,
        "stage_ends": model.calibration.stage_ends,
        "stage_floors": model.calibration.stage_floors,
        "powers": model.powers,
        "error": model.error,
        "round_ends": model.round_ends,
        "band": np.array(band),
    }
    if model.classifier is not None:
        values[_OF_CLASSES] = model.classifier.weights
    about = {
        "format": FORMAT,
        "version": VERSION,
        "name": model.name,
        "label": model.label,
        "settings": model.settings.as_json(),
        "is_colour": model.is_colour,
        "n_objects": model.n_objects,
        "n_background": model.n_background,
        "seed": model.seed,
        "trained_on": [asdict(part) for part in model.trained_on],
    }
    if model.classifier is not None:
        about["classes"] = list(model.classifier.classes)
    return archives.members_of(about, values, _ARRAYS)


def _checked(about: Mapping[str, Any], arrays: dict[str, NDArray[Any]]) -> IcfModel:
    archives.check_version(about, FORMAT, VERSION, what=_WHAT)
    archives.check_facts(about, _FACTS)
    for name, kind in _FACTS.items():
        if kind is int and not abs(about[name]) < _GREATEST:
            raise DetectorError(f"{name}: expected a number of fewer digits")
    for name in ("name", "label"):
        archives.check_name(about, name, LONGEST_NAME)
    settings = IcfSettings.from_json(about["settings"])
    archives.check_lengths(arrays, _ARRAYS, _MOST, may_be_empty=("band",))
    if len(arrays["band"]) not in (0, 4):
        raise DetectorError("band: expected 4 numbers or none")
    band = Band(*arrays["band"].tolist()) if len(arrays["band"]) else EVERYWHERE
    model = IcfModel(
        name=about["name"],
        label=about["label"],
        settings=settings,
        is_colour=about["is_colour"],
        features=arrays["features"],
        trees=Trees(arrays["node_feature"], arrays["node_threshold"], arrays["leaves"]),
        calibration=Calibration(arrays["trace"], arrays["stage_ends"], arrays["stage_floors"]),
        powers=arrays["powers"],
        error=arrays["error"],
        round_ends=arrays["round_ends"],
        n_objects=about["n_objects"],
        n_background=about["n_background"],
        seed=about["seed"],
        band=band,
        trained_on=trained_on_from(about["trained_on"]),
        classifier=_classifier(about.get("classes"), arrays.get(_OF_CLASSES)),
    )
    _check_indices(model)
    return model


def _check_indices(model: IcfModel) -> None:
    """Refuse what would make a loop read outside its arrays."""
    n_channels = len(model.channels)
    settings = model.settings
    if len(model.powers) != n_channels or np.abs(model.powers).max() > 4:
        raise DetectorError(f"powers: expected {n_channels} numbers from -4 to 4")
    feature = model.trees.feature
    if feature.min() < 0 or feature.max() >= len(model.features):
        raise DetectorError("node_feature names a feature that is not there")
    for half in (0, 1):
        channel, left, top, right, bottom = model.features[:, 5 * half : 5 * half + 5].T
        is_inside = (channel >= 0) & (channel < n_channels)
        is_inside &= (left >= 0) & (left < right) & (right <= settings.window_width)
        is_inside &= (top >= 0) & (top < bottom) & (bottom <= settings.window_height)
        if half:
            is_inside |= (model.features[:, 5:] == -1).all(axis=1)
        if not is_inside.all():
            raise DetectorError("features: a rectangle does not lie within the window")
    for name, ends, last in (
        ("stage_ends", model.calibration.stage_ends, len(model.trees)),
        ("round_ends", model.round_ends, len(model.error)),
    ):
        if (np.diff(ends, prepend=0) < 1).any() or ends[-1] != last:
            raise DetectorError(f"{name}: expected ascending numbers up to {last}")


def _classifier(classes: object, weights: NDArray[np.float64] | None) -> Classifier | None:
    """The classifier, if there is one: its classes and their weights belong together."""
    if classes is None and weights is None:
        return None
    if weights is None or not isinstance(classes, list) or len(classes) != weights.shape[1]:
        raise DetectorError("classes: expected a name for each column of class_weights")
    are_names = all(
        isinstance(name, str) and 0 < len(name) <= LONGEST_NAME and name.isprintable()
        for name in classes
    )
    if not are_names or len(set(classes)) != len(classes) or len(classes) < 2:
        raise DetectorError("classes: expected two names or more, each once")
    if np.abs(weights).max() > _MOST_WEIGHT:
        raise DetectorError(f"class_weights: expected numbers up to {_MOST_WEIGHT:g}")
    return Classifier(tuple(classes), weights)
