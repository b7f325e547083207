"""Registry of detector kinds. Opens detectors by name or model file.

    open_detector("hog:daimler", {"upscale": 2})
    open_detector("models/yolo.onnx", {"threshold": 0.3})

The packages that a kind needs are imported when a detector of that kind is opened.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, fields
from importlib import import_module
from pathlib import Path
from typing import Any, Final

from nvcore.common.errors import ParameterError
from nvcore.common.file_kinds import binary_kind
from nvcore.common.wording import did_you_mean, listed, one_line
from nvcore.dataset.provenance import About, Setting
from nvcore.subjects.detectors.base import Detector, DetectorError
from nvcore.subjects.detectors.settings import SettingFacts, facts_of, typed_like

SAMPLE_MODEL: Final = Path(__file__).with_name("models") / "sample.npz"
"""Written by scripts/detectors/train_sample.py."""
_HEAD_BYTES: Final = 4096


@dataclass(frozen=True)
class DetectorKind:
    """Kind of detector.

    Attributes
    ----------
    key
        Name in records and commands.
    title
        Description for people.
    built_in
        Names and descriptions of built-in detectors, which need no file.
    open
        Maps a name or path and settings to the detector; raises DetectorError.
    settings
        Settings class, as module and name.
    begins
        Pattern of the first bytes of its model files. It never matches if there are none.
    threshold
        Name of the setting below which scores are dropped.
    loosest
        Settings that drop and suppress no box.
    """

    key: str
    title: str
    built_in: Mapping[str, str]
    open: Callable[[str, Mapping[str, Any]], Detector]
    settings: str
    begins: bytes = rb"(?!)"
    threshold: str = "threshold"
    loosest: Mapping[str, Setting] = field(default_factory=dict)


def _of_package(reference: str) -> Any:
    """Import the object that a reference such as ``"hog:HogSettings"`` names in this package."""
    module, _, name = reference.partition(":")
    return getattr(import_module(f"{__package__}.{module}"), name)


def _open_icf(text: str, settings: Mapping[str, Any]) -> Detector:
    from nvcore.subjects.detectors.icf import read_model

    detector = read_model(SAMPLE_MODEL if text == "icf:sample" else Path(text))
    if not settings:
        return detector
    try:
        return detector.run_with(**typed_like(detector.model.settings, settings))
    except ParameterError as error:
        raise DetectorError(str(error)) from error


DETECTORS: Final[dict[str, DetectorKind]] = {
    kind.key: kind
    for kind in (
        DetectorKind(
            "hog",
            "OpenCV's people detectors: gradients in cells, a linear classifier",
            {"hog": "trained on INRIA's people", "hog:daimler": "trained on Daimler's pedestrians"},
            lambda text, given: _of_package("hog:open_hog")(text.partition(":")[2], given),
            "hog:HogSettings",
            threshold="hit_threshold",
            loosest={"hit_threshold": -10.0, "overlap": 1.0},
        ),
        DetectorKind(
            "icf",
            "Integral Channel Features with a soft cascade: a model that was trained here (.npz)",
            {"icf:sample": "trained on seven sample recordings: drawings, not real people"},
            _open_icf,
            "icf.settings:IcfSettings",
            rb"PK\x03\x04",
            loosest={"threshold": -1e6, "overlap": 1.0},
        ),
        DetectorKind(
            "onnx",
            "a network of one's own in ONNX (.onnx), run by ONNX Runtime",
            {},
            lambda text, given: _of_package("onnx:open_onnx")(Path(text), given),
            "onnx.settings:OnnxSettings",
            # a protobuf message: first the version of ONNX, or the producer's name
            rb"(?s)\x08[\x01-\x3f].|\x12[\x00-\x7f].",
            loosest={"threshold": 0.0, "overlap": 1.0},
        ),
    )
}
"""Kinds of detectors by key."""
_BUILT_IN: Final = {name: kind for kind in DETECTORS.values() for name in kind.built_in}


def open_detector(text: str | Path, settings: Mapping[str, Any] | None = None) -> Detector:
    """Open a detector that is ready to run.

    Parameters
    ----------
    text
        Name of a built-in detector (``hog``, ``hog:daimler``), or path of a model, whose kind is
        recognised by its content. A built-in name takes precedence over a file in the current
        folder; write ``./hog`` for the file.
    settings
        Settings by name; see `nvcore.subjects.detectors.settings.typed_like`. None: the defaults.

    Raises
    ------
    DetectorError
        If there is no such detector, its file is not a valid model, or a setting cannot be used.
    MissingExtraError
        If it needs packages that are not installed.
    """
    return kind_named(text).open(str(text), settings or {})


def kind_named(text: str | Path) -> DetectorKind:
    """Return the kind of detector that `open_detector` opens for this text. Errors as there."""
    return _BUILT_IN.get(str(text)) or kind_of_file(Path(text))


def kind_of_file(path: Path) -> DetectorKind:
    """Return the kind of detector in a model file.

    Raises
    ------
    DetectorError
        If the file cannot be opened or is not a model.
    """
    name = one_line(str(path))
    try:
        with path.open("rb") as stream:
            head = stream.read(_HEAD_BYTES)
    except FileNotFoundError as error:
        known = f"built in are {listed([*_BUILT_IN])}; any other is the path of a model file"
        hint = did_you_mean(str(path), _BUILT_IN, known)
        if str(path) in DETECTORS:
            hint = f"{path} is a kind of them, and needs a model; {known}"
        raise DetectorError(f"there is no such detector or file; {hint}", file=name) from error
    except (OSError, ValueError) as error:  # a folder, or NUL in the name
        reason = getattr(error, "strerror", None) or error
        raise DetectorError(f"cannot be opened ({reason})", file=name) from error
    for kind in DETECTORS.values():
        if re.match(kind.begins, head):
            return kind
    what = binary_kind(head) or ("text" if head else "empty")
    raise DetectorError(
        f"is {what.partition(':')[0]}, no model; expected one that nvcore train wrote (.npz), or "
        "an ONNX file (.onnx)",
        file=name,
    )


def settings_of(kind: str) -> dict[str, SettingFacts]:
    """Return all settings of a kind of detector by name. For ``icf`` they include the training."""
    return {spec.name: facts_of(spec) for spec in fields(_of_package(DETECTORS[kind].settings))}


def run_settings(about: About) -> dict[str, SettingFacts]:
    """Return the settings that a run of this detector may change, by name."""
    facts = settings_of(about.kind)
    if about.kind != "icf":
        return facts
    of_run = _of_package("icf.settings:OF_A_RUN")
    return {name: known for name, known in facts.items() if name in of_run}
