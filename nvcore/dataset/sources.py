"""Interpretation of each source's files, for later looks at them."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from typing import Any, Final, Literal

MOST_NAMED: Final = 8
"""Most kinds of unused content that a text names."""


@dataclass(frozen=True)
class LeftOut:
    """Content of the files that a reading does not use.

    Attributes
    ----------
    kind
        ``class``: boxes of a class; ``box``: content that is no box; ``picture``: files or
        pictures.
    name
        Name of the class in the files, or description of the content ("polygon", "empty bbox").
    count
        Number of boxes, objects or pictures.
    """

    kind: Literal["class", "box", "picture"]
    name: str
    count: int


@dataclass(frozen=True)
class ReadAs:
    """Interpretation of a source's files.

    Attributes
    ----------
    boxes
        Meaning of the four numbers of a box (`nvcore.inputs.box_layouts`).
    has_score_beside
        True if the score may come before the four numbers as well as after them.
    left_out
        Unused content of the files, the most frequent first.
    format
        Name of the format as specified for a source; None if it cannot be specified.
    usual
        Default values of the fields of a `nvcore.inputs.session.Source`.
    """

    boxes: str = "sizes"
    has_score_beside: bool = False
    left_out: tuple[LeftOut, ...] = ()
    format: str | None = None
    usual: Mapping[str, Any] = field(default_factory=dict)


def left_out_text(left_out: Iterable[LeftOut]) -> str:
    """Describe the unused content with its numbers, or return "" for none.

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
