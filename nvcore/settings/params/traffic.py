"""Traffic context of a recording: from 0, urban, to 1, rural."""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import Final

from nvcore.common.wording import listed

CONTEXTS: Final = {"urban": 0.0, "rural": 1.0}
"""Words for the two ends of the scale."""
UNSTATED: Final = 0.0
"""Context of a recording that does not state it."""


def parse_context(value: object) -> float:
    """Convert a word, a number, or a number as text to a context from 0 to 1.

    Raises
    ------
    ValueError
        If it is something else, or out of range.

    Examples
    --------
    >>> parse_context("rural"), parse_context(0.3)
    (1.0, 0.3)
    """
    number = CONTEXTS.get(value.strip().lower()) if isinstance(value, str) else None
    if number is None and isinstance(value, int | float | str) and not isinstance(value, bool):
        try:
            number = float(value)
        except (ValueError, OverflowError):
            number = None
    if number is None or not 0 <= number <= 1:
        raise ValueError(f"expected urban, rural or a number from 0 to 1, found {value!r}")
    return number


def context_word(value: float) -> str | float:
    """Return the word for an end of the scale, or else the number.

    Examples
    --------
    >>> context_word(1.0), context_word(0.3)
    ('rural', 0.3)
    """
    return next((word for word, number in CONTEXTS.items() if number == value), float(value))


def count_contexts(contexts: Iterable[float]) -> str:
    """Describe how many recordings state each context, with NaN for those that do not.

    Examples
    --------
    >>> count_contexts([0, 0, 1, math.nan])
    '2 urban, 1 rural and 1 unstated (as urban)'
    """
    values = [float(value) for value in contexts]
    counts = {
        "urban": values.count(0.0),
        "in between": sum(0 < value < 1 for value in values),
        "rural": values.count(1.0),
        "unstated (as urban)": sum(map(math.isnan, values)),
    }
    return listed([f"{count:,} {word}" for word, count in counts.items() if count])
