"""What of a session is trained on, and what is held out: by object, by recording, by time."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from nvcore.dataset import Dataset
from nvcore.detectors.arguments import SplitBy, TrainArguments
from nvcore.detectors.training.groups import by_group, by_time
from nvcore.errors import InputError, ParameterError
from nvcore.schema import NO_TRACK
from nvcore.settings import as_names
from nvcore.wording import MOST_NAMED, did_you_mean, listed, one_line

_LEAST_RECORDINGS: Final = 4
"""From so many recordings on, whole ones are held out where objects are not told apart."""


class HeldOut:
    """What is held out of the chosen frames.

    Parameters
    ----------
    rows
        Of the frames table, those chosen, ascending.
    objects
        Rows of the truth's boxes to learn in these frames, at least one.
    arguments
        By what, and which.

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
        self,
        dataset: Dataset,
        rows: NDArray[np.int64],
        objects: NDArray[np.int64],
        arguments: TrainArguments,
    ) -> None:
        self._dataset, self._rows, self._objects = dataset, rows, objects
        self.is_held_out = np.zeros(len(dataset.truth), np.bool_)
        self.has_background = np.ones(len(dataset.frames), np.bool_)
        self.is_left_out = np.zeros(len(dataset.frames), np.bool_)
        if arguments.hold_out:
            self.words = self._named(as_names(arguments.hold_out))
        else:
            split = self._possible() if arguments.split == "auto" else arguments.split
            by = {"object": self._by_object, "recording": self._by_recording, "time": self._by_time}
            self.words = by[split](arguments)

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

    def _by_recording(self, arguments: TrainArguments) -> str:
        recording = self._recording
        is_out = by_group(recording.tolist(), arguments.share, arguments.seed)
        if not is_out.any():
            raise ParameterError(
                "split: a single recording cannot be split by recording; split by object or time"
            )
        self._hold_out_frames(self._rows[is_out])
        return one_line(listed(list(dict.fromkeys(recording[is_out].tolist()))))

    def _by_time(self, arguments: TrainArguments) -> str:
        frames = self._dataset.frame_columns
        is_trained, is_out = by_time(
            frames.recording[self._rows].astype(np.int64),
            frames.frame[self._rows],
            arguments.share,
            arguments.gap,
        )
        self._hold_out_frames(self._rows[is_out])
        self.is_left_out[self._rows[~is_trained & ~is_out]] = True
        return f"the last {100 * arguments.share:g} % of each recording"

    def _by_object(self, arguments: TrainArguments) -> str:
        if (self._track == NO_TRACK).any():
            raise ParameterError(
                "split: the truth has boxes without a track, so that it is not known which are of "
                "one object; split by recording or time"
            )
        recording = self._dataset.frame_columns.recording[
            self._dataset.truth.frame_index[self._objects]
        ]
        groups = list(zip(recording.tolist(), self._track.tolist(), strict=True))
        is_out = by_group(groups, arguments.share, arguments.seed)
        self.is_held_out[self._objects[is_out]] = True
        n_out = len({group for group, out in zip(groups, is_out, strict=True) if out})
        return f"{n_out} of {len(set(groups))} physical objects"

    def _hold_out_frames(self, rows: NDArray[np.int64]) -> None:
        self.has_background[rows] = False
        frame = self._dataset.truth.frame_index[self._objects]
        self.is_held_out[self._objects[np.isin(frame, rows)]] = True
