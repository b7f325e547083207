"""Settings that act while their slider is dragged, and a mark on parts that lag behind.

Streamlit reports a slider to Python only on release. Until then a script of the page computes
results from columns that it fetches once (`ui.session.packed_comparison`). Where it cannot, it
sends the values on the way to Python, one at a time (`ui.session.settings`).
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from contextlib import suppress
from pathlib import Path
from typing import Any, Final

import streamlit as st

from nvcore.common.errors import ParameterError
from nvcore.comparison.measures.table import MEASURES
from nvcore.settings.params import SETTINGS
from nvcore.settings.stages import ENCOUNTERS, SALIENT, SEVERITY, Stage
from ui.session import settings, state, store
from ui.session.packed_comparison import LIVE, can_pack, has_mixed_scores, n_bytes, version_of
from ui.session.routes import address
from ui.widgets.script import read_script

KEY: Final = "live"
SMALL_BYTES: Final = 2_000_000
"""Columns up to this size are fetched before a slider is touched."""


def _moving(*stages: Stage) -> list[str]:
    """Return the live settings that affect the results of these stages."""
    return [name for name in LIVE if SETTINGS[name].moves(stages)]


MOVES: Final = {measure.key: _moving(*measure.stages) for measure in MEASURES}
"""Live settings that affect each measure."""
STILL: Final[dict[str, list[str]]] = {"venn": _moving(ENCOUNTERS, SEVERITY), "viewer": []}
"""Live settings that affect parts of pages, by the part's key. The viewer follows by itself, except
for the counts in its legend."""
COUNTS: Final = _moving(ENCOUNTERS, SALIENT)
"""Live settings that affect the counts in the viewer's legend."""
FOLDER: Final = Path(__file__).parent
_COMPONENT = st.components.v2.component("nvcore_live", js=read_script(FOLDER / "sliders.js"))


def draw(*, can_compare: bool) -> None:
    """Draw the invisible component that watches the sliders, after everything they act on.

    It marks the page as outdated until the page is drawn for the sliders' values.
    """
    drawn = {name: value for name, value in settings.shown().items() if isinstance(value, float)}
    data = {
        "labels": {name: state.say(setting.label) for name, setting in SETTINGS.items()},
        "drawn": drawn,
        "answered": store.LIVE_ANSWERED.get(),
        "live": _live() if can_compare else None,
    }
    _COMPONENT(key=KEY, height=1, data=data, on_drag_change=_note)


def _live() -> dict[str, Any] | None:
    """Return the browser's data for computing by itself, or None if it cannot."""
    result = state.result()
    if result is None or not can_pack(result):
        return None
    as_set = state.params()
    is_mixed = state.cached("mixed_scores", state.systems(), lambda: has_mixed_scores(result))
    unknown = ("threshold_x", "threshold_y") if is_mixed else ()
    return {
        "url": f"{address(state.workspace())}/comparison?v={version_of(result)}",
        "is_small": n_bytes(result) <= SMALL_BYTES,
        "names": [name for name in LIVE if name not in unknown],
        "settings": {name: getattr(as_set, name) for name in LIVE},
        "rules": {
            **{name: getattr(as_set, name) for name in ("proximity", "pairing", "coverage")},
            "point": state.operating_point(),
        },
        "moves": MOVES,
        "still": STILL,
        "counts": COUNTS,
        "recording": state.recording(),
        "window_s": as_set.window,
    }


def _note() -> None:
    note(store.sent(KEY, "drag"))


def note(drag: Any) -> None:
    """Apply the value of a slider that is being dragged. Ignore malformed messages."""
    if not isinstance(drag, Mapping):
        return
    name, value, answered = (drag.get(key) for key in ("name", "value", "id"))
    if isinstance(answered, int) and not isinstance(answered, bool):
        store.LIVE_ANSWERED.set(answered)
    if not isinstance(name, str) or name not in SETTINGS:
        return
    if not isinstance(value, int | float) or isinstance(value, bool) or not math.isfinite(value):
        return
    with suppress(ParameterError):
        SETTINGS[name].check(name, float(value))
        settings.drag(name, float(value))
