"""Ground truth under a protocol: one set of pedestrians for both systems."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from types import MappingProxyType
from typing import Final

import numpy as np

from nvcore.common.errors import InputError
from nvcore.dataset import Dataset
from nvcore.dataset.columns import BoxColumns
from nvcore.dataset.schema import UNKNOWN_OCCLUSION
from nvcore.settings.protocols import Protocol, Range

FLAGGED: Final = "flagged in the ground truth"
HEIGHT: Final = "height"
OCCLUSION: Final = "occlusion"
BORDER: Final = "border"
ASPECT: Final = "aspect ratio"


@dataclass(frozen=True, eq=False)
class FilteredTruth:
    """Ground truth under a protocol, the same set for every system.

    Attributes
    ----------
    protocol
        Protocol that selects the pedestrians.
    truth
        The same boxes in the same rows, with boxes excluded by the protocol marked as ignored.
    is_counted
        Frames of the recordings that count; bool, (n_frames,).
    n_left_out
        Numbers of boxes that the ground truth flags, and of unflagged boxes that each filter
        excludes, by filter. A box excluded by several filters counts for each.
    n_unknown_occlusion
        Number of unflagged boxes whose occlusion is unknown.
    """

    protocol: Protocol
    truth: BoxColumns
    is_counted: np.ndarray
    n_left_out: Mapping[str, int]
    n_unknown_occlusion: int

    @property
    def counts(self) -> np.ndarray:
        """Truth boxes that count (not ignored, in a counted frame), bool, (n_truth,)."""
        counts: np.ndarray = ~self.truth.ignore & self.is_counted[self.truth.frame_index]
        return counts

    @property
    def n_truth(self) -> int:
        """Number of pedestrian boxes that count."""
        return int(np.count_nonzero(self.counts))

    @property
    def n_ignored(self) -> int:
        """Number of truth boxes in the counted frames that do not count."""
        return int(np.count_nonzero(self.truth.ignore & self.is_counted[self.truth.frame_index]))

    @property
    def left_out(self) -> str:
        """Sentence with the number of ignored boxes and the reasons, or "" if there are none."""
        if not self.n_ignored:
            return ""
        n_by = {name: n for name, n in self.n_left_out.items() if n}
        parts = [name if name == FLAGGED else f"by {name}" for name in n_by]
        if len(parts) > 1:
            parts = [f"{n:,} {part}" for n, part in zip(n_by.values(), parts, strict=True)]
        has_several = sum(self.n_left_out.values()) > self.n_ignored
        several = " (a box that several of these leave out is counted for each)"
        return f"{self.n_ignored:,} ignored: {', '.join(parts)}{several if has_several else ''}"

    @property
    def n_images(self) -> int:
        """Number of frames that count, with and without boxes."""
        return int(np.count_nonzero(self.is_counted))


def filter_truth(
    dataset: Dataset, protocol: Protocol, *, recordings: np.ndarray | None = None
) -> FilteredTruth:
    """Apply a protocol to the ground truth.

    Nothing is deleted: excluded boxes become ignored.

    Parameters
    ----------
    recordings
        Recordings that may count, in addition to the protocol's own choice; bool, (n_recordings,);
        None: all.

    Raises
    ------
    InputError
        If no recording is left, or the protocol names one that does not exist.
    """
    truth, frames = dataset.truth, dataset.frame_columns
    is_chosen = has_tags(dataset, protocol.tags) & _is_named(dataset, protocol)
    if recordings is not None:
        is_chosen = is_chosen & recordings
    is_counted: np.ndarray = is_chosen[frames.recording]
    if not is_counted.any():
        raise InputError(_no_recording(dataset, protocol))
    occlusion = dataset.boxes["occlusion"].to_numpy()[: len(truth)]
    recording = frames.recording[truth.frame_index]
    width, height = frames.width[recording], frames.height[recording]
    occlusion_or_0 = np.where(occlusion == UNKNOWN_OCCLUSION, 0, occlusion)
    is_out = {
        HEIGHT: ~_between(truth.h, protocol.height_px),
        OCCLUSION: ~np.isin(occlusion_or_0, protocol.occlusion),
        BORDER: _at_border(truth, width, height, protocol.border_px),
        ASPECT: ~_between(truth.h / truth.w, protocol.aspect),
    }
    is_here = is_counted[truth.frame_index]
    is_unflagged = is_here & ~truth.ignore
    n_left_out = {FLAGGED: int(np.count_nonzero(is_here & truth.ignore))} | {
        name: int(np.count_nonzero(is_unflagged & out)) for name, out in is_out.items()
    }
    ignore = np.logical_or.reduce([truth.ignore, *is_out.values()])
    is_unknown = is_unflagged & (occlusion == UNKNOWN_OCCLUSION)
    return FilteredTruth(
        protocol=protocol,
        truth=replace(truth, ignore=ignore),
        is_counted=is_counted,
        n_left_out=MappingProxyType(n_left_out),
        n_unknown_occlusion=int(np.count_nonzero(is_unknown)),
    )


def filter_detections(detections: BoxColumns, protocol: Protocol) -> np.ndarray:
    """Return which detections take part in the protocol, bool, (n_det,)."""
    if protocol.expand is None:
        return np.ones(len(detections), dtype=bool)
    low, high = protocol.height_px
    return _between(detections.h, (low / protocol.expand, high * protocol.expand))


def has_tags(dataset: Dataset, tags: tuple[str, ...]) -> np.ndarray:
    """Return which recordings have all of the tags, bool, (n_recordings,)."""
    required = set(tags)
    # a loop over recordings: hundreds at most
    has_all = [required <= set(recording_tags) for recording_tags in dataset.recordings["tags"]]
    return np.array(has_all, dtype=bool)


def _is_named(dataset: Dataset, protocol: Protocol) -> np.ndarray:
    """Return which recordings the protocol selects by name, bool, (n_recordings,)."""
    names = dataset.recordings["name"]
    if not protocol.recordings:
        return np.ones(len(names), dtype=bool)
    unknown = sorted(set(protocol.recordings) - set(names))
    if unknown:
        raise InputError(
            f"protocol {protocol.name!r}: there is no recording {unknown[0]!r}; there are "
            f"{len(names)}, the first is {names.iloc[0]!r}"
        )
    is_named: np.ndarray = names.isin(protocol.recordings).to_numpy()
    return is_named


def known_tags(dataset: Dataset) -> tuple[str, ...]:
    """Return all tags of the recordings, sorted."""
    return tuple(sorted({tag for tags in dataset.recordings["tags"] for tag in tags}))


def _no_recording(dataset: Dataset, protocol: Protocol) -> str:
    if not len(dataset.frames):
        return "there are no frames"
    tags = known_tags(dataset)
    available = (
        f"there are tags {', '.join(tags)}" if tags else "none has tags, which a session file gives"
    )
    required = " and ".join(protocol.tags)
    condition = f"has the tags {required}" if protocol.tags else "is chosen"
    if protocol.tags and protocol.recordings:
        condition += " and is one of those chosen by name"
    return f"protocol {protocol.name!r}: no recording with frames {condition} ({available})"


def _between(values: np.ndarray, limits: Range) -> np.ndarray:
    inside: np.ndarray = (values >= limits[0]) & (values <= limits[1])
    return inside


def _at_border(
    boxes: BoxColumns,
    width: np.ndarray,
    height: np.ndarray,
    margins: tuple[float, float, float, float] | None,
) -> np.ndarray:
    """Return which boxes reach into the margins of their picture, bool, (n,)."""
    if margins is None:
        return np.zeros(len(boxes), dtype=bool)
    left, top, right, bottom = margins
    reaches: np.ndarray = (
        (boxes.x < left)
        | (boxes.y < top)
        | (boxes.x + boxes.w > width - right)
        | (boxes.y + boxes.h > height - bottom)
    )
    return reaches
