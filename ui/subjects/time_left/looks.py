"""Formats of the time left columns in tables on pages."""

from __future__ import annotations

from typing import Final

from ui.subject import ColumnLook


def _spaced(value: str) -> str:
    return value.replace("_", " ")


LOOKS: Final = {
    "time_left": ColumnLook("confirms", words=_spaced),
    "margin_s": ColumnLook("margin (s)", "+.2f"),
    "impact_kmh": ColumnLook("impact (km/h)", ".0f"),
    "confirmed_frame": ColumnLook("confirmed in frame"),
    "min_ttc_s": ColumnLook("Least to contact (s)"),
    "urgency": ColumnLook(words=_spaced),
    "urgent_frame": ColumnLook("Last chance"),
}
