"""Page Time left, and its additions to the dashboard."""

from typing import Final

from nvcore.subjects.time_left.kinds import Urgency
from nvcore.subjects.time_left.settings import CONFIRMED, CONTACT, TIME_LEFT, URGENCY
from nvcore.subjects.time_left.steps import time_left_in
from ui.session import state
from ui.subject import Page


def _lacks() -> str:
    if not state.opened().dataset.objects.is_on_road:
        return "Needs objects for which a car has to brake."
    result = state.workspace().result
    if result is None:
        return ""
    counts = time_left_in(result).count_urgency()
    n_calm = counts[Urgency.UNKNOWN] + counts[Urgency.NOT_URGENT]
    is_calm = n_calm == sum(counts.values())
    return "Needs a car that comes near somebody." if is_calm else ""


PAGES: Final = (
    Page(
        "time_left",
        "Time left",
        "Compare",
        after="encounters",
        shown=(TIME_LEFT,),
        own=(URGENCY, CONTACT, CONFIRMED),
        lacks=_lacks,
    ),
)
ENCOUNTER_TEXT: Final = "encounter:draw_text"
ENCOUNTER_WAYS: Final = "encounter:draw_ways"
COLUMN_LOOKS: Final = "looks:LOOKS"
