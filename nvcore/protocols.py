"""Evaluation protocols: which pedestrians count, said once for both systems."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from types import MappingProxyType
from typing import Final

import numpy as np

from nvcore.dataset import BoxColumns, Dataset
from nvcore.errors import InputError, ParameterError
from nvcore.schema import UNKNOWN_OCCLUSION

FLAGGED: Final = "flagged in the ground truth"
HEIGHT: Final = "height"
OCCLUSION: Final = "occlusion"
BORDER: Final = "border"
ASPECT: Final = "aspect ratio"

OCCLUSION_WORDS: Final = ("none", "partial", "heavy")
"""Levels of occlusion in words."""

Range = tuple[float, float]


@dataclass(frozen=True)
class Protocol:
    """Which pedestrians and recordings count; every filter is an option.

    A pedestrian that a filter leaves out is ignored: it is neither a miss nor, for who detects
    it, a false positive.

    Attributes
    ----------
    name, text
        Its name and one sentence.
    height_px
        Lowest and highest box, both included, pixels of the recording's own picture. The named
        protocols follow Caltech and KAIST, whose pictures are 480 and 512 px high: with other
        pictures the same number means another distance.
    occlusion
        Levels that count (0 none, 1 partial, 2 heavy). A box whose level is unknown counts where
        0 does.
    border_px
        Margins left, top, right, bottom inside which the whole box must lie, px; None: any place.
    aspect
        Lowest and highest ratio of height to width, both included.
    tags
        Tags that a recording must all have; (): every recording counts.
    expand
        Detections that are lower than the lowest height divided by this, or higher than the
        highest times this, are left out before matching (expanded filtering, Dollár et al. 2012,
        section 3.3); None: all detections are matched.

    Raises
    ------
    ParameterError
        If a value is outside its range.

    References
    ----------
    P. Dollár, C. Wojek, B. Schiele, P. Perona: Pedestrian detection: an evaluation of the state
    of the art, PAMI 2012. S. Hwang et al.: Multispectral pedestrian detection, CVPR 2015.
    """

    name: str
    text: str = ""
    height_px: Range = (0.0, math.inf)
    occlusion: tuple[int, ...] = (0, 1, 2)
    border_px: tuple[float, float, float, float] | None = None
    aspect: Range = (0.0, math.inf)
    tags: tuple[str, ...] = ()
    expand: float | None = None

    def __post_init__(self) -> None:
        for name in ("height_px", "aspect"):
            low, high = getattr(self, name)
            if not 0 <= low <= high:
                raise ParameterError(
                    f"{name}: expected 0 <= lowest <= highest, got {low:g} and {high:g}"
                )
        if not self.occlusion or not set(self.occlusion) <= {0, 1, 2}:
            raise ParameterError(
                f"occlusion: expected one or more of 0, 1, 2, got {self.occlusion!r}"
            )
        if self.border_px is not None and not all(0 <= side < math.inf for side in self.border_px):
            raise ParameterError(f"border_px: expected four margins, got {self.border_px!r}")
        if self.expand is not None and not 1 <= self.expand < math.inf:
            raise ParameterError(f"expand: expected 1 or more, got {self.expand:g}")

    @property
    def filters(self) -> tuple[str, ...]:
        """What it asks for, in words; empty where it takes what the ground truth does not flag."""
        parts = []
        if self.height_px != (0, math.inf):
            parts.append(f"height {_range(self.height_px)} px")
        if set(self.occlusion) != {0, 1, 2}:
            parts.append("occlusion " + " or ".join(OCCLUSION_WORDS[i] for i in self.occlusion))
        if self.border_px is not None:
            sides = self.border_px
            margins = (
                f"{sides[0]:g} px"
                if len(set(sides)) == 1
                else ", ".join(f"{side:g}" for side in sides) + " px (left, top, right, bottom)"
            )
            parts.append(f"whole box at least {margins} inside the picture")
        if self.aspect != (0, math.inf):
            parts.append(f"height / width {_range(self.aspect)}")
        if self.tags:
            parts.append("recordings tagged " + " and ".join(self.tags))
        if self.expand is not None and self.height_px != (0, math.inf):
            low, high = self.height_px
            parts.append(f"detections {_range((low / self.expand, high * self.expand))} px high")
        return tuple(parts)


def _range(limits: Range) -> str:
    low, high = limits
    if high == math.inf:
        return f"{low:g} or more"
    return f"{high:g} or less" if low == 0 else f"{low:g} to {high:g}"


_CALTECH: Final = Protocol(
    "reasonable",
    "Pedestrians of 50 px or more that are at most partly occluded, as on Caltech.",
    height_px=(50, math.inf), occlusion=(0, 1), border_px=(5, 5, 5, 5), expand=1.25,
)  # fmt: skip

_NAMED: Final = (
    Protocol("all", "Every pedestrian that the ground truth does not flag as ignored."),
    _CALTECH,
    replace(_CALTECH, name="near", text="Unoccluded pedestrians of 80 px or more, as on Caltech.",
            height_px=(80, math.inf), occlusion=(0,)),
    replace(_CALTECH, name="medium", text="Unoccluded pedestrians of 30 to 80 px, as on Caltech.",
            height_px=(30, 80), occlusion=(0,)),
    replace(_CALTECH, name="far", text="Unoccluded pedestrians of 20 to 30 px, as on Caltech.",
            height_px=(20, 30), occlusion=(0,)),
    replace(_CALTECH, name="occlusion", occlusion=(1, 2),
            text="Partly or heavily occluded pedestrians of 50 px or more."),
    Protocol("kaist-reasonable",
             "Pedestrians of 55 px or more, at most partly occluded, not at the border: KAIST.",
             height_px=(55, math.inf), occlusion=(0, 1), border_px=(5, 5, 5, 5)),
)  # fmt: skip

PROTOCOLS: Final[Mapping[str, Protocol]] = MappingProxyType({one.name: one for one in _NAMED})
"""The named protocols; their heights are pixels of pictures 480 (Caltech) or 512 px (KAIST) high.

The border rule of both is x 5..635 in pictures 640 px wide, y 5..475 and 5..507.
"""


@dataclass(frozen=True, eq=False)
class FilteredTruth:
    """The ground truth under a protocol: the same set for every system.

    Attributes
    ----------
    protocol
        What was asked for.
    truth
        The same boxes in the same rows, with those that the protocol leaves out ignored.
    is_counted
        Frames of the recordings that count; bool, (n_frames,).
    n_left_out
        Boxes that the ground truth flags, and the others that each filter leaves out, by filter;
        a box that several leave out counts for each.
    n_unknown_occlusion
        Boxes not flagged whose occlusion is unknown.
    """

    protocol: Protocol
    truth: BoxColumns
    is_counted: np.ndarray
    n_left_out: Mapping[str, int]
    n_unknown_occlusion: int

    @property
    def counts(self) -> np.ndarray:
        """Truth boxes that count: not ignored, in a counted frame; bool, (n_truth,)."""
        counts: np.ndarray = ~self.truth.ignore & self.is_counted[self.truth.frame_index]
        return counts

    @property
    def n_truth(self) -> int:
        """Pedestrian boxes that count."""
        return int(np.count_nonzero(self.counts))

    @property
    def n_images(self) -> int:
        """Frames that count, with and without boxes."""
        return int(np.count_nonzero(self.is_counted))


def filter_truth(
    dataset: Dataset, protocol: Protocol, *, recordings: np.ndarray | None = None
) -> FilteredTruth:
    """The ground truth under a protocol; nothing is deleted, left-out boxes become ignored.

    Parameters
    ----------
    recordings
        Recordings that may count, beside the protocol's tags; bool, (n_recordings,); None: all.

    Raises
    ------
    InputError
        If no recording is left.
    """
    truth, frames = dataset.truth, dataset.frame_columns
    chosen = has_tags(dataset, protocol.tags)
    if recordings is not None:
        chosen = chosen & recordings
    is_counted: np.ndarray = chosen[frames.recording]
    if not is_counted.any():
        raise InputError(_no_recording(dataset, protocol))
    occlusion = dataset.boxes["occlusion"].to_numpy()[: len(truth)]
    recording = frames.recording[truth.frame_index]
    is_out = {
        HEIGHT: ~_between(truth.h, protocol.height_px),
        OCCLUSION: ~np.isin(np.where(occlusion == UNKNOWN_OCCLUSION, 0, occlusion),
                            protocol.occlusion),
        BORDER: _at_border(truth, frames.width[recording], frames.height[recording],
                           protocol.border_px),
        ASPECT: ~_between(truth.h / truth.w, protocol.aspect),
    }  # fmt: skip
    here = is_counted[truth.frame_index]
    unflagged = here & ~truth.ignore
    n_left_out = {FLAGGED: int(np.count_nonzero(here & truth.ignore))} | {
        name: int(np.count_nonzero(unflagged & out)) for name, out in is_out.items()
    }
    ignore = np.logical_or.reduce([truth.ignore, *is_out.values()])
    unknown = unflagged & (occlusion == UNKNOWN_OCCLUSION)
    return FilteredTruth(
        protocol, replace(truth, ignore=ignore), is_counted, MappingProxyType(n_left_out),
        int(np.count_nonzero(unknown)),
    )  # fmt: skip


def filter_detections(detections: BoxColumns, protocol: Protocol) -> np.ndarray:
    """Detections that the protocol lets take part; bool, (n_det,)."""
    if protocol.expand is None:
        return np.ones(len(detections), dtype=bool)
    low, high = protocol.height_px
    return _between(detections.h, (low / protocol.expand, high * protocol.expand))


def has_tags(dataset: Dataset, tags: tuple[str, ...]) -> np.ndarray:
    """Recordings that have all of the tags; bool, (n_recordings,)."""
    wanted = set(tags)
    found = [wanted <= set(own) for own in dataset.recordings["tags"]]  # hundreds at the most
    return np.array(found, dtype=bool)


def known_tags(dataset: Dataset) -> tuple[str, ...]:
    """All tags of the recordings, sorted."""
    return tuple(sorted({tag for own in dataset.recordings["tags"] for tag in own}))


def _no_recording(dataset: Dataset, protocol: Protocol) -> str:
    known = ", ".join(known_tags(dataset)) or "none: give tags in the session file"
    wanted = " and ".join(protocol.tags)
    what = f"has the tags {wanted}" if protocol.tags else "is chosen"
    return f"protocol {protocol.name!r}: no recording with frames {what}; there are tags {known}"


def _between(values: np.ndarray, limits: Range) -> np.ndarray:
    inside: np.ndarray = (values >= limits[0]) & (values <= limits[1])
    return inside


def _at_border(
    boxes: BoxColumns,
    width: np.ndarray,
    height: np.ndarray,
    margins: tuple[float, float, float, float] | None,
) -> np.ndarray:
    """Boxes that reach into the margins of their picture; bool, (n,)."""
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
