"""Notes and counts that subjects contribute to gate rules about their measures."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Set
from dataclasses import dataclass

import numpy as np

from nvcore.common.subject import subjects
from nvcore.comparison.compare import Result
from nvcore.notes import Note


@dataclass(frozen=True)
class RulesOf:
    """Notes and counts that a subject contributes to gate rules about its measures.

    Attributes
    ----------
    undefined
        Names of the measures whose value cannot support a rule.
    notes
        Notes about a measure in a comparison, whether or not its rule holds.
    counted
        Encounters that a measure counts, by its name, listed by a failed rule. bool, shape
        (n_encounters,).
    is_open
        Encounters with an uncertain count, in the same form.
    """

    undefined: Callable[[Result], Set[str]]
    notes: Callable[[Result, str], tuple[Note, ...]]
    counted: Mapping[str, Callable[[Result], np.ndarray]]
    is_open: Callable[[Result], np.ndarray]


def added_rules() -> list[RulesOf]:
    """Return the contributions of all subjects."""
    return [rules for subject in subjects() for rules in subject.report().rules]
