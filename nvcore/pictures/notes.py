"""Facts about a recording's pictures that may make them show other frames than one expects."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum
from typing import Final

from nvcore.wording import count_text, listed, one_line

MOST_PLACES: Final = 100
"""Of a note."""


class PictureTrait(StrEnum):
    """What is unusual about pictures."""

    CUT = "cut"
    """The file ends early or is damaged: `count` pictures can be read, `total` are stated."""
    GAP = "gap"
    """The times leave out `count` pictures, before the pictures at `places`."""
    UNEVEN = "uneven"
    """`count` of `total` steps between the times differ from the commonest: the rate varies."""
    REPEATED = "repeated"
    """The file holds nothing for the `count` pictures at `places`: each shows the one before."""
    OTHER_STREAMS = "other streams"
    """`count` further streams of pictures are in the file and are not shown, of these `names`."""
    PASSED_OVER = "passed over"
    """`count` files lie beside the pictures and are not taken for one of them, of these `names`."""
    FURTHER_PAGES = "further pages"
    """Each file holds `count` further pages, which are not shown, as the one of these `names`."""


MAY_MISLEAD: Final = frozenset({PictureTrait.CUT, PictureTrait.GAP, PictureTrait.UNEVEN})
"""With these a frame may have no picture, or its neighbour's: they are told beside the pictures."""

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
"""What follows `PictureNote.count`: of one and of several."""


@dataclass(frozen=True)
class PictureNote:
    """A fact about the pictures of one recording; `trait` says what the others mean.

    Attributes
    ----------
    count, total
        How many, and out of how many; 0: not known.
    places
        Indices of pictures, ascending; where they are many, the first ones.
    names
        Of files or streams; where they are many, the first ones.
    """

    trait: PictureTrait
    count: int
    total: int = 0
    places: tuple[int, ...] = ()
    names: tuple[str, ...] = ()

    @property
    def text(self) -> str:
        """The fact in words, without a full stop; pictures are counted from 0."""
        names = listed([*map(one_line, self.names)])
        if self.count > len(self.names) > 0 and self.trait is not PictureTrait.FURTHER_PAGES:
            names += f" and {self.count - len(self.names):,} more"
        return count_text(self.count, *_TEXTS[self.trait]).format(
            of_total=f" of {self.total:,}" if self.total else "",
            place=self.places[0] if self.places else "",
            names=names,
        )
