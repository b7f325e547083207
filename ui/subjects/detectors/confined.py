"""Detectors in processes of their own, with limits on memory and time.

A model is a stranger's: its settings say how much work a picture is, and a network is a program.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import lru_cache
from queue import Empty, SimpleQueue
from typing import TYPE_CHECKING, Any, Final, TypeVar, cast

import cv2
import numpy as np
from numpy.typing import NDArray

from nvcore.dataset.provenance import About, Setting
from nvcore.pictures import Picture
from nvcore.subjects.detectors.base import Detections, Detector, one_for_a_picture
from nvcore.subjects.detectors.candidates import candidates, open_loosened
from nvcore.subjects.detectors.registry import open_detector
from ui.confined.process import MODELS, Process

if TYPE_CHECKING:
    from nvcore.subjects.detectors.icf import IcfDetector, IcfModel
    from nvcore.subjects.detectors.icf.settings import IcfSettings

T = TypeVar("T")

SHOWN_PX: Final = 640
"""Width of the pictures that are shown of the inside of a model."""


@dataclass(frozen=True)
class DetectorSpec:
    """Choice of a detector and its settings.

    Attributes
    ----------
    text
        Its name, or the path of its model.
    version
        Changes with the content of the model; empty: it is built in.
    settings
        Names and values of settings that differ from its own.
    """

    text: str
    version: str = ""
    settings: tuple[tuple[str, Setting], ...] = ()

    def with_settings(self, changes: Mapping[str, Setting]) -> DetectorSpec:
        """Return the same detector with further settings."""
        return replace(self, settings=tuple(sorted({**dict(self.settings), **changes}.items())))


@dataclass(frozen=True)
class Inside:
    """Contents of an ICF model that are shown whatever the picture.

    Attributes
    ----------
    error, round_ends
        See `nvcore.subjects.detectors.icf.IcfModel`.
    n_objects, n_background
        Windows of the last round of training.
    """

    settings: IcfSettings
    n_trees: int
    error: NDArray[np.float64]
    round_ends: NDArray[np.int32]
    n_objects: int
    n_background: int


@dataclass(frozen=True)
class DetectorFacts:
    """Description of a detector. `inside` is None unless it is an ICF model."""

    about: About
    inside: Inside | None


class ConfinedDetector:
    """A detector (see `nvcore.subjects.detectors.base`) with a process for each calling thread."""

    def __init__(self, spec: DetectorSpec, about: About) -> None:
        self.about = about
        self._spec = spec
        self._idle: SimpleQueue[Process] = SimpleQueue()

    def detect(self, picture: Picture) -> Detections:
        """See `Detector.detect`. InputError if the picture exceeds the allowance."""
        try:
            process = self._idle.get_nowait()
        except Empty:
            process = Process(MODELS)
        try:
            return process.call(_detect, self._spec, picture, what="running the detector")
        finally:
            self._idle.put(process)

    def close(self) -> None:
        """End the processes."""
        while not self._idle.empty():
            self._idle.get().close()


# The rest is called in the other process.


@lru_cache(maxsize=2)
def _detector(spec: DetectorSpec, *, is_loosened: bool = False) -> Detector:
    opener = open_loosened if is_loosened else open_detector
    return opener(spec.text, dict(spec.settings))


def _detect(spec: DetectorSpec, picture: Picture) -> Detections:
    one_for_a_picture()  # of a run: other cores are for other pictures, and for visitors
    cv2.setNumThreads(1)
    return _detector(spec).detect(picture)


def describe(spec: DetectorSpec) -> DetectorFacts:
    """Describe the detector."""
    about = _detector(spec).about
    if about.kind != "icf":
        return DetectorFacts(about, None)
    return DetectorFacts(about, on_model(spec, _inside))


def _inside(model: IcfModel) -> Inside:
    windows = model.n_objects, model.n_background
    trees = len(model.trees), model.error, model.round_ends
    return Inside(model.settings, *trees, *windows)


def find(spec: DetectorSpec, picture: Picture) -> Detections:
    """Return the most confident boxes of a picture, before threshold and suppression."""
    return candidates(_detector(spec, is_loosened=True), picture)


def on_model(spec: DetectorSpec, function: Callable[..., T], *arguments: Any) -> T:
    """Call a function of an ICF model, which is its first argument."""
    return function(cast("IcfDetector", _detector(spec)).model, *arguments)


def pictures_of(
    model: IcfModel, picture: Picture, scale: float
) -> tuple[float, dict[str, Picture], dict[str, Picture]]:
    """Return the picture before and after blur and equalisation, and its channels, by name.

    First comes the scale from which the channels are computed: the picture is prepared for that.
    """
    from nvcore.subjects.detectors.icf.displays import channels_of, computed_scale, preparation

    computed = computed_scale(model, picture, scale)
    steps, channels = (
        {name: _small(pixels) for name, pixels in every.items()}
        for every in (preparation(model, picture, computed), channels_of(model, picture, scale))
    )
    return computed, steps, channels


def _small(picture: Picture) -> Picture:
    height, width = picture.shape[:2]
    if width <= SHOWN_PX:
        return picture
    size = SHOWN_PX, max(1, round(height * SHOWN_PX / width))
    return np.asarray(cv2.resize(picture, size, interpolation=cv2.INTER_AREA))
