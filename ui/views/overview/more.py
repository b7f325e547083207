"""Overview page: further sections below the first two screens, one at a time."""

from __future__ import annotations

from typing import Final

import pandas as pd

from nvcore.comparison.compare import Result
from nvcore.evidence.companions import Companions
from ui.session import store
from ui.views.overview import evidence, moments, plan, scorecard
from ui.widgets.choices import look_closer

PARTS: Final = {
    "moments": "Moments to look at",
    "recordings": "Recording by recording",
    "windows": "Worst windows",
    "tests": "Is the difference real?",
    "groups": "By group",
    "plan": "How much more would it take?",
}


def draw(result: Result, measured: pd.DataFrame, companions: Companions | None) -> None:
    """Draw the choice of sections, and the selected section."""
    match look_closer(PARTS, store.OVERVIEW_PART, on_change=_note_question):
        case "moments":
            moments.draw(result)
        case "recordings":
            scorecard.by_recording(result)
        case "windows":
            moments.worst_windows(result)
        case "tests":
            evidence.draw(result, measured)
        case "groups":
            evidence.draw_subgroups(result, measured)
        case "plan":
            plan.draw(result, measured, companions)


def _note_question() -> None:
    store.PLAN_ASKED.set(store.OVERVIEW_PART.get() == "plan")
