"""How the files of each source were read, as far as another look at them needs it."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from typing import Any, Final, Literal

MOST_NAMED: Final = 8
"""Kinds of what is left out that a text names."""


@dataclass(frozen=True)
class LeftOut:
    """Something in the files that a reading does not use.

    Attributes
    ----------
    kind
        ``class``: boxes of a class; ``box``: what is no box; ``picture``: files or pictures.
    name
        The class as the files call it; of others what they are ("polygon", "empty bbox").
    count
        How many boxes, objects or pictures.
    """

    kind: Literal["class", "box", "picture"]
    name: str
    count: int


@dataclass(frozen=True)
class ReadAs:
    """How a source was read.

    Attributes
    ----------
    boxes
        What the four numbers of a box were taken for (`nvcore.inputs.box_layouts`).
    has_score_beside
        Whether the score may stand before the four numbers as well as behind them.
    left_out
        What of the files is not used, the most first.
    format
        Name of the format, as it is given to a source; None: none that can be.
    usual
        Fields of a `nvcore.inputs.session.Source`, with what is taken where they are not given.
    """

    boxes: str = "sizes"
    has_score_beside: bool = False
    left_out: tuple[LeftOut, ...] = ()
    format: str | None = None
    usual: Mapping[str, Any] = field(default_factory=dict)


def left_out_text(left_out: Iterable[LeftOut]) -> str:
    """What is left out with its numbers, in words; empty for nothing.

    Examples
    --------
    >>> left_out_text([LeftOut("class", "car", 1200), LeftOut("class", "bicycle", 40)])
    'car (1,200), bicycle (40)'
    """
    every = list(left_out)
    texts = [f"{item.name} ({item.count:,})" for item in every[:MOST_NAMED]]
    if further := every[MOST_NAMED:]:
        texts.append(f"{len(further)} more ({sum(item.count for item in further):,})")
    return ", ".join(texts)
