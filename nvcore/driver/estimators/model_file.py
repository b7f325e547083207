"""Estimators as files: ``.npz`` of plain arrays and a block of JSON, never pickle."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict
from os import PathLike, fspath
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from nvcore.driver.estimators.model import (
    KERNELS,
    N_FEATURES,
    Estimator,
    Origin,
    Quality,
    Regression,
    SvrSettings,
)
from nvcore.driver.feature_record import picture_px_from_json, settings_from_json
from nvcore.driver.features import FEATURE_KEYS, FeatureSettings
from nvcore.driver.inputs.picture_boxes import LARGEST
from nvcore.driver.inputs.record import SEARCHES
from nvcore.errors import EstimatorError
from nvcore.output import arrays as archives
from nvcore.output.arrays import BadArchiveError, Kinds
from nvcore.output.files import write_whole

FORMAT: Final = "nvcore-driver"
VERSION: Final = 1
MAX_BYTES: Final = 1 << 24
"""Size of a model file, and of all that is in it."""
LONGEST_NAME: Final = 200
SAMPLE_ESTIMATOR: Final = Path(__file__).parents[1] / "models" / "sample.npz"
"""Of the sample's simulated observer; written by scripts/train_sample_driver.py."""
SAMPLE_NAME: Final = "sample"
"""What that one is called where a file is asked for."""
_WHAT: Final = "an estimator that nvcore driver train wrote"
_MOST: Final = {"periods": 1000, "regressions": 1001, "vectors": 200_000}
_RANGES: Final = {
    "periods_s": (0.0, 3660.0),  # of trials and the display of a picture
    "centre": (-LARGEST, LARGEST),
    "low": (-LARGEST, LARGEST),
    "high": (-LARGEST, LARGEST),
    "cost": (0.0, 1000.0),
    "epsilon": (0.0, 1.0),
    "gamma": (0.0, 1000.0),
    "offset": (-LARGEST, LARGEST),
    "vectors": (-1000.0, 1000.0),  # standard deviations: the root of a million rows
    "n_rows": (1, 1_000_000),
    "error": (0.0, 1.0),
    "constant": (0.0, 1.0),
    "constant_error": (0.0, 1.0),
}
"""What training can write, or more: within them nothing that is computed is infinite."""
_SCALE: Final = (1e-12, LARGEST)
_ROUNDING: Final = 1e-9
_ARRAYS: Final[Kinds] = {
    "periods_s": ("<f8", ("periods",)),
    "is_used": ("|u1", ("regressions", N_FEATURES)),
    "centre": ("<f8", ("regressions", N_FEATURES)),
    "scale": ("<f8", ("regressions", N_FEATURES)),
    "low": ("<f8", ("regressions", N_FEATURES)),
    "high": ("<f8", ("regressions", N_FEATURES)),
    "kernel": ("|u1", ("regressions",)),
    "cost": ("<f8", ("regressions",)),
    "epsilon": ("<f8", ("regressions",)),
    "gamma": ("<f8", ("regressions",)),
    "offset": ("<f8", ("regressions",)),
    "vector_ends": ("<i4", ("regressions",)),
    "vectors": ("<f8", ("vectors", N_FEATURES)),
    "weights": ("<f8", ("vectors",)),
    "n_rows": ("<i4", ("regressions",)),
    "error": ("<f8", ("regressions",)),
    "constant": ("<f8", ("regressions",)),
    "constant_error": ("<f8", ("regressions",)),
}
"""The single regression is the last; columns of features that one does not take are 0."""
_OF_REGRESSIONS: Final = ("centre", "scale", "low", "high")
_OF_SETTINGS: Final = ("cost", "epsilon", "gamma")
_OF_QUALITIES: Final = ("n_rows", "error", "constant", "constant_error")
_FACTS: Final[dict[str, type]] = {"name": str, "features": list, "origin": dict}
_GREATEST: Final = 2**32
"""Of the numbers that say what it was trained on."""
_ORIGIN: Final[dict[str, type]] = {
    "n_pedestrians": int,
    "n_subjects": int,
    "n_trials": int,
    "simulated": str,
    "square_px": float,
    "centre_share": float,
    "display_s": float,
    "seed": int,
    "fingerprint": str,
    "search": str,
}


def write_estimator(estimator: Estimator, path: Path) -> None:
    """Write a model file.

    Raises
    ------
    InputError
        If it cannot be written.
    """
    write_whole(path, to_bytes(estimator))


def estimator_path(model: str | PathLike[str]) -> Path:
    """Where an estimator lies: at its path, or with the package if it is called ``sample``."""
    return SAMPLE_ESTIMATOR if fspath(model) == SAMPLE_NAME else Path(model)


def is_estimator_file(path: str | PathLike[str]) -> bool:
    """Whether a file calls itself an estimator; not whether it can be used."""
    try:
        with Path(path).open("rb") as file:
            return archives.format_of(file.read(MAX_BYTES + 1)) == FORMAT
    except (OSError, ValueError):  # none, a folder; a NUL in the name
        return False


def read_estimator(path: Path) -> Estimator:
    """The estimator in a file.

    Raises
    ------
    EstimatorError
        If the file cannot be read, or is no such model.
    """
    try:
        with path.open("rb") as file:
            content = file.read(MAX_BYTES + 1)
    except FileNotFoundError as error:
        raise EstimatorError(
            f"there is no such file; expected {_WHAT}, or {SAMPLE_NAME}: that of the sample's "
            "simulated observer",
            file=path.name,
        ) from error
    except OSError as error:
        raise EstimatorError(f"cannot be opened ({error.strerror})", file=path.name) from error
    return from_bytes(content, path.name)


def to_bytes(estimator: Estimator) -> bytes:
    """The estimator as the content of a file; equal ones give equal bytes."""
    return archives.pack(_members(estimator))


def fingerprint(estimator: Estimator) -> str:
    """sha256 over the estimator, as hexadecimal digits."""
    return archives.fingerprint_of(_members(estimator))


def from_bytes(content: bytes, name: str) -> Estimator:
    """The estimator that `to_bytes` wrote.

    Parameters
    ----------
    name
        Of the file, for errors.

    Raises
    ------
    EstimatorError
        If it is damaged, or anything in it is not as it must be.
    """
    try:
        with archives.damage_of(_WHAT):
            about, arrays = archives.unpack(content, _ARRAYS, what=_WHAT, most_bytes=MAX_BYTES)
            return _checked(about, arrays)
    except BadArchiveError as error:
        is_network = name.lower().endswith(".onnx")
        hint = "; networks (.onnx) are for nvcore detect" if is_network else ""
        raise EstimatorError(f"{error}{hint}", file=name) from error


def _members(estimator: Estimator) -> dict[str, NDArray[Any]]:
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
    about: dict[str, Any] = {
        "format": FORMAT,
        "version": VERSION,
        "name": estimator.name,
        "features": list(FEATURE_KEYS),
        "origin": estimator.origin.as_json(),
    }
    if estimator.feature_settings is not None:
        settings = asdict(estimator.feature_settings)
        about["feature_settings"] = {name: float(value) for name, value in settings.items()}
    return archives.members_of(about, values, _ARRAYS)


def _checked(about: Mapping[str, Any], arrays: dict[str, NDArray[Any]]) -> Estimator:
    archives.check_version(about, FORMAT, VERSION, what=_WHAT)
    archives.check_facts(about, _FACTS)
    archives.check_name(about, "name", LONGEST_NAME)
    if tuple(about["features"]) != FEATURE_KEYS:
        raise BadArchiveError("features: expected those of this program; train the model again")
    archives.check_lengths(arrays, _ARRAYS, _MOST, may_be_empty=("vectors",))
    _check_values(arrays)
    n_regressions = len(arrays["offset"])
    return Estimator(
        name=about["name"],
        periods_s=arrays["periods_s"],
        regressions=tuple(_regression(arrays, row) for row in range(n_regressions)),
        qualities=tuple(
            Quality(**{name: arrays[name][row].item() for name in _OF_QUALITIES})
            for row in range(n_regressions)
        ),
        origin=_origin(about["origin"]),
        feature_settings=_feature_settings(about),
    )


def _check_values(arrays: Mapping[str, NDArray[Any]]) -> None:
    """Refuse numbers with which nothing can be estimated."""
    periods, is_used, ends = arrays["periods_s"], arrays["is_used"], arrays["vector_ends"]
    if len(is_used) != len(periods) + 1:
        raise BadArchiveError("expected a regression for each period, and one for all")
    if periods[0] < 0 or (np.diff(periods) <= 0).any():
        raise BadArchiveError("periods_s: expected ascending numbers of 0 or more")
    if is_used.max() > 1 or not is_used.any(axis=1).all():
        raise BadArchiveError("is_used: expected 0 and 1, and a feature for each regression")
    if (np.diff(ends, prepend=0) < 0).any() or ends[-1] != len(arrays["weights"]):
        raise BadArchiveError("vector_ends: expected ascending numbers up to those of vectors")
    if (arrays["scale"][is_used == 1] <= 0).any():
        raise BadArchiveError("scale: expected numbers above 0")
    if arrays["kernel"].max() >= len(KERNELS):
        raise BadArchiveError("kernel: expected 0 or 1")
    for name, limits in _RANGES.items():
        _check_range(name, arrays[name].ravel(), *limits)
    _check_range("scale", arrays["scale"][is_used == 1], *_SCALE)
    _check_relations(arrays)


def _check_range(name: str, values: NDArray[Any], low: float, high: float) -> None:
    is_wrong = (values < low) | (values > high)
    if is_wrong.any():
        value = values[is_wrong.argmax()]
        raise BadArchiveError(f"{name}: expected {low:g} to {high:g}, found {value:g}")


def _check_relations(arrays: Mapping[str, NDArray[Any]]) -> None:
    """Refuse numbers that no training gives beside each other."""
    centre = arrays["centre"]
    slack = _ROUNDING * np.maximum(np.abs(centre), 1.0)
    if (arrays["low"] > centre + slack).any() or (arrays["high"] < centre - slack).any():
        raise BadArchiveError("low, centre, high: expected them in this order")
    most = np.repeat(arrays["cost"], np.diff(arrays["vector_ends"], prepend=0))
    if (np.abs(arrays["weights"]) > most * (1 + _ROUNDING)).any():
        raise BadArchiveError("weights: expected no more than the cost, without the sign")


def _regression(arrays: Mapping[str, NDArray[Any]], row: int) -> Regression:
    columns = np.flatnonzero(arrays["is_used"][row])
    end = int(arrays["vector_ends"][row])
    start = int(arrays["vector_ends"][row - 1]) if row else 0
    settings = {name: float(arrays[name][row]) for name in _OF_SETTINGS}
    return Regression(
        columns=columns,
        **{name: arrays[name][row, columns] for name in _OF_REGRESSIONS},
        vectors=np.ascontiguousarray(arrays["vectors"][start:end, columns]),
        weights=arrays["weights"][start:end],
        offset=float(arrays["offset"][row]),
        settings=SvrSettings(KERNELS[int(arrays["kernel"][row])], **settings),
    )


def _feature_settings(about: Mapping[str, Any]) -> FeatureSettings | None:
    """None: models of earlier versions do not say them."""
    if "feature_settings" not in about:
        return None
    archives.check_facts(about, {"feature_settings": dict})
    try:
        return settings_from_json(about["feature_settings"])
    except ValueError as error:
        raise BadArchiveError(str(error)) from error


def _origin(content: Mapping[str, Any]) -> Origin:
    content = {"search": "", **content}
    picture_px = content.pop("picture_px", None)
    if set(content) != set(_ORIGIN):
        raise BadArchiveError("origin: its keys are others")
    archives.check_facts(content, _ORIGIN)
    if content["simulated"] not in ("no", "all", "some"):
        raise BadArchiveError("simulated: expected no, all or some")
    if content["search"] not in SEARCHES:
        raise BadArchiveError("search: expected quick, or none")
    for name, kind in _ORIGIN.items():
        if kind is not str and not 0 <= content[name] <= _GREATEST:
            raise BadArchiveError(f"{name}: expected 0 to {_GREATEST}, got {content[name]!r:.80}")
    try:
        return Origin(**content, picture_px=picture_px_from_json(picture_px))
    except ValueError as error:
        raise BadArchiveError(str(error)) from error
