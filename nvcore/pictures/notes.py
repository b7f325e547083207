"""Notes about pictures that may make them show other frames than one expects."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum
from typing import Final

from nvcore.common.wording import count_text, listed, one_line

MOST_PLACES: Final = 100
"""Number of places that a note names."""


class PictureTrait(StrEnum):
    """Unusual property of pictures. `_TEXTS` words it."""

    CUT = "cut"
    GAP = "gap"
    UNEVEN = "uneven"
    REPEATED = "repeated"
    OTHER_STREAMS = "other streams"
    PASSED_OVER = "passed over"
    FURTHER_PAGES = "further pages"


MAY_MISLEAD: Final = frozenset({PictureTrait.CUT, PictureTrait.GAP, PictureTrait.UNEVEN})
"""Traits because of which a frame may show no picture, or that of its neighbour."""

_TEXTS: Final = {
    PictureTrait.CUT: (
        "picture{of_total} can be read: the file is damaged or cut off",
        "pictures{of_total} can be read: the file is damaged or cut off",
    ),
    PictureTrait.GAP: (
        "picture is missing by the video's times, before picture {place}",
        "pictures are missing by the video's times, the first before picture {place}",
    ),
    PictureTrait.UNEVEN: (
        "step{of_total} between the times of pictures differs from the usual one: the rate varies",
        "steps{of_total} between the times of pictures differ from the usual one: the rate varies",
    ),
    PictureTrait.REPEATED: (
        "picture of the video is empty and repeats the one before, picture {place}",
        "pictures of the video are empty and repeat the one before, the first is picture {place}",
    ),
    PictureTrait.OTHER_STREAMS: (
        "further stream of pictures in the file is not shown ({names})",
        "further streams of pictures in the file are not shown ({names})",
    ),
    PictureTrait.PASSED_OVER: (
        "file beside the pictures is not of their series and is passed over ({names})",
        "files beside the pictures are not of their series and are passed over ({names})",
    ),
    PictureTrait.FURTHER_PAGES: (
        "further page in each file is not shown (as in {names})",
        "further pages in each file are not shown (as in {names})",
    ),
}
"""Text after `PictureNote.count`, singular and plural."""


@dataclass(frozen=True)
class PictureNote:
    """A trait of the pictures of one recording.

    Attributes
    ----------
    count, total
        Number that has the trait, and number in all (0: unknown): of pictures, or for UNEVEN of
        steps between their times, or of streams, files or pages.
    places
        Indices of the first pictures that have it; for GAP, of those after a gap; ascending.
    names
        Names of the first files or streams that have it.
    """

    trait: PictureTrait
    count: int
    total: int = 0
    places: tuple[int, ...] = ()
    names: tuple[str, ...] = ()

    @property
    def text(self) -> str:
        """The note in words, without a full stop. Pictures are counted from 0."""
        names = listed([*map(one_line, self.names)])
        if self.count > len(self.names) > 0 and self.trait is not PictureTrait.FURTHER_PAGES:
            names += f" and {self.count - len(self.names):,} more"
        return count_text(self.count, *_TEXTS[self.trait]).format(
            of_total=f" of {self.total:,}" if self.total else "",
            place=self.places[0] if self.places else "",
            names=names,
        )
