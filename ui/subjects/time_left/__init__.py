"""Page Time left, and its additions to the dashboard."""

from __future__ import annotations

from typing import ClassVar

from nvcore.subjects.time_left.kinds import Urgency
from nvcore.subjects.time_left.settings import CONFIRMED, CONTACT, TIME_LEFT, URGENCY
from nvcore.subjects.time_left.steps import time_left_in
from ui import subject
from ui.session import state


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


def _spaced(value: str) -> str:
    return value.replace("_", " ")


class TimeLeftPages(subject.SubjectPages):
    pages = (
        subject.Page(
            "time_left",
            "Time left",
            "Compare",
            after="encounters",
            shown=(TIME_LEFT,),
            own=(URGENCY, CONTACT, CONFIRMED),
            lacks=_lacks,
        ),
    )
    column_looks: ClassVar = {
        "time_left": subject.ColumnLook("confirms", words=_spaced),
        "margin_s": subject.ColumnLook("margin (s)", "+.2f"),
        "impact_kmh": subject.ColumnLook("impact (km/h)", ".0f"),
        "confirmed_frame": subject.ColumnLook("confirmed in frame"),
        "min_ttc_s": subject.ColumnLook("Least to contact (s)"),
        "urgency": subject.ColumnLook(words=_spaced),
        "urgent_frame": subject.ColumnLook("Last chance"),
    }

    def encounters(self) -> subject.AddedEncounters:
        from ui.subjects.time_left.encounter import draw_text, draw_ways

        return subject.AddedEncounters(draw_text=draw_text, draw_ways=draw_ways)
