"""Review: decisions of people on single cases, and projects that keep them.

`cases`: misses, false alarms and doubtful truth, one by one. `decisions`: what reviewers decide,
and the comparison without what is wrong. `robust`: how many wrong cases would turn the verdict.
`store`: projects in a SQLite file. `calls` and `commands`: Python and ``nvcore review``.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import ClassVar

from nvcore.common import subject


class Review(subject.Subject):
    """Review by people."""

    name = "review"
    names: ClassVar = {"nvcore.subjects.review.calls": ("open_project",)}

    def commands(self) -> Sequence[subject.Command]:
        from nvcore.subjects.review.commands import review

        return (review,)
