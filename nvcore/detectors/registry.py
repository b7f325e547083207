"""The kinds of detectors, and how one is opened by its name or its file.

    open_detector("hog:daimler", {"upscale": 2})
    open_detector("models/yolo.onnx", {"threshold": 0.3})

What a kind needs is imported when one of it is opened.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, fields
from functools import partial
from pathlib import Path
from typing import Any, Final

from nvcore.dataset.provenance import About, Setting
from nvcore.detectors.base import Detector, DetectorError
from nvcore.detectors.settings import SettingFacts, facts_of, typed_like
from nvcore.errors import ParameterError
from nvcore.file_kinds import binary_kind
from nvcore.subjects import resolve
from nvcore.wording import did_you_mean, listed, one_line

SAMPLE_MODEL: Final = Path(__file__).with_name("models") / "sample.npz"
"""Written by scripts/detectors/train_sample.py."""
_HEAD_BYTES: Final = 4096


@dataclass(frozen=True)
class DetectorKind:
    """A kind of detector.

    Attributes
    ----------
    key
        Its name in records and commands.
    title
        What it is, for people.
    built_in
        Names of those that need no file, with what they are.
    open
        (name or path as given, settings) -> the detector; raises DetectorError.
    settings
        Class of its settings, as module and name.
    begins
        Pattern of the first bytes of its model files; never matches if it has none.
    threshold
        Name of the setting below which scores are dropped.
    loosest
        Settings with which it drops and suppresses no box.
    """

    key: str
    title: str
    built_in: Mapping[str, str]
    open: Callable[[str, Mapping[str, Any]], Detector]
    settings: str
    begins: bytes = rb"(?!)"
    threshold: str = "threshold"
    loosest: Mapping[str, Setting] = field(default_factory=dict)


_of_package: Final = partial(resolve, __package__)


def _open_icf(text: str, settings: Mapping[str, Any]) -> Detector:
    from nvcore.detectors.icf import read_model

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
"""The kinds of detectors by key."""
_BUILT_IN: Final = {name: kind for kind in DETECTORS.values() for name in kind.built_in}


def open_detector(text: str | Path, settings: Mapping[str, Any] | None = None) -> Detector:
    """A detector, ready to run.

    Parameters
    ----------
    text
        Name of a built-in one (``hog``, ``hog:daimler``), or the path of a model, which is
        recognised by its content. A file is meant where both are there only with a path: ``./hog``.
    settings
        By name; see `nvcore.detectors.settings.typed_like`. None: the defaults.

    Raises
    ------
    DetectorError
        If there is no such detector, its file is none or damaged, or a setting cannot be used.
    MissingExtraError
        If it needs packages that are not installed.
    """
    return kind_named(text).open(str(text), settings or {})


def kind_named(text: str | Path) -> DetectorKind:
    """The kind of the detector that `open_detector` opens by this name or path; errors as it."""
    return _BUILT_IN.get(str(text)) or kind_of_file(Path(text))


def kind_of_file(path: Path) -> DetectorKind:
    """The kind of detector that a model file holds.

    Raises
    ------
    DetectorError
        If it cannot be opened or is no model.
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
    except (OSError, ValueError) as error:  # a folder; a NUL in the name
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
    """All settings of a kind of detector, by name; of ``icf`` also those of its training."""
    return {spec.name: facts_of(spec) for spec in fields(_of_package(DETECTORS[kind].settings))}


def run_settings(about: About) -> dict[str, SettingFacts]:
    """The settings whose values a run of this detector may choose, by name."""
    facts = settings_of(about.kind)
    if about.kind != "icf":
        return facts
    of_run = _of_package("icf.settings:OF_A_RUN")
    return {name: known for name, known in facts.items() if name in of_run}
