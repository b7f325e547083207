"""Detector for custom ONNX networks: validated on opening, run by ONNX Runtime on the CPU."""

from __future__ import annotations

import ast
import hashlib
import json
import os
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import asdict, replace
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from nvcore.common.extras import needs
from nvcore.common.wording import one_line, shortened
from nvcore.dataset.provenance import About, Setting
from nvcore.pictures import Picture
from nvcore.subjects.detectors.base import Detections, DetectorError
from nvcore.subjects.detectors.onnx.external import MAX_BYTES, external_files
from nvcore.subjects.detectors.onnx.inputs import PictureForm, network_input
from nvcore.subjects.detectors.onnx.layouts import (
    PRESETS,
    Candidates,
    OutputLayout,
    activated,
    corners,
    recognise,
)
from nvcore.subjects.detectors.onnx.settings import AUTO, OnnxSettings
from nvcore.subjects.detectors.settings import settings_from
from nvcore.subjects.detectors.suppression import sorted_detections, suppress

# Set before ONNX Runtime is imported, which reads it once. Otherwise official builds send telemetry
# and keep a machine identifier in the user's cache. Recordings are confidential.
os.environ["ORT_DISABLE_TELEMETRY"] = "1"
with needs("onnx", "ONNX models need"):
    import onnxruntime
    from onnxruntime.capi import onnxruntime_pybind11_state as states

USUAL_PX: Final = 640
USUAL_OVERLAP: Final = 0.5
MOST_CANDIDATES: Final = 10_000
"""Maximum number of boxes per picture. The most confident ones are kept."""
LARGEST_SHARE: Final = 1.5
"""Coordinates above this value are not relative to the picture size."""
PEOPLE: Final = ("person", "pedestrian", "people")
_DTYPES: Final = {
    "tensor(float)": np.float32,
    "tensor(float16)": np.float16,
    "tensor(uint8)": np.uint8,
}
_ERRORS: Final[tuple[type[Exception], ...]] = (
    ValueError,
    RuntimeError,
    *(
        kind
        for kind in vars(states).values()
        if isinstance(kind, type) and issubclass(kind, Exception)
    ),
)
_NUMBERS: Final = "fiub"
"""Kinds of numeric arrays, as opposed to text."""
_MAX_NAMES: Final = 1 << 20
_MOST_CLASSES: Final = 1 << 20
_OF_FAMILY: Final = ("box", "fit", "values", "colour", "activation", "unit")
"""Settings that the output layout decides if they are ``auto``."""


def open_onnx(path: Path, given: Mapping[str, Setting]) -> OnnxDetector:
    """Open a network as a detector and test it once on a blank picture.

    Parameters
    ----------
    path
        Model file.
    given
        Settings by name; see `OnnxSettings`.

    Raises
    ------
    DetectorError
        If the file is damaged, stores weights outside its folder, or has an input or output of
        unknown kind, or a setting cannot be used.
    """
    settings = settings_from(OnnxSettings, given)
    name = one_line(str(path))
    try:
        if path.stat().st_size > MAX_BYTES:
            raise DetectorError("is larger than 2 GiB, which no ONNX file is", file=name)
        content = path.read_bytes()
        files = external_files(content, path, name)
        digest = hashlib.sha256(content)
        for file in files:
            with file.open("rb") as stream:
                digest.update(hashlib.file_digest(stream, "sha256").digest())
    except OSError as error:
        raise DetectorError(f"cannot be opened ({error.strerror})", file=name) from error
    onnxruntime.disable_telemetry_events()  # in case another program imported ONNX Runtime before
    options = onnxruntime.SessionOptions()
    options.intra_op_num_threads, options.inter_op_num_threads = settings.threads, 1
    options.log_severity_level = 4  # errors are raised, so they need not be logged as well
    with _plain_errors(name):
        session = onnxruntime.InferenceSession(
            str(path) if files else content, options, providers=["CPUExecutionProvider"]
        )
    return OnnxDetector(session, settings, path.stem, name, digest.hexdigest())


@contextmanager
def _plain_errors(name: str) -> Iterator[None]:
    """Convert errors of ONNX Runtime raised in this context to DetectorError."""
    try:
        yield
    except _ERRORS as error:
        words = shortened(one_line(str(error).partition(") : ")[2] or str(error)), 300)
        raise DetectorError(f"ONNX Runtime cannot run it: {words}", file=name) from error


class OnnxDetector:
    """Detector for an ONNX network. See `nvcore.subjects.detectors.base.Detector`."""

    def __init__(
        self, session: Any, settings: OnnxSettings, title: str, name: str, digest: str
    ) -> None:
        """Determine the network's input form and output layout.

        Parameters
        ----------
        session
            ONNX Runtime session.
        title
            Name of the model.
        name
            File name for error messages.
        digest
            sha256 of the model files.
        """
        self._session, self._name = session, name
        inputs = session.get_inputs()
        if len(inputs) != 1:
            names = ", ".join(one_line(part.name) for part in inputs)
            raise DetectorError(
                f"has {len(inputs)} inputs ({names}); expected one, the picture", file=name
            )
        self._input = inputs[0].name
        self._form = form = _form(inputs[0], settings, name)
        blank = np.zeros((form.size[1], form.size[0]), dtype=np.uint8)
        plain = replace(settings, fit="stretch", values="0..1", colour="rgb")
        outputs = self._run(network_input(blank, form, plain)[0])
        key = recognise(outputs, form.size, name) if settings.layout == AUTO else settings.layout
        self._layout = layout = PRESETS[key]
        usual = {
            field: getattr(layout, field)
            for field in _OF_FAMILY
            if getattr(settings, field) == AUTO
        }
        overlap = 1.0 if layout.suppresses else USUAL_OVERLAP
        self.settings = settings = replace(
            settings,
            layout=key,
            width=form.size[0],
            height=form.size[1],
            overlap=settings.overlap if settings.overlap >= 0 else overlap,
            **usual,
        )
        self._classes = _classes(settings, layout, _names(session, settings), name)
        values: dict[str, Setting] = asdict(settings)
        # the number of threads does not change the boxes
        of_boxes = {key: value for key, value in values.items() if key != "threads"}
        text = json.dumps([digest, of_boxes, list(self._classes.items())], sort_keys=True)
        self.about = About(
            kind="onnx",
            name=title,
            labels=tuple(dict.fromkeys(self._classes.values())),
            settings=values,
            fingerprint=hashlib.sha256(text.encode()).hexdigest(),
            threshold=max(layout.threshold, settings.threshold),
        )
        self._read(outputs)  # reports an unsuitable layout at once

    def detect(self, picture: Picture) -> Detections:
        """Return the boxes in one picture (see `Detector.detect`)."""
        array, fitting = network_input(picture, self._form, self.settings)
        box, score, number = self._chosen(self._read(self._run(array)))
        highest = np.abs(box).max(initial=0.0, where=np.isfinite(box))
        unit = self.settings.unit
        if unit == "shares" or (unit == AUTO and highest <= LARGEST_SHARE):
            box = box * np.tile(np.array(self._form.size, dtype=np.float64), 2)
        left, top, right, bottom = fitting.to_picture(box).T
        sides = np.column_stack([left, top, right - left, bottom - top])
        is_box = np.isfinite(sides).all(axis=1) & (sides[:, 2:] > 0).all(axis=1)
        labels = np.array([self._classes[k] for k in number.tolist()] + [""], dtype=object)[:-1]
        is_one_kind = len(self.about.labels) < 2
        detections = sorted_detections(
            sides[is_box], score[is_box], None if is_one_kind else labels[is_box]
        )
        return suppress(detections, self.settings.overlap)

    def _run(self, array: NDArray[Any]) -> dict[str, NDArray[Any]]:
        names = [part.name for part in self._session.get_outputs()]
        with _plain_errors(self._name):
            outputs = self._session.run(None, {self._input: array})
        arrays = {
            name: array
            for name, array in zip(names, outputs, strict=True)
            if isinstance(array, np.ndarray) and array.dtype.kind in _NUMBERS
        }
        if not arrays:
            raise DetectorError("none of its outputs is an array of numbers", file=self._name)
        return arrays

    def _read(self, outputs: Mapping[str, NDArray[Any]]) -> Candidates:
        try:
            candidates = self._layout.read(outputs, self._form.size)
        except DetectorError as error:
            raise DetectorError(
                f"{error.message} (layout {self.settings.layout})", file=self._name
            ) from error
        if candidates.label is not None and self.settings.activation == "softmax":
            raise DetectorError(
                f"layout {self.settings.layout} has one score for each box; expected none or "
                "sigmoid (setting activation), as softmax needs the scores of all classes",
                file=self._name,
            )
        score = activated(candidates.score, self.settings.activation)
        return replace(candidates, score=score)

    def _chosen(
        self, candidates: Candidates
    ) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.int64]]:
        """Return corners, scores and classes of the selected boxes in the network's coordinates."""
        every = np.array([*self._classes], dtype=np.int64)
        if candidates.label is None:
            known = every[every < candidates.score.shape[1]]
            if not len(known):
                raise DetectorError(
                    f"has {candidates.score.shape[1]} classes; expected one of the numbers "
                    f"{', '.join(map(str, every))} (setting classes)",
                    file=self._name,
                )
            best = np.argmax(candidates.score[:, known], axis=1)
            number = known[best]
            score = candidates.score[np.arange(len(number)), number]
            is_chosen = score >= self.settings.threshold
        else:
            number, score = candidates.label, candidates.score[:, 0]
            is_chosen = (score >= self.settings.threshold) & np.isin(number, every)
        rows = np.flatnonzero(is_chosen)  # also drops NaN scores
        if len(rows) > MOST_CANDIDATES:
            rows = rows[np.argsort(-score[rows], kind="stable")[:MOST_CANDIDATES]]
        return corners(candidates.box[rows], self.settings.box), score[rows], number[rows]


def _form(part: Any, settings: OnnxSettings, name: str) -> PictureForm:
    """Return the form of the network's input. Raise DetectorError if it is not a picture."""
    shape = [side if isinstance(side, int) and side > 0 else None for side in part.shape]
    has_batch = len(shape) == 4
    sides = shape[1:] if has_batch else shape
    is_last = len(sides) == 3 and sides[2] in (1, 3) and sides[0] not in (1, 3)
    dtype = _DTYPES.get(part.type)
    if dtype is None or len(sides) != 3 or (has_batch and shape[0] not in (1, None)):
        raise DetectorError(
            f"its input {one_line(part.name)} is {part.type} {part.shape}; expected one picture: "
            "(1, 3, height, width) or (1, height, width, 3) of float, float16 or uint8",
            file=name,
        )
    n_channels = sides[2] if is_last else sides[0]
    if n_channels not in (1, 3, None):
        raise DetectorError(
            f"its input has {n_channels} channels; expected 3 colours, or 1 of grey", file=name
        )
    own_height, own_width = sides[:2] if is_last else sides[1:]
    size = (
        _side("width", own_width, settings.width, name),
        _side("height", own_height, settings.height, name),
    )
    return PictureForm(
        size=size,
        n_channels=n_channels or 3,
        is_last=is_last,
        has_batch=has_batch,
        dtype=np.dtype(dtype),
    )


def _side(what: str, own: int | None, given: int, name: str) -> int:
    """Return a side of the input, px: the network's own if it is fixed, else the given one."""
    if own is not None and given not in (0, own):
        raise DetectorError(f"{what}: its input is fixed to {own} px, found {given}", file=name)
    side = own or given or USUAL_PX
    if side > 8192:
        raise DetectorError(
            f"its input is {side:,} px in {what}; expected 8,192 at most", file=name
        )
    return side


def _names(session: Any, settings: OnnxSettings) -> dict[int, str]:
    """Return class names by number, from the settings or else from the model's metadata."""
    if settings.names:
        return dict(enumerate(name.strip() for name in settings.names.split(",")))
    text = session.get_modelmeta().custom_metadata_map.get("names", "")
    if not 0 < len(text) <= _MAX_NAMES:
        return {}
    try:
        value = ast.literal_eval(text)  # format of Ultralytics: {0: 'person', 1: ...}
        numbered = enumerate(value if isinstance(value, list | tuple) else ())
        entries = value if isinstance(value, dict) else dict(numbered)
        return {
            key: one_line(str(name))
            for key, name in entries.items()
            if type(key) is int and 0 <= key < _MOST_CLASSES
        }
    except (ValueError, TypeError, SyntaxError, MemoryError, RecursionError):
        return {}  # also for a list as a key, or an integer of thousands of digits


def _classes(
    settings: OnnxSettings, layout: OutputLayout, names: Mapping[int, str], file: str
) -> dict[int, str]:
    """Return number and name of the classes that count."""
    texts = [text.strip() for text in settings.classes.split(",") if text.strip()]
    if not texts:
        people = {number: name for number, name in names.items() if name.lower() in PEOPLE}
        if people or not names:
            return people or {layout.person: "person"}
        known = ", ".join(names[number] for number in sorted(names)[:10])
        raise DetectorError(
            f"has no class person or pedestrian, but {known}; choose by the setting classes",
            file=file,
        )
    numbers = {name: number for number, name in names.items()}
    chosen = {}
    for text in texts:
        if text in numbers:
            chosen[numbers[text]] = text
        elif text.isdecimal() and len(text) < 7:
            chosen[int(text)] = names.get(int(text), f"class {int(text)}")
        else:
            known = ", ".join([*numbers][:10]) or "none has a name: give numbers"
            raise DetectorError(f"classes: there is no {text!r} ({known})", file=file)
    return chosen
