"""Query parameters of a page, checked before they are used."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Final

import numpy as np

from nvcore.common.errors import ParameterError
from nvcore.settings.defaults import OperatingPoint, operating_point
from nvcore.settings.params import SETTINGS, Params
from nvcore.settings.stages import THRESHOLD, Setting

PLACE: Final = ("x", "y", "tags", "point", "recording", "frame")
"""Entries of an address besides the parameters: the frame, and systems, tags and operating point if
they were changed."""
MAX_DIGITS: Final = 18
NO_VALUE = "none"
"""Stands for None as the value of a parameter that can be switched off."""


def read_place(
    name: str | None,
    frame: str | None,
    names: Sequence[str],
    frame_numbers: Callable[[int], np.ndarray],
) -> tuple[tuple[int, int], list[str]]:
    """Return the index of the recording and the row within it, and the problems in words.

    `frame_numbers` returns the increasing frame numbers of a recording, given its index.
    """
    wrong = []
    recording = names.index(name) if name in names else 0
    if name is not None and name not in names:
        wrong.append("there is no such recording in what is open, the first one is shown")
    if frame is None or not len(numbers := frame_numbers(recording)):
        return (recording, 0), wrong
    if not is_whole_number(frame):
        return (recording, 0), [*wrong, "its frame is no number"]
    nearest = int(np.abs(numbers - int(frame)).argmin())
    if numbers[nearest] != int(frame):
        wrong.append("its frame is not an evaluated one, the nearest is shown")
    return (recording, nearest), wrong


def read_point(text: str | None) -> tuple[OperatingPoint | None, list[str]]:
    """Return the operating point (None: as open), and the problems in words."""
    try:
        return operating_point(text), []
    except ParameterError:
        return None, ["there is no such operating point"]


def finite_number(text: str) -> float | None:
    """Return the finite number that the text spells, or None."""
    try:
        value = float(text)
    except ValueError:
        return None
    return value if math.isfinite(value) else None


def is_whole_number(text: str) -> bool:
    """Whether this is an integer in plain digits, short enough for any table."""
    digits = text.removeprefix("-")
    return digits.isascii() and digits.isdigit() and len(digits) <= MAX_DIGITS


def read_systems(
    x: str | None, y: str | None, names: Sequence[str]
) -> tuple[tuple[str, str] | None, list[str]]:
    """Return the names of X and Y (None: as open), and the problems in words."""
    if x is None and y is None:
        return None, []
    if x is None or y is None or x == y or not {x, y} <= {*names}:
        return None, ["its systems are not those of what is open, X and Y are as they were opened"]
    return (x, y), []


def tags_text(tags: Sequence[str]) -> str:
    """Return the tags as a query parameter."""
    return ";".join(tags)


def read_tags(
    text: str | None, tags_of: Iterable[tuple[str, ...]]
) -> tuple[tuple[str, ...] | None, list[str]]:
    """Return the tags that recordings must have (None: as open), and the problems in words.

    `tags_of` holds the tags of each recording.
    """
    if text is None:
        return None, []
    tags = tuple(dict.fromkeys(tag for tag in text.split(";") if tag))
    if not any({*tags} <= {*own} for own in tags_of):
        return None, ["no recording has its tags, they are not filtered"]
    return tags, []


def read_parameters(query: Mapping[str, str]) -> tuple[dict[str, float | str | None], list[str]]:
    """Return the parameters in the address, and a message for each invalid value."""
    values: dict[str, float | str | None] = {}
    wrong = []
    for name, setting in SETTINGS.items():
        text = query.get(name)
        if text is None:
            continue
        try:
            value = _value(text, setting)
            setting.check(name, value)
        except (ParameterError, ValueError):
            wrong.append(f"its value of {name} is not possible, the default is used")
        else:
            values[name] = value
    return values, wrong


def _value(text: str, setting: Setting) -> float | str | None:
    if _can_clear(setting) and text == NO_VALUE:
        return None
    if setting.words is not None:
        return text
    if (value := finite_number(text)) is None:  # valid in a session file, but no slider can show it
        raise ValueError
    return value


def _can_clear(setting: Setting) -> bool:
    """Whether an address can clear a value that the open session sets."""
    return bool(setting.unset) or setting.stage is THRESHOLD


def changed_parameters(live: Params, *starts: Params) -> dict[str, str]:
    """Return the live parameters that differ from any of the starts, as query parameters.

    The link then restores them, whichever of these starts it is opened with.
    """
    texts: dict[str, str] = {}
    for start in starts:
        texts |= {
            name: value if isinstance(value, str) else f"{value:.10g}"
            for name, value in live.given().items()
            if value != getattr(start, name)
        }
        texts |= {
            name: NO_VALUE
            for name, setting in SETTINGS.items()
            if _can_clear(setting)
            and getattr(live, name) is None
            and getattr(start, name) is not None
        }
    return texts
