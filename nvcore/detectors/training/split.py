"""What of a session is trained on, and what is held out: by object, by recording, by time."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Final, Literal, get_args

import numpy as np
from numpy.typing import NDArray

from nvcore.dataset import Dataset
from nvcore.detectors.training.groups import by_group, by_time
from nvcore.errors import InputError, ParameterError
from nvcore.schema import NO_TRACK
from nvcore.wording import MOST_NAMED, did_you_mean, listed, one_line

SplitBy = Literal["auto", "object", "recording", "time"]

_LEAST_RECORDINGS: Final = 4
"""From so many recordings on, whole ones are held out where objects are not told apart."""


@dataclass(frozen=True, kw_only=True)
class Choice:
    """Which frames and boxes of a session are learned, and which are held out.

    What is held out calibrates the rejection, so that it counts as trained on, too.

    Attributes
    ----------
    frames
        Only these of the evaluated ones: a range (`nvcore.inputs.facts.frame_range`), or the path
        of a file with one number a line; None: all.
    every
        Only every so many evaluated frames; None: as many as keep the boxes below 5,000.
    hold_out
        Names of recordings held out; they decide the split where there are any.
    split
        By which the rest is held out: physical ``object`` (tracks), ``recording``, ``time`` (the
        end of each recording), or ``auto``: the first of these that is possible.
    share
        Of objects, recordings or time held out.
    seed
        Of the objects and recordings that are drawn to be held out.
    gap
        Frames before the held-out end of a recording that are on neither side.
    least_height
        Lower boxes, px, are neither object nor background; None: those that the smallest scale
        is too large for.

    Raises
    ------
    ParameterError
        If a value is not possible.
    """

    frames: str | None = None
    every: int | None = None
    hold_out: tuple[str, ...] = ()
    split: SplitBy = "auto"
    share: float = 0.1
    seed: int = 0
    gap: int = 20
    least_height: float | None = None

    def __post_init__(self) -> None:
        if self.split not in get_args(SplitBy):
            expected = listed(get_args(SplitBy))
            raise ParameterError(f"split: expected one of {expected}, got {self.split!r}")
        if self.every is not None and self.every < 1:
            raise ParameterError(f"every: expected 1 or more frames, got {self.every}")
        if self.gap < 0:
            raise ParameterError(f"gap: expected 0 or more frames, got {self.gap}")
        if not 0 < self.share < 1:
            raise ParameterError(f"share: expected more than 0 and less than 1, got {self.share:g}")
        if self.least_height is not None and not self.least_height >= 0:
            raise ParameterError(f"least_height: expected 0 px or more, got {self.least_height:g}")


class HeldOut:
    """What is held out of the chosen frames.

    Parameters
    ----------
    rows
        Of the frames table, those chosen, ascending.
    objects
        Rows of the truth's boxes to learn in these frames, at least one.
    choice
        By what.

    Attributes
    ----------
    is_held_out
        Boxes of the truth, bool, (n_truth,).
    has_background
        Rows of the frames table that are trained on, bool, (n_frames,).
    is_left_out
        Rows that are on neither side, bool, (n_frames,).
    words
        What was held out.
    """

    def __init__(
        self, dataset: Dataset, rows: NDArray[np.int64], objects: NDArray[np.int64], choice: Choice
    ) -> None:
        self._dataset, self._rows, self._objects = dataset, rows, objects
        self.is_held_out = np.zeros(len(dataset.truth), np.bool_)
        self.has_background = np.ones(len(dataset.frames), np.bool_)
        self.is_left_out = np.zeros(len(dataset.frames), np.bool_)
        if choice.hold_out:
            self.words = self._named(choice.hold_out)
        else:
            split = self._possible() if choice.split == "auto" else choice.split
            by = {"object": self._by_object, "recording": self._by_recording, "time": self._by_time}
            self.words = by[split](choice)

    @property
    def _recording(self) -> NDArray[Any]:
        """Name of the recording of each row."""
        names = self._dataset.recordings["name"].to_numpy()
        of_rows: NDArray[Any] = names[self._dataset.frame_columns.recording[self._rows]]
        return of_rows

    @property
    def _track(self) -> NDArray[np.int64]:
        """Track of each object."""
        track: NDArray[np.int64] = self._dataset.truth.track[self._objects]
        return track

    def _possible(self) -> SplitBy:
        if (self._track != NO_TRACK).all():
            return "object"
        return "recording" if len(set(self._recording)) >= _LEAST_RECORDINGS else "time"

    def _named(self, names: Sequence[str]) -> str:
        known = list(dict.fromkeys(self._recording.tolist()))
        for name in names:
            if name in self._dataset.recordings["name"].tolist() and name not in known:
                raise InputError(
                    f"hold_out: {name!r} has no evaluated frame with a picture (among frames, if "
                    "these are given)"
                )
            if name not in known:
                there = f"those here are {listed(known, most=MOST_NAMED)}"
                raise InputError(
                    f"hold_out: there is no recording {name!r}, or it is not among those chosen "
                    f"(only, tags); {did_you_mean(name, known, there)}"
                )
        if not {*known} - {*names}:
            raise InputError(
                "hold_out: every recording chosen is held out; one at least must be left to learn "
                "from"
            )
        self._hold_out_frames(self._rows[np.isin(self._recording, names)])
        return one_line(listed(names))

    def _by_recording(self, choice: Choice) -> str:
        recording = self._recording
        is_out = by_group(recording.tolist(), choice.share, choice.seed)
        if not is_out.any():
            raise ParameterError(
                "split: a single recording cannot be split by recording; split by object or time"
            )
        self._hold_out_frames(self._rows[is_out])
        return one_line(listed(list(dict.fromkeys(recording[is_out].tolist()))))

    def _by_time(self, choice: Choice) -> str:
        frames = self._dataset.frame_columns
        is_trained, is_out = by_time(
            frames.recording[self._rows].astype(np.int64),
            frames.frame[self._rows],
            choice.share,
            choice.gap,
        )
        self._hold_out_frames(self._rows[is_out])
        self.is_left_out[self._rows[~is_trained & ~is_out]] = True
        return f"the last {100 * choice.share:g} % of each recording"

    def _by_object(self, choice: Choice) -> str:
        if (self._track == NO_TRACK).any():
            raise ParameterError(
                "split: the truth has boxes without a track, so that it is not known which are of "
                "one object; split by recording or time"
            )
        recording = self._dataset.frame_columns.recording[
            self._dataset.truth.frame_index[self._objects]
        ]
        groups = list(zip(recording.tolist(), self._track.tolist(), strict=True))
        is_out = by_group(groups, choice.share, choice.seed)
        self.is_held_out[self._objects[is_out]] = True
        n_out = len({group for group, out in zip(groups, is_out, strict=True) if out})
        return f"{n_out} of {len(set(groups))} physical objects"

    def _hold_out_frames(self, rows: NDArray[np.int64]) -> None:
        self.has_background[rows] = False
        frame = self._dataset.truth.frame_index[self._objects]
        self.is_held_out[self._objects[np.isin(frame, rows)]] = True
