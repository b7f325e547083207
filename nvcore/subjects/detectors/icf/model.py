"""Trained model and its file: arrays and JSON, validated when read."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, field, replace
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from nvcore.common.errors import ParameterError
from nvcore.common.output.model_files import Array, ModelFormat, check_name
from nvcore.common.wording import count_text, did_you_mean, listed, one_line
from nvcore.dataset.provenance import TrainedOn
from nvcore.subjects.detectors.base import DetectorError
from nvcore.subjects.detectors.classifier import MAX_CLASSES, N_VALUES, Classifier
from nvcore.subjects.detectors.icf.boosting import Trees
from nvcore.subjects.detectors.icf.cascade import Calibration
from nvcore.subjects.detectors.icf.channels import plane_names
from nvcore.subjects.detectors.icf.features import N_COLUMNS, Features
from nvcore.subjects.detectors.icf.regions import EVERYWHERE, Band
from nvcore.subjects.detectors.icf.settings import MAX_FEATURES, MAX_TREES, OF_A_RUN, IcfSettings

MAX_BYTES: Final = 1 << 26
_GREATEST: Final = 1 << 63
_MOST_WEIGHT: Final = 1e6
_FACTS: Final = ("name", "label", "is_colour", "n_objects", "n_background", "seed")
_ARRAYS: Final = ("features", "powers", "error", "round_ends")
"""Facts and arrays with the same name in the file and in the model."""


@dataclass(frozen=True, eq=False, repr=False)
class IcfModel:
    """Trained ICF model.

    Attributes
    ----------
    name
        Name for people.
    label
        Kind of object in its boxes, such as ``pedestrian``.
    settings
        Settings of the training, also used for runs unless changed.
    is_colour
        Whether the model needs colour pictures. Otherwise it uses grey levels.
    features
        Features that the trees use.
    trees, calibration
        Classifier, and the confidences that objects trained on or held out reach in it.
    powers
        Power of the scale by which each channel changes; float64, (n_channels,).
    band
        Location of the training boxes in the picture.
    error, round_ends
        Training error after each tree, for all rounds one after another, float64, and the end of
        each round in it, int32, (n_rounds,).
    n_objects, n_background
        Numbers of windows in the last round.
    seed
        Random seed of the training.
    trained_on
        Data of the training.
    classifier
        Model that predicts the class of each box. None if there is one kind of object only.
    """

    name: str
    label: str
    settings: IcfSettings
    is_colour: bool
    features: Features
    trees: Trees
    calibration: Calibration
    powers: NDArray[np.float64]
    error: NDArray[np.float64]
    round_ends: NDArray[np.int32]
    n_objects: int
    n_background: int
    seed: int
    band: Band = EVERYWHERE
    trained_on: Sequence[TrainedOn] = field(default=())
    classifier: Classifier | None = None

    @property
    def labels(self) -> tuple[str, ...]:
        """Classes of the boxes, or the one kind of object."""
        return (self.label,) if self.classifier is None else self.classifier.classes

    @property
    def channels(self) -> tuple[str, ...]:
        """Names of the channels that feature indices refer to."""
        return plane_names(self.settings, self.is_colour)

    def __repr__(self) -> str:
        return (
            f"<IcfModel {one_line(self.name)}: {count_text(len(self.trees), 'tree')}, "
            f"{count_text(len(self.features), 'feature')}, detects {one_line(listed(self.labels))}>"
        )

    def windows_in_words(self) -> list[str]:
        """Return lines on the numbers of training windows and the error after each round."""
        lines = [f"windows: {self.n_objects:,} of objects, {self.n_background:,} of background"]
        start = 0
        for number, end in enumerate(self.round_ends.tolist(), 1):
            trees = count_text(end - start, "tree")
            lines.append(f"  round {number}: {trees}, training error {self.error[end - 1]:.2%}")
            start = end
        return lines

    def run_with(self, **changes: Any) -> IcfModel:
        """Return the same model with other run settings.

        Raises
        ------
        ParameterError
            If a setting is not one of a run (`OF_A_RUN`), or its value is not possible. For
            example, models of grey pictures have no red regions.
        """
        known, odd = listed(sorted(OF_A_RUN)), sorted(set(changes) - OF_A_RUN)
        fixed = [name for name in odd if hasattr(self.settings, name)]
        if fixed:
            raise ParameterError(
                f"{listed(fixed)}: fixed by the training; of a run there are {known}"
            )
        if odd:
            hint = did_you_mean(odd[0], sorted(OF_A_RUN), f"of a run there are {known}")
            raise ParameterError(f"there is no setting {odd[0]!r}; {hint}")
        if changes.get("proposals") == "red" and not self.is_colour:
            raise ParameterError(
                "proposals: red is of pictures in colour, and the model was trained on grey ones; "
                "expected none"
            )
        return replace(self, settings=replace(self.settings, **changes))


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
    """Serialize the model. Equal models give equal bytes."""
    return FORMAT.to_bytes(*_parts(model))


def fingerprint(model: IcfModel) -> str:
    """Return the sha256 of the model and its settings as hexadecimal digits."""
    return FORMAT.fingerprint(*_parts(model))


def from_bytes(content: bytes, name: str) -> IcfModel:
    """Parse and validate the content of a model file, as written by `to_bytes`.

    Parameters
    ----------
    name
        File name for error messages.

    Raises
    ------
    DetectorError
        If the content is damaged or invalid.
    """
    return FORMAT.parse(content, name, _model)


def _parts(model: IcfModel) -> tuple[_About, dict[str, Any]]:
    """Return the facts and the arrays of a model."""
    classifier = model.classifier
    about = _About(
        **{name: getattr(model, name) for name in _FACTS},
        settings=model.settings.as_json(),
        trained_on=tuple(model.trained_on),
        classes=None if classifier is None else classifier.classes,
    )
    values = {
        **{name: getattr(model, name) for name in _ARRAYS},
        "node_feature": model.trees.feature,
        "node_threshold": model.trees.threshold,
        "leaves": model.trees.leaves,
        "trace": model.calibration.trace,
        "stage_ends": model.calibration.stage_ends,
        "stage_floors": model.calibration.stage_floors,
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
    same: dict[str, Any] = {name: getattr(about, name) for name in (*_FACTS, "trained_on")}
    model = IcfModel(
        **same | {name: arrays[name] for name in _ARRAYS},
        settings=settings,
        trees=Trees(arrays["node_feature"], arrays["node_threshold"], arrays["leaves"]),
        calibration=Calibration(arrays["trace"], arrays["stage_ends"], arrays["stage_floors"]),
        band=Band(*arrays["band"].tolist()) if len(arrays["band"]) else EVERYWHERE,
        classifier=_classifier(about.classes, arrays.get("class_weights")),
    )
    _check_indices(model)
    return model


def _check_indices(model: IcfModel) -> None:
    """Reject indices that would make a loop read outside its arrays."""
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
    """Return the classifier, if any, after checking that its classes and weights match."""
    if classes is None and weights is None:
        return None
    if classes is None or weights is None or len(classes) != weights.shape[1]:
        raise DetectorError("classes: expected a name for each column of class_weights")
    for name in classes:
        check_name("classes", name)
    if len(set(classes)) != len(classes) or len(classes) < 2:
        raise DetectorError("classes: expected two names or more, each once")
    return Classifier(classes, weights)
