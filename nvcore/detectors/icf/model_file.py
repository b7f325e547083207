"""Models as files: `.npz` of plain arrays and a block of JSON, never pickle."""

from __future__ import annotations

import hashlib
import io
import json
import zipfile
import zlib
from collections.abc import Mapping
from dataclasses import asdict
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from nvcore.dataset.provenance import trained_on_from
from nvcore.detectors.classifier import MAX_CLASSES, N_VALUES, Classifier
from nvcore.detectors.icf.boosting import Trees
from nvcore.detectors.icf.cascade import Calibration
from nvcore.detectors.icf.features import N_COLUMNS
from nvcore.detectors.icf.model import IcfModel
from nvcore.detectors.icf.regions import EVERYWHERE, Band
from nvcore.detectors.icf.settings import MAX_FEATURES, MAX_TREES, IcfSettings
from nvcore.errors import DetectorError, ParameterError
from nvcore.wording import one_line

FORMAT: Final = "nvcore-icf"
VERSION: Final = 1
MAX_BYTES: Final = 1 << 26
"""Size of a model file, and of all that is in it."""
_ABOUT: Final = "about"
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
LONGEST_NAME: Final = 200
"""Of a model, and of what it detects."""
_TIME: Final = (1980, 1, 1, 0, 0, 0)
_UNREADABLE: Final = (
    zipfile.BadZipFile,
    zlib.error,
    EOFError,
    NotImplementedError,
    RuntimeError,
    ValueError,
    OSError,
)


def to_bytes(model: IcfModel) -> bytes:
    """The model as the content of a file; equal models give equal bytes."""
    content = io.BytesIO()
    with zipfile.ZipFile(content, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, array in _members(model).items():
            entry = zipfile.ZipInfo(f"{name}.npy", _TIME)
            entry.compress_type = zipfile.ZIP_DEFLATED
            member = io.BytesIO()
            np.lib.format.write_array(member, array, version=(1, 0), allow_pickle=False)
            archive.writestr(entry, member.getvalue())
    return content.getvalue()


def fingerprint(model: IcfModel) -> str:
    """sha256 over the model and its settings, as hexadecimal digits."""
    digest = hashlib.sha256()
    for name, array in _members(model).items():
        digest.update(f"{name} {array.dtype.str} {array.shape}\n".encode())
        digest.update(array.tobytes())
    return digest.hexdigest()


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
    if len(content) > MAX_BYTES:
        raise DetectorError(f"a model has at most {MAX_BYTES >> 20} MiB", file=name)
    try:
        arrays = _read_members(content)
        about = _read_about(arrays.pop(_ABOUT).tobytes())
        return _checked(about, arrays)
    except DetectorError as error:
        raise DetectorError(error.message, file=name) from error
    except ParameterError as error:
        raise DetectorError(f"{error}; train the model again", file=name) from error
    except _UNREADABLE as error:
        text = one_line(str(error))
        raise DetectorError(f"is not a model of nvcore, or is damaged ({text})", file=name) from (
            error
        )


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
    arrays = {
        name: np.ascontiguousarray(values[name], np.dtype(kind))
        for name, (kind, _) in _ARRAYS.items()
        if name in values
    }
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
    text = json.dumps(about, ensure_ascii=False, allow_nan=False, indent=1)
    return {_ABOUT: np.frombuffer(text.encode(), np.uint8), **arrays}


def _read_members(content: bytes) -> dict[str, NDArray[Any]]:
    """Arrays of the archive; sizes are checked before anything is unpacked."""
    with zipfile.ZipFile(io.BytesIO(content)) as archive:
        members = archive.infolist()
        expected = {f"{name}.npy" for name in (_ABOUT, *_ARRAYS)} - {f"{_OF_CLASSES}.npy"}
        names = [member.filename for member in members]
        others = set(names) - {f"{_OF_CLASSES}.npy"}
        if others != expected or len(names) != len(set(names)):
            raise DetectorError("is not a model of nvcore: its arrays are others")
        if sum(member.file_size for member in members) > MAX_BYTES:
            raise DetectorError(f"a model has at most {MAX_BYTES >> 20} MiB")
        arrays = {}
        for member in members:
            if member.flag_bits & 1 or member.compress_type not in (0, zipfile.ZIP_DEFLATED):
                raise DetectorError(f"{member.filename} is encrypted or compressed unusually")
            with archive.open(member) as stream:
                unpacked = stream.read(member.file_size + 1)
            arrays[member.filename.removesuffix(".npy")] = _array(unpacked, member.filename)
    return arrays


def _array(member: bytes, name: str) -> NDArray[Any]:
    """An array of a plain type that is as large as its header says."""
    stream = io.BytesIO(member)
    if np.lib.format.read_magic(stream) != (1, 0):
        raise DetectorError(f"{name} has an unknown version")
    shape, is_fortran, dtype = np.lib.format.read_array_header_1_0(stream, max_header_size=1000)
    known = _ARRAYS.get(name.removesuffix(".npy"), ("|u1", ("bytes",)))
    if is_fortran or dtype != np.dtype(known[0]) or len(shape) != len(known[1]):
        raise DetectorError(f"{name} has type {dtype} and shape {shape}, expected {known[0]}")
    count = 1
    for side in shape:
        count *= side
    if min(shape) < 0 or count * dtype.itemsize != len(member) - stream.tell():
        raise DetectorError(f"{name} is not of the size that it states")
    return np.frombuffer(member, dtype, offset=stream.tell()).reshape(shape)


def _read_about(text: bytes) -> dict[str, Any]:
    def refuse(constant: str) -> None:
        raise DetectorError(f"{constant} is not a number that a model may have")

    try:
        about = json.loads(text.decode(), parse_constant=refuse)
    except RecursionError as error:
        raise DetectorError("its JSON is nested too deeply") from error
    if not isinstance(about, dict) or about.get("format") != FORMAT:
        raise DetectorError("is not a model of nvcore")
    if about.get("version") != VERSION:
        raise DetectorError(
            f"has version {about.get('version')!r}; this program reads {VERSION}: update it, or "
            "train the model again"
        )
    for name, kind in _FACTS.items():
        if type(about.get(name)) is not kind:
            raise DetectorError(f"{name}: expected {kind.__name__}, got {about.get(name)!r:.80}")
    for name in ("name", "label"):
        if not 0 < len(about[name]) <= LONGEST_NAME or not about[name].isprintable():
            raise DetectorError(f"{name}: expected 1 to {LONGEST_NAME} printable characters")
    return about


def _checked(about: Mapping[str, Any], arrays: dict[str, NDArray[Any]]) -> IcfModel:
    settings = IcfSettings.from_json(about["settings"])
    _check_lengths(arrays)
    for name, array in arrays.items():
        if not np.isfinite(array).all():
            raise DetectorError(f"{name} has values that are no numbers")
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


def _check_lengths(arrays: Mapping[str, NDArray[Any]]) -> None:
    lengths: dict[str, int] = {}
    for name, array in arrays.items():
        for side, length in zip(_ARRAYS[name][1], array.shape, strict=True):
            expected = side if isinstance(side, int) else lengths.setdefault(side, length)
            is_short = side != "band" and length < 1
            if length != expected or is_short or length > _MOST.get(str(side), length):
                raise DetectorError(f"{name} has the shape {array.shape}")
    if len(arrays["band"]) not in (0, 4):
        raise DetectorError("band: expected 4 numbers or none")


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
