"""Training pictures before they are read, and their scenes, which are read on request."""

from __future__ import annotations

from collections.abc import Callable, Hashable, Sequence
from dataclasses import dataclass, field
from typing import Final, TypeVar

import numpy as np
from numpy.typing import NDArray

from nvcore.common.errors import MediaError
from nvcore.common.progress import Progress, no_progress
from nvcore.common.wording import one_line
from nvcore.dataset.provenance import TrainedOn
from nvcore.pictures import Picture
from nvcore.subjects.detectors.icf.channels import has_colour
from nvcore.subjects.detectors.icf.windows import NO_BOXES, LazyScenes, Scene

Group = TypeVar("Group", bound=Hashable)
MOST_BYTES: Final = 1 << 29
"""Maximum memory for cached pictures. All others are read again on each request."""


@dataclass(frozen=True, eq=False)
class Shot:
    """Training picture with its objects. Boxes are (n, 4): x, y, w, h in px.

    Attributes
    ----------
    read
        Reads the picture; raises `MediaError` if that fails.
    source
        Recording or folder. The pictures of one source are all used in colour or all in grey.
    learned
        Boxes of the objects to learn.
    held_out
        Boxes of the objects that calibrate the rejection.
    ignored
        Regions that are neither object nor background.
    has_background
        Whether the rest of the picture is background to learn from.
    labels
        Class of each box to learn, "" if unknown. Empty: no classes.
    """

    read: Callable[[], Picture]
    source: str
    learned: NDArray[np.float64] = field(default_factory=lambda: NO_BOXES)
    held_out: NDArray[np.float64] = field(default_factory=lambda: NO_BOXES)
    ignored: NDArray[np.float64] = field(default_factory=lambda: NO_BOXES)
    has_background: bool = True
    labels: tuple[str, ...] = ()


@dataclass(frozen=True, eq=False)
class TrainingData:
    """Pictures and boxes of a training, from a session, folders, or both.

    Attributes
    ----------
    shots
        Pictures in the order of recordings and frames, then of the paths of crops and background.
    trained_on
        Recordings and frames, including those held out, and fingerprints of folders.
    every
        One in this many evaluated frames is used.
    held_out
        Description of the held-out part, empty if nothing can be held out.
    notes
        Recordings and frames without a picture, and the number of skipped boxes.
    """

    shots: Sequence[Shot] = ()
    trained_on: tuple[TrainedOn, ...] = ()
    every: int = 1
    held_out: str = ""
    notes: tuple[str, ...] = ()


class PictureStore:
    """Scenes of the shots with readable pictures. Pictures that fit into memory are read once.

    Attributes
    ----------
    faults
        Reasons why pictures cannot be read, by shot.
    """

    def __init__(
        self, shots: Sequence[Shot], most_bytes: int = MOST_BYTES, progress: Progress = no_progress
    ) -> None:
        self.shots = shots
        self.faults: dict[int, str] = {}
        self._in_memory: dict[int, Picture] = {}
        self._in_colour: set[str] = set()
        for i, shot in enumerate(shots):  # sequentially, which is fast for videos
            progress(i / len(shots), "reading pictures")
            try:
                picture = _plain(shot.read())
            except MediaError as error:
                self.faults[i] = one_line(str(error))
                continue
            if picture.ndim == 3:
                self._in_colour.add(shot.source)
            if picture.nbytes <= most_bytes:
                most_bytes -= picture.nbytes
                self._in_memory[i] = picture

    def picture(self, index: int) -> Picture:
        """Return the picture of a shot, in grey unless any picture of its source has colour."""
        picture = self._in_memory.get(index)
        if picture is None:
            picture = _plain(self.shots[index].read())
        if picture.ndim == 2 and self.shots[index].source in self._in_colour:
            picture = np.repeat(picture[..., None], 3, axis=2)
        return picture

    def scenes(self) -> tuple[LazyScenes, LazyScenes]:
        """Return the scenes to train on, and those of held-out objects."""

        def learned(i: int) -> Scene:
            shot = self.shots[i]
            ignored = np.concatenate([shot.ignored, shot.held_out])
            return Scene(self.picture(i), shot.learned, ignored, shot.has_background, shot.labels)

        def held_out(i: int) -> Scene:
            return Scene(self.picture(i), self.shots[i].held_out, has_background=False)

        readable = [(i, shot) for i, shot in enumerate(self.shots) if i not in self.faults]
        return (
            LazyScenes(learned, [i for i, s in readable if s.has_background or len(s.learned)]),
            LazyScenes(held_out, [i for i, s in readable if len(s.held_out)]),
        )


def _plain(picture: Picture) -> Picture:
    """Reduce a picture to one channel if all channels are equal."""
    if picture.ndim == 3 and not has_colour(picture):
        return np.ascontiguousarray(picture[..., 0])
    return picture


def hold_out_groups(
    groups: Sequence[Group], share: float, seed: int
) -> tuple[NDArray[np.bool_], list[Group]]:
    """Hold out whole groups, so that no group is on both sides.

    Groups are recordings, or physical objects, since pictures of one group are alike.

    Parameters
    ----------
    groups
        Group of each item, (n,).
    share
        Share of the groups to hold out, rounded. With two or more groups, at least one is held out
        and at least one is not.

    Returns
    -------
    Whether each item is held out, bool, (n,), and the groups held out, in their order.
    """
    names = list(dict.fromkeys(groups))
    n_out = max(0, min(max(1, round(share * len(names))), len(names) - 1))
    chosen = np.random.default_rng(seed).permutation(len(names))[:n_out]
    out = [names[i] for i in sorted(chosen)]
    held_out = {*out}
    return np.array([group in held_out for group in groups], np.bool_), out
