"""Model files of the detector: arrays and JSON, checked before anything is computed."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from nvcore.dataset.provenance import TrainedOn
from nvcore.detectors.base import DetectorError
from nvcore.detectors.classifier import MAX_CLASSES, N_VALUES, Classifier
from nvcore.detectors.icf.boosting import Trees
from nvcore.detectors.icf.cascade import Calibration
from nvcore.detectors.icf.features import N_COLUMNS
from nvcore.detectors.icf.model import IcfModel
from nvcore.detectors.icf.regions import EVERYWHERE, Band
from nvcore.detectors.icf.settings import MAX_FEATURES, MAX_TREES, IcfSettings
from nvcore.errors import ParameterError
from nvcore.output.model_files import Array, ModelFormat, check_name

MAX_BYTES: Final = 1 << 26
_GREATEST: Final = 1 << 63
_MOST_WEIGHT: Final = 1e6


@dataclass(frozen=True, kw_only=True)
class _About:
    name: str
    label: str
    settings: Mapping[str, object]
    is_colour: bool
    n_objects: int
    n_background: int
    seed: int
    trained_on: tuple[TrainedOn, ...]
    classes: tuple[str, ...] | None = None

    def __post_init__(self) -> None:
        for name in ("name", "label"):
            check_name(name, getattr(self, name))
        for name in ("n_objects", "n_background", "seed"):
            if not abs(getattr(self, name)) < _GREATEST:
                raise ValueError(f"{name}: expected a number of fewer digits")


FORMAT: Final = ModelFormat(
    name="nvcore-icf",
    version=1,
    what="a detector that nvcore train wrote",
    error=DetectorError,
    about=_About,
    arrays={
        "features": Array("<i4", ("features", N_COLUMNS)),
        "node_feature": Array("<i4", ("n", 3)),
        "node_threshold": Array("<i4", ("n", 3)),
        "leaves": Array("<f8", ("n", 4)),
        "trace": Array("<f8", ("n",)),
        "stage_ends": Array("<i4", ("stages",)),
        "stage_floors": Array("<f8", ("stages",)),
        "powers": Array("<f8", ("channels",), -4, 4),
        "error": Array("<f8", ("errors",)),
        "round_ends": Array("<i4", ("rounds",)),
        "band": Array("<f8", ("band",)),
        "class_weights": Array(
            "<f8", (N_VALUES + 1, "classes"), -_MOST_WEIGHT, _MOST_WEIGHT, is_optional=True
        ),
    },
    longest={
        "n": MAX_TREES,
        "features": MAX_FEATURES,
        "stages": 64,
        "channels": 64,
        "rounds": 20,
        "classes": MAX_CLASSES,
    },
    may_be_empty=frozenset({"band"}),
    max_bytes=MAX_BYTES,
)


def to_bytes(model: IcfModel) -> bytes:
    """Return the model as the content of a file. Equal models give equal bytes."""
    return FORMAT.to_bytes(*_parts(model))


def fingerprint(model: IcfModel) -> str:
    """Return the sha256 of the model and its settings as hexadecimal digits."""
    return FORMAT.fingerprint(*_parts(model))


def read_file(path: Path) -> IcfModel:
    """Read the model in a file.

    Raises
    ------
    DetectorError
        If the file cannot be read, or is no such model.
    """
    return from_bytes(FORMAT.read(path), path.name)


def from_bytes(content: bytes, name: str) -> IcfModel:
    """Return the model that `to_bytes` wrote.

    Parameters
    ----------
    name
        File name for error messages.

    Raises
    ------
    DetectorError
        If it is damaged, or anything in it is not as it must be.
    """
    return FORMAT.parse(content, name, _model)


def _parts(model: IcfModel) -> tuple[_About, dict[str, Any]]:
    """Return the facts and the arrays of a model."""
    classifier = model.classifier
    about = _About(
        name=model.name,
        label=model.label,
        settings=model.settings.as_json(),
        is_colour=model.is_colour,
        n_objects=model.n_objects,
        n_background=model.n_background,
        seed=model.seed,
        trained_on=tuple(model.trained_on),
        classes=None if classifier is None else classifier.classes,
    )
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
        "band": [] if model.band == EVERYWHERE else list(asdict(model.band).values()),
    }
    return about, values if classifier is None else {**values, "class_weights": classifier.weights}


def _model(about: _About, arrays: dict[str, NDArray[Any]]) -> IcfModel:
    try:
        settings = IcfSettings.from_json(about.settings)
    except ParameterError as error:
        raise DetectorError(f"{error}; train the model again") from error
    if len(arrays["band"]) not in (0, 4):
        raise DetectorError("band: expected 4 numbers or none")
    model = IcfModel(
        name=about.name,
        label=about.label,
        settings=settings,
        is_colour=about.is_colour,
        features=arrays["features"],
        trees=Trees(arrays["node_feature"], arrays["node_threshold"], arrays["leaves"]),
        calibration=Calibration(arrays["trace"], arrays["stage_ends"], arrays["stage_floors"]),
        powers=arrays["powers"],
        error=arrays["error"],
        round_ends=arrays["round_ends"],
        n_objects=about.n_objects,
        n_background=about.n_background,
        seed=about.seed,
        band=Band(*arrays["band"].tolist()) if len(arrays["band"]) else EVERYWHERE,
        trained_on=about.trained_on,
        classifier=_classifier(about.classes, arrays.get("class_weights")),
    )
    _check_indices(model)
    return model


def _check_indices(model: IcfModel) -> None:
    """Refuse what would make a loop read outside its arrays."""
    n_channels = len(model.channels)
    settings = model.settings
    if len(model.powers) != n_channels:
        raise DetectorError(f"powers: expected {n_channels} numbers")
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


def _classifier(
    classes: tuple[str, ...] | None, weights: NDArray[np.float64] | None
) -> Classifier | None:
    """Return the classifier, if there is one, whose classes and weights belong together."""
    if classes is None and weights is None:
        return None
    if classes is None or weights is None or len(classes) != weights.shape[1]:
        raise DetectorError("classes: expected a name for each column of class_weights")
    for name in classes:
        check_name("classes", name)
    if len(set(classes)) != len(classes) or len(classes) < 2:
        raise DetectorError("classes: expected two names or more, each once")
    return Classifier(classes, weights)
