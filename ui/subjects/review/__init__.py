"""The Review page: a gallery of cases, decisions, projects."""

from __future__ import annotations

from collections.abc import Sequence

from nvcore.comparison.compare import Result
from nvcore.evidence.looks import Look
from ui import subject


class ReviewPages(subject.SubjectPages):
    pages = (
        subject.Page(
            "review", "Review", "Compare", after="encounters", asks="Is each miss a real one?"
        ),
    )
    documents = (subject.Document("review", "Review", after="report"),)

    def count_look(self, result: Result) -> Look:
        from ui.subjects.review.kept import count_look

        return count_look(result)

    def routes(self) -> Sequence[subject.Place]:
        from ui.subjects.review.crops import ROUTES

        return ROUTES
