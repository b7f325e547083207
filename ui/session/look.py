"""Which of a recording's two pictures is shown, its own or the visible-light one, and how."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, Final, Literal, NamedTuple

import numpy as np
import streamlit as st

from nvcore.pictures.base import Picture
from ui.session import state, store

NAMES: Final = ("picture", "blend", "seen_s")
"""What an address says of it."""
CHOICES: Final = ("own", "visible", "blended", "both")
MOST_SECONDS: Final = 10.0
"""Longest time after a change of light that can be chosen."""
CLOCK: Final = "clock"
"""In place of seconds: those since the recording's own change of light, frame by frame."""


class VisiblePictures(NamedTuple):
    """Visible-light pictures of a recording, besides its own.

    Attributes
    ----------
    area
        x, y, w, h of what they show, px of the recording.
    has_picture
        Whether a row has one, bool, shape (n_rows,).
    seen_s
        Seconds since a change of light at the end of each row, inf: the eyes are adapted, NaN: not
        known, float64, shape (n_rows,). None: nothing is known of the light.
    is_simulated
        Rows whose seconds are of a change that never was, bool, shape (n_rows,); None: none.
    change_s
        When it really became dark, also between rows, on the axis of the rows' times, float64,
        ascending: a change that the viewer simulates ends there.
    can_simulate
        Whether the viewer offers a change of light of its own; not where the page does.
    """

    area: tuple[float, float, float, float]
    has_picture: np.ndarray
    seen_s: np.ndarray | None = None
    is_simulated: np.ndarray | None = None
    change_s: np.ndarray = np.empty(0)
    can_simulate: bool = True


@dataclass(frozen=True)
class Sight:
    """How eyes see the pictures of visible light of a recording that stand beside its own.

    Attributes
    ----------
    label, hint
        What the viewer's button is called, and its help text.
    add_light
        Adds to a recording's `VisiblePictures` what is known of its light.
    trouble
        Why nothing is known of the light of a recording, in a sentence; empty: no reason.
    show
        A picture, as eyes see it so many seconds after a change of light; infinite: adapted.
    """

    label: str
    hint: str
    add_light: Callable[[int, VisiblePictures], VisiblePictures]
    trouble: Callable[[int], str]
    show: Callable[[Picture, float], Picture]


class Look(NamedTuple):
    """How the pictures of a recording are seen.

    Attributes
    ----------
    picture
        "own", "visible", "blended" or "both" (side by side); where there are none of visible light,
        its own are seen.
    blend
        Share of visible light where they are blended, 0..1.
    seen_s
        Seconds after a change of light for which visible light is shown as eyes see it;
        `CLOCK`: those of the recording at each frame. None: as it is.
    """

    picture: str = "own"
    blend: float = 0.5
    seen_s: float | Literal["clock"] | None = None


OWN_PICTURES: Final = Look()


def look() -> Look:
    """The look in this browser session: as chosen, else as the address says."""
    known = store.LOOK.get()
    if known is None:
        known = from_address(st.query_params.to_dict()) or OWN_PICTURES
        store.LOOK.set(known)
    return known


def keep_look(chosen: Look) -> None:
    """Use this look from now on, and put it into the page's address."""
    store.LOOK.set(chosen)
    state.write_address(to_address(chosen), NAMES)


def to_address(chosen: Look) -> dict[str, str]:
    """The look as query parameters; defaults are left out.

    Examples
    --------
    >>> to_address(Look("visible", seen_s=1.5))
    {'picture': 'visible', 'seen_s': '1.5'}
    >>> to_address(Look("visible", seen_s=CLOCK))
    {'picture': 'visible', 'seen_s': 'clock'}
    >>> to_address(Look())
    {}
    """
    entries = {}
    if chosen.picture != OWN_PICTURES.picture:
        entries["picture"] = chosen.picture
    if chosen.picture == "blended":
        entries["blend"] = f"{chosen.blend:g}"
    if chosen.seen_s is not None:
        seen_s = chosen.seen_s
        entries["seen_s"] = seen_s if isinstance(seen_s, str) else f"{seen_s:g}"
    return entries


def from_address(query: Mapping[str, str]) -> Look | None:
    """The look from query parameters, checked; None if there is no valid one."""
    sent = {name: query[name] for name in NAMES if name in query}
    if not sent:
        return None
    numbers = {name: _sent(text) for name, text in sent.items() if name in NAMES[1:]}
    return read_look({"picture": sent.get("picture", OWN_PICTURES.picture), **numbers})


def read_look(sent: Any) -> Look | None:
    """The look from a browser message or an address, checked; None if there is no valid one."""
    if not isinstance(sent, Mapping) or sent.get("picture") not in CHOICES:
        return None
    blend = _within(sent.get("blend"), 1.0)
    seen_s: float | Literal["clock"] | None = _within(sent.get("seen_s"), MOST_SECONDS)
    if sent.get("seen_s") == CLOCK:
        seen_s = CLOCK
    return Look(sent["picture"], OWN_PICTURES.blend if blend is None else blend, seen_s)


def _within(value: Any, greatest: float) -> float | None:
    if not isinstance(value, int | float) or isinstance(value, bool):
        return None
    return float(value) if math.isfinite(value) and 0 <= value <= greatest else None


def _sent(text: str) -> float | str | None:
    if text == CLOCK:
        return text
    try:
        return float(text)
    except ValueError:
        return None
