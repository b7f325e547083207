"""Model files of estimators: arrays and JSON, validated when read."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass, fields
from os import PathLike, fspath
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from nvcore.common.errors import EstimatorError
from nvcore.common.output.files import write_whole
from nvcore.common.output.model_files import (
    Array,
    BadModelError,
    ModelFormat,
    check_name,
    format_of,
)
from nvcore.common.records import decode
from nvcore.subjects.driver.estimators.model import (
    KERNELS,
    N_FEATURES,
    Estimator,
    Origin,
    Quality,
    Regression,
    SvrSettings,
)
from nvcore.subjects.driver.features import FEATURE_KEYS, FeatureSettings
from nvcore.subjects.driver.features.feature_record import SETTINGS, picture_px_from_json
from nvcore.subjects.driver.inputs.record import SEARCHES
from nvcore.subjects.driver.inputs.study_tables import LARGEST

SAMPLE_ESTIMATOR: Final = Path(__file__).with_name("models") / "sample.npz"
"""Estimator of the sample's simulated observer. Written by scripts/train_sample_driver.py."""
SAMPLE_NAME: Final = "sample"
"""Name of the sample estimator where a file is expected."""
MAX_BYTES: Final = 1 << 24
_SCALE: Final = Array("<f8", ("regressions", N_FEATURES), 1e-12, LARGEST)
_ROUNDING: Final = 1e-9
_OF_REGRESSIONS: Final = ("centre", "scale", "low", "high")
_OF_SETTINGS: Final = ("cost", "epsilon", "gamma")
_OF_QUALITIES: Final = ("n_rows", "error", "constant", "constant_error")
_GREATEST: Final = 2**32
"""Maximum of the counts about the training."""


@dataclass(frozen=True, kw_only=True)
class _About:
    name: str
    features: tuple[str, ...]
    origin: Mapping[str, object]
    feature_settings: Mapping[str, object] | None = None

    def __post_init__(self) -> None:
        check_name("name", self.name)
        if self.features != FEATURE_KEYS:
            raise ValueError("features: expected those of this program; train the model again")


_PER_REGRESSION: Final = ("regressions",)
_PER_FEATURE: Final = ("regressions", N_FEATURES)

FORMAT: Final = ModelFormat(
    name="nvcore-driver",
    version=1,
    what="an estimator that nvcore driver train wrote",
    error=EstimatorError,
    about=_About,
    # ranges: at least what training can write; within them no computed value is infinite
    arrays={
        "periods_s": Array("<f8", ("periods",), 0, 3660),  # of trials and the display of a picture
        "is_used": Array("|u1", _PER_FEATURE, 0, 1),
        "centre": Array("<f8", _PER_FEATURE, -LARGEST, LARGEST),
        "scale": Array("<f8", _PER_FEATURE, -np.inf, np.inf),  # of features in use within _SCALE
        "low": Array("<f8", _PER_FEATURE, -LARGEST, LARGEST),
        "high": Array("<f8", _PER_FEATURE, -LARGEST, LARGEST),
        "kernel": Array("|u1", _PER_REGRESSION, 0, 255),
        "cost": Array("<f8", _PER_REGRESSION, 0, 1000),
        "epsilon": Array("<f8", _PER_REGRESSION, 0, 1),
        "gamma": Array("<f8", _PER_REGRESSION, 0, 1000),
        "offset": Array("<f8", _PER_REGRESSION, -LARGEST, LARGEST),
        "vector_ends": Array("<i4", _PER_REGRESSION, -(2**31), 2**31 - 1),
        "vectors": Array("<f8", ("vectors", N_FEATURES), -1000, 1000),  # standard deviations
        "weights": Array("<f8", ("vectors",)),
        "n_rows": Array("<i4", _PER_REGRESSION, 1, 1_000_000),
        "error": Array("<f8", _PER_REGRESSION, 0, 1),
        "constant": Array("<f8", _PER_REGRESSION, 0, 1),
        "constant_error": Array("<f8", _PER_REGRESSION, 0, 1),
    },
    longest={"periods": 1000, "regressions": 1001, "vectors": 200_000},
    may_be_empty=frozenset({"vectors"}),
    max_bytes=MAX_BYTES,
)
"""The regression for all periods is the last one. Unused features have 0 in their columns."""


def write_estimator(estimator: Estimator, path: Path) -> None:
    """Write a model file.

    Raises
    ------
    InputError
        If the file cannot be written.
    """
    write_whole(path, to_bytes(estimator))


def estimator_path(model: str | PathLike[str]) -> Path:
    """Return the path of an estimator. ``sample`` is the one of the package."""
    return SAMPLE_ESTIMATOR if fspath(model) == SAMPLE_NAME else Path(model)


def is_estimator_file(path: str | PathLike[str]) -> bool:
    """Return True if a file claims to be an estimator, even one that cannot be used."""
    try:
        return format_of(FORMAT.read(Path(path))) == FORMAT.name
    except (EstimatorError, ValueError):  # missing file, folder, or NUL in the name
        return False


def read_estimator(path: Path) -> Estimator:
    """Read the estimator in a file.

    Raises
    ------
    EstimatorError
        If the file cannot be read, or is not such a model.
    """
    try:
        content = FORMAT.read(path)
    except EstimatorError as error:
        if not isinstance(error.__cause__, FileNotFoundError):
            raise
        raise EstimatorError(
            f"there is no such file; expected {FORMAT.what}, or {SAMPLE_NAME}: that of the "
            "sample's simulated observer",
            file=path.name,
        ) from error
    return from_bytes(content, path.name)


def to_bytes(estimator: Estimator) -> bytes:
    """Serialize the estimator. Equal estimators give equal bytes."""
    return FORMAT.to_bytes(*_parts(estimator))


def fingerprint(estimator: Estimator) -> str:
    """Return the sha256 of the estimator as hexadecimal digits."""
    return FORMAT.fingerprint(*_parts(estimator))


def from_bytes(content: bytes, name: str) -> Estimator:
    """Parse and validate the content of an estimator file, as written by `to_bytes`.

    Parameters
    ----------
    name
        File name for error messages.

    Raises
    ------
    EstimatorError
        If the content is damaged or invalid.
    """
    try:
        return FORMAT.parse(content, name, _estimator)
    except EstimatorError as error:
        is_network = name.lower().endswith(".onnx")
        hint = "; networks (.onnx) are for nvcore detect" if is_network else ""
        raise EstimatorError(f"{error.message}{hint}", file=name) from error


def _parts(estimator: Estimator) -> tuple[_About, dict[str, Any]]:
    """Return the facts and the arrays of an estimator."""
    regressions = estimator.regressions
    values: dict[str, Any] = {
        "periods_s": estimator.periods_s,
        "is_used": np.zeros((len(regressions), N_FEATURES)),
        "vectors": np.zeros((sum(len(part.weights) for part in regressions), N_FEATURES)),
        "weights": np.concatenate([part.weights for part in regressions]),
        "vector_ends": np.cumsum([len(part.weights) for part in regressions]),
        "offset": [part.offset for part in regressions],
        "kernel": [KERNELS.index(part.settings.kernel) for part in regressions],
    }
    for name in _OF_REGRESSIONS:
        values[name] = np.zeros((len(regressions), N_FEATURES))
    for name in _OF_SETTINGS:
        values[name] = [getattr(part.settings, name) for part in regressions]
    for name in _OF_QUALITIES:
        values[name] = [getattr(quality, name) for quality in estimator.qualities]
    for row, (part, end) in enumerate(zip(regressions, values["vector_ends"], strict=True)):
        values["is_used"][row, part.columns] = 1
        values["vectors"][end - len(part.weights) : end, part.columns] = part.vectors
        for name in _OF_REGRESSIONS:
            values[name][row, part.columns] = getattr(part, name)
    features = estimator.feature_settings
    about = _About(
        name=estimator.name,
        features=FEATURE_KEYS,
        origin=estimator.origin.as_json(),
        feature_settings=None
        if features is None
        else {name: float(value) for name, value in asdict(features).items()},
    )
    return about, values


def _estimator(about: _About, arrays: dict[str, NDArray[Any]]) -> Estimator:
    _check_values(arrays)
    features = about.feature_settings
    n_regressions = len(arrays["offset"])
    return Estimator(
        name=about.name,
        periods_s=arrays["periods_s"],
        regressions=tuple(_regression(arrays, row) for row in range(n_regressions)),
        qualities=tuple(
            Quality(**{name: arrays[name][row].item() for name in _OF_QUALITIES})
            for row in range(n_regressions)
        ),
        origin=_origin(about.origin),
        feature_settings=None
        if features is None
        else decode(FeatureSettings, features, SETTINGS, complete=True),
    )


def _check_values(arrays: Mapping[str, NDArray[Any]]) -> None:
    """Reject numbers with which nothing can be estimated."""
    periods, is_used, ends = arrays["periods_s"], arrays["is_used"], arrays["vector_ends"]
    if len(is_used) != len(periods) + 1:
        raise BadModelError("expected a regression for each period, and one for all")
    if periods[0] < 0 or (np.diff(periods) <= 0).any():
        raise BadModelError("periods_s: expected ascending numbers of 0 or more")
    if not is_used.any(axis=1).all():
        raise BadModelError("is_used: expected a feature for each regression")
    if (np.diff(ends, prepend=0) < 0).any() or ends[-1] != len(arrays["weights"]):
        raise BadModelError("vector_ends: expected ascending numbers up to those of vectors")
    if arrays["kernel"].max() >= len(KERNELS):
        raise BadModelError("kernel: expected 0 or 1")
    _SCALE.check_values("scale", arrays["scale"][is_used == 1])
    centre = arrays["centre"]
    slack = _ROUNDING * np.maximum(np.abs(centre), 1.0)
    if (arrays["low"] > centre + slack).any() or (arrays["high"] < centre - slack).any():
        raise BadModelError("low, centre, high: expected them in this order")
    most = np.repeat(arrays["cost"], np.diff(arrays["vector_ends"], prepend=0))
    if (np.abs(arrays["weights"]) > most * (1 + _ROUNDING)).any():
        raise BadModelError("weights: expected no more than the cost, without the sign")


def _regression(arrays: Mapping[str, NDArray[Any]], row: int) -> Regression:
    columns = np.flatnonzero(arrays["is_used"][row])
    start, end = np.append(0, arrays["vector_ends"])[row : row + 2]
    settings = {name: float(arrays[name][row]) for name in _OF_SETTINGS}
    return Regression(
        columns=columns,
        **{name: arrays[name][row, columns] for name in _OF_REGRESSIONS},
        vectors=np.ascontiguousarray(arrays["vectors"][start:end, columns]),
        weights=arrays["weights"][start:end],
        offset=float(arrays["offset"][row]),
        settings=SvrSettings(KERNELS[int(arrays["kernel"][row])], **settings),
    )


def _origin(content: Mapping[str, object]) -> Origin:
    origin = decode(Origin, content, "origin")
    if origin.simulated not in ("no", "all", "some"):
        raise BadModelError("simulated: expected no, all or some")
    if origin.search not in SEARCHES:
        raise BadModelError("search: expected quick, or none")
    for spec in fields(Origin):
        value = getattr(origin, spec.name)
        if isinstance(value, int | float) and not 0 <= value <= _GREATEST:
            raise BadModelError(f"{spec.name}: expected 0 to {_GREATEST}, got {value!r:.80}")
    picture_px_from_json(origin.picture_px)
    return origin
