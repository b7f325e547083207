"""Provenance of a system's detections, as the record beside them states it.

    {"written_by": "nvcore 0.1.0",
     "detector": {"kind": "hog", "name": "hog", "labels": ["pedestrian"], "fingerprint": "5f1c...",
                  "settings": {"stride": 8}, "trained_on": [
                      {"recording": "urban_01", "first_frame": 0, "last_frame": 399}]},
     "files": {"urban_01.csv": "9e07..."},
     "recordings": [{"name": "urban_01", "frames": ["0:299"]}]}

A record written by hand for your own detector only needs ``trained_on``.
"""

from __future__ import annotations

import json
import re
import reprlib
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, field, replace
from pathlib import Path
from typing import Final, TypeAlias

import numpy as np
from numpy.typing import NDArray

from nvcore.common.errors import ParameterError
from nvcore.common.records import convert, decode, read_record
from nvcore.common.wording import one_line, shortened

Setting: TypeAlias = bool | int | float | str | None
"""Value of a detector's setting, as in JSON."""
Ranges: TypeAlias = tuple[tuple[int, int], ...]
"""Frame numbers as first and last frame of each run, ascending."""

_MAX_FRAME: Final = 2**53
_LONGEST_TEXT: Final = 4096
"""Most characters of a name or fingerprint."""
_SHOWN_NAME: Final = 40
_SHOWN_DIGITS: Final = 12
"""Most characters shown of a name, and of a fingerprint."""
_RANGE: Final = re.compile(r"(-?\d{1,15}):(-?\d{1,15})", re.ASCII)
_EXPECTED: Final = "expected the record that nvcore detect writes (docs/detectors.md)"


@dataclass(frozen=True)
class TrainedOn:
    """Recording, or part of one, on which a detector was trained.

    Attributes
    ----------
    fingerprint
        Fingerprint of the ground truth in these frames, which identifies the recording even under
        another name; for crops and scenes the sha256 of their bytes. Empty if unknown.
    recording
        Name of the recording; empty for crops and scenes without a recording.
    first_frame, last_frame
        First and last frame, both included; None: from the beginning, to the end.
    """

    fingerprint: str = ""
    recording: str = ""
    first_frame: int | None = None
    last_frame: int | None = None

    def __post_init__(self) -> None:
        if not self.recording and not self.fingerprint:
            raise ParameterError("expected a recording or a fingerprint")
        if max(len(self.recording), len(self.fingerprint)) > _LONGEST_TEXT:
            raise ParameterError(f"expected texts of at most {_LONGEST_TEXT:,} characters")
        for frame in (self.first_frame, self.last_frame):
            if frame is not None and abs(frame) > _MAX_FRAME:
                raise ParameterError(f"expected a frame number, found {reprlib.repr(frame)}")

    def __str__(self) -> str:
        if not self.recording:
            return f"crops and scenes ({self.fingerprint[:_SHOWN_DIGITS]})"
        if self.first_frame is None and self.last_frame is None:
            return one_line(self.recording)
        first = self.first_frame or 0
        span = f"from {first}" if self.last_frame is None else f"{first} to {self.last_frame}"
        return f"{one_line(self.recording)}, frames {span}"


@dataclass(frozen=True)
class About:
    """Identity of a detector, to tell it from others and to write beside its results.

    Attributes
    ----------
    kind
        Key in the registry: ``icf``, ``hog``, ``onnx``.
    name
        Name of the model, for people.
    labels
        Classes that it detects: ``("pedestrian",)``.
    settings
        All settings that its boxes depend on, by name.
    fingerprint
        sha256 over model and settings, as hexadecimal digits: equal if and only if the boxes are.
    trained_on
        Known training data; empty if unknown.
    threshold
        Default score threshold; None: all boxes count.
    """

    kind: str = ""
    name: str = ""
    labels: tuple[str, ...] = ()
    settings: Mapping[str, Setting] = field(default_factory=dict)
    fingerprint: str = ""
    trained_on: tuple[TrainedOn, ...] = ()
    threshold: float | None = None


@dataclass(frozen=True)
class Provenance:
    """Provenance of a system's detections.

    Attributes
    ----------
    about
        The detector.
    files
        sha256 of each file with detections, by file name.
    frames
        Frames that the detector was given, by recording; empty if unknown.
    written_by
        Program and version.
    """

    about: About
    files: Mapping[str, str] = field(default_factory=dict)
    frames: Mapping[str, Ranges] = field(default_factory=dict)
    written_by: str = ""

    @property
    def made_by(self) -> str:
        """Detector in a few words, or empty if it is not known."""
        about = self.about
        if not about.kind:
            return ""
        name = shortened(one_line(about.name), _SHOWN_NAME)
        kind = shortened(one_line(about.kind), _SHOWN_NAME)
        return f"made by {kind} ({name}, fingerprint {one_line(about.fingerprint[:_SHOWN_DIGITS])})"

    def renamed(self, recordings: Mapping[str, str]) -> Provenance:
        """Return the same provenance with other names of recordings, by the old ones."""
        trained_on = tuple(
            replace(part, recording=recordings.get(part.recording, part.recording))
            for part in self.about.trained_on
        )
        frames = {recordings.get(name, name): ranges for name, ranges in self.frames.items()}
        return replace(self, about=replace(self.about, trained_on=trained_on), frames=frames)


def ranges_of(frames: NDArray[np.int64]) -> Ranges:
    """Convert frame numbers, in any order, to runs of consecutive ones.

    Examples
    --------
    >>> ranges_of(np.array([0, 1, 2, 5]))
    ((0, 2), (5, 5))
    """
    ordered = np.unique(np.asarray(frames, dtype=np.int64))
    if not len(ordered):
        return ()
    ends = np.flatnonzero(np.diff(ordered) > 1)
    first = ordered[np.concatenate([[0], ends + 1])]
    last = ordered[np.concatenate([ends, [len(ordered) - 1]])]
    return tuple(zip(first.tolist(), last.tolist(), strict=True))


def is_in_ranges(frames: NDArray[np.int64], ranges: Ranges) -> NDArray[np.bool_]:
    """Return a mask of the frames that are in one of the ranges, bool, shape (n,)."""
    if not ranges:
        return np.zeros(len(frames), dtype=bool)
    edges = np.array(ranges, dtype=np.int64)
    row = np.searchsorted(edges[:, 0], frames, side="right") - 1
    is_inside: NDArray[np.bool_] = (row >= 0) & (frames <= edges[np.maximum(row, 0), 1])
    return is_inside


def provenance_json(provenance: Provenance) -> bytes:
    """Return the record as JSON. The same record gives the same bytes."""
    about = provenance.about
    parts = [
        {key: value for key, value in asdict(part).items() if value not in (None, "")}
        for part in about.trained_on
    ]
    content = {
        "written_by": provenance.written_by,
        "detector": {
            "kind": about.kind,
            "name": about.name,
            "labels": list(about.labels),
            "fingerprint": about.fingerprint,
            "settings": dict(about.settings),
            "trained_on": parts,
        },
        "files": dict(provenance.files),
        "recordings": [
            {"name": name, "frames": [f"{first}:{last}" for first, last in ranges]}
            for name, ranges in provenance.frames.items()
        ],
    }
    return (json.dumps(content, indent=1) + "\n").encode()


def read_provenance(path: Path, name: str) -> Provenance:
    """Read a provenance record.

    Parameters
    ----------
    name
        Name of the file as the user gave it.

    Raises
    ------
    InputError
        If it cannot be opened or is not a valid record. Records are never used in part.
    """
    return read_record(path, name, _provenance, expected=_EXPECTED)


def _provenance(content: object) -> Provenance:
    record = convert(Mapping[str, object], content, "the record")
    detector = convert(Mapping[str, object], record.get("detector", {}), "detector")
    about = decode(About, {**detector, "threshold": None}, "detector", known_only=False)
    recordings = convert(tuple[_Recording, ...], record.get("recordings", ()), "recordings")
    return Provenance(
        about=about,
        files=convert(Mapping[str, str], record.get("files", {}), "files"),
        frames={of.name: _ranges(of.frames) for of in recordings},
        written_by=convert(str, record.get("written_by", ""), "written_by"),
    )


@dataclass(frozen=True)
class _Recording:
    name: str = ""
    frames: tuple[str, ...] = ()


def _ranges(texts: Sequence[str]) -> Ranges:
    matches = [_RANGE.fullmatch(text) for text in texts]
    ranges = tuple((int(match[1]), int(match[2])) for match in matches if match is not None)
    ends = [number for pair in ranges for number in pair]
    if len(ranges) < len(texts) or ends != sorted(ends):
        raise ValueError('frames: expected texts such as "0:299", in ascending order')
    return ranges
