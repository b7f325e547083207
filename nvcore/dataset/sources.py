"""How the files of each source were read, as far as another look at them needs it."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class ReadAs:
    """How a source was read.

    Attributes
    ----------
    boxes
        What the four numbers of a box were taken for (`nvcore.inputs.layouts`).
    has_score_beside
        Whether the score may stand before the four numbers as well as behind them.
    """

    boxes: str = "sizes"
    has_score_beside: bool = False
