"""Page Ratings, and its additions to the dashboard."""

from __future__ import annotations

from collections.abc import Sequence

from nvcore.settings.stages import SALIENCY
from ui import subject


class RatingsPages(subject.SubjectPages):
    pages = (
        subject.Page("ratings", "Ratings", "Lab", after="study", shown=(SALIENCY,), is_folded=True),
    )
    documents = (subject.Document("ratings", "Ratings", after="validation"),)

    def studies(self) -> Sequence[subject.AnyStudies]:
        from ui.subjects.ratings.sessions import SESSIONS

        return (SESSIONS,)
