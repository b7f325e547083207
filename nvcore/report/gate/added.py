"""What subjects know of rules about their measures."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Set
from dataclasses import dataclass

import numpy as np

from nvcore.comparison import Result
from nvcore.notes import Note


@dataclass(frozen=True)
class RulesOf:
    """What a subject knows of rules about its measures.

    Attributes
    ----------
    undefined
        Names of the measures that have a value, but one that no rule can rest on.
    facts
        What is said of a measure in a comparison, whether or not its rule holds.
    counted
        Encounters that a measure counts, by its name; a failed rule lists them. bool, shape
        (n_encounters,).
    is_open
        Encounters that may as well be counted otherwise; likewise.
    """

    undefined: Callable[[Result], Set[str]]
    notes: Callable[[Result, str], tuple[Note, ...]]
    counted: Mapping[str, Callable[[Result], np.ndarray]]
    is_open: Callable[[Result], np.ndarray]
