"""Encounters page: filters, order and the selected encounter in the page's address."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Final, TypeVar

from ui.session.address import finite_number
from ui.views.encounters.filters import CATEGORIES, CLASSES, OF_SUBJECTS, OPEN, Filters
from ui.views.encounters.order import Order, order_of

ENCOUNTER: Final = "encounter"
ALL_COLUMNS: Final = "all"
NAMES: Final = (
    *("category", "miss_x", "miss_y", "only", "class", "position", "height", "pose", "severity"),
    *(*OF_SUBJECTS, "order", "columns", ENCOUNTER),
)
"""Entries of the address that belong to the page."""
LONGEST: Final = 40
"""Maximum length of a wrong value in a message, characters."""
T = TypeVar("T")


@dataclass(frozen=True)
class Choice:
    """Filters, order and open encounter, which is None if none was selected."""

    filters: Filters = field(default_factory=Filters)
    order: Order = field(default_factory=Order)
    has_all_columns: bool = False
    encounter: str | None = None


def to_address(choice: Choice) -> dict[str, str]:
    """Return the address entries of a choice, without initial values."""
    filters = choice.filters
    entries = {
        "category": _joined(filters.categories),
        "miss_x": _joined(filters.classes_x),
        "miss_y": _joined(filters.classes_y),
        "only": _joined(filters.recordings),
        "class": _joined(filters.classes),
        **{name: _joined(chosen) for name, chosen in filters.of_subjects.items()},
        "position": _range_text(filters.position),
        "height": _range_text(filters.height_px),
        "pose": _range_text(filters.pose_z),
        "severity": f"{filters.least_severity_s:g}" if filters.least_severity_s > 0 else "",
        "order": "" if choice.order == Order() else choice.order.text,
        "columns": ALL_COLUMNS if choice.has_all_columns else "",
        ENCOUNTER: choice.encounter or "",
    }
    return {name: text for name, text in entries.items() if text}


def from_address(
    query: Mapping[str, str],
    recordings: Sequence[str],
    classes: Sequence[str] = (),
    of_subjects: Mapping[str, Sequence[str]] | None = None,
) -> tuple[Choice, tuple[str, ...]]:
    """Parse an address, and list its parts that cannot be applied, in words.

    Parameters
    ----------
    recordings, classes, of_subjects
        Available values, and choices of the filters that subjects add, by name.
    """
    wrong: list[str] = []

    def read(name: str, text_to_value: Callable[[str], T | None], default: T) -> T:
        text = query.get(name)
        if text is None:
            return default
        value = text_to_value(text)
        if value is None:
            wrong.append(f"{name} cannot be {_short(text)}")
            return default
        return value

    def among(name: str, possible: Sequence[str]) -> tuple[str, ...]:
        parts = query.get(name, "").split(",")
        asked = [part.replace("%2C", ",").replace("%25", "%") for part in parts if part]
        wrong.extend(f"{name} cannot be {_short(it)}" for it in asked if it not in possible)
        return tuple(it for it in possible if it in asked)

    filters = Filters(
        categories=among("category", CATEGORIES),
        classes_x=among("miss_x", CLASSES),
        classes_y=among("miss_y", CLASSES),
        recordings=among("only", recordings),
        classes=among("class", classes),
        of_subjects={
            name: chosen
            for name, choices in (of_subjects or {}).items()
            if (chosen := among(name, choices))
        },
        position=read("position", _range, None),
        height_px=read("height", _range, None),
        pose_z=read("pose", _range, None),
        least_severity_s=read("severity", _least, 0.0),
    )
    choice = Choice(
        filters,
        read("order", order_of, Order()),
        query.get("columns") == ALL_COLUMNS,
        query.get(ENCOUNTER),
    )
    return choice, tuple(wrong)


def _joined(names: Sequence[str]) -> str:
    return ",".join(name.replace("%", "%25").replace(",", "%2C") for name in names)


def _range_text(span: tuple[float, float] | None) -> str:
    """Format a range. An open end is omitted, because it follows from the list."""
    return (
        "" if span is None else ":".join(f"{end:g}" if math.isfinite(end) else "" for end in span)
    )


def _range(text: str) -> tuple[float, float] | None:
    low, _, high = text.partition(":")
    least = finite_number(low) if low else OPEN[0]
    most = finite_number(high) if high else OPEN[1]
    if least is None or most is None or least > most or ":" not in text:
        return None
    return least, most


def _least(text: str) -> float | None:
    value = finite_number(text)
    return None if value is None or value < 0 else value


def _short(text: str) -> str:
    return text if len(text) <= LONGEST else text[: LONGEST - 1] + "…"
