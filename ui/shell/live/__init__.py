"""Settings that act while their slider moves, and what still shows their former values.

A script of the page computes what it can for where the handle is, from columns that it fetches
once (`ui.session.packed_comparison`). Streamlit tells Python of a slider only when it is let go;
where the script cannot compute, it sends values on the way, one at a time (`ui.session.settings`).
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from contextlib import suppress
from pathlib import Path
from typing import Any, Final

import streamlit as st

from nvcore.errors import ParameterError
from nvcore.measures.table import MEASURES
from nvcore.params import SETTINGS
from nvcore.stages import ENCOUNTERS, SALIENT, SEVERITY, Stage
from ui.session import settings, state, store
from ui.session.packed_comparison import LIVE, can_pack, has_mixed_scores, n_bytes, version_of
from ui.session.routes import address
from ui.widgets.script import read_script

KEY: Final = "live"
SMALL_BYTES: Final = 2_000_000
"""So much is fetched before a slider is reached for."""


def _moving(*stages: Stage) -> list[str]:
    """Live settings that move the results of these stages."""
    return [name for name in LIVE if SETTINGS[name].moves(stages)]


MOVES: Final = {measure.key: _moving(*measure.stages) for measure in MEASURES}
"""Which live settings move each measure."""
STILL: Final[dict[str, list[str]]] = {"venn": _moving(ENCOUNTERS, SEVERITY), "viewer": []}
"""Parts of pages by their key, and what moves them: other settings leave them as they are. The
viewer follows by itself, but for the counts in its legend."""
COUNTS: Final = _moving(ENCOUNTERS, SALIENT)
"""What moves those counts."""
FOLDER: Final = Path(__file__).parent
_COMPONENT = st.components.v2.component("nvcore_live", js=read_script(FOLDER / "sliders.js"))


def draw(*, can_compare: bool) -> None:
    """The invisible part of the page that watches the sliders; after all that they act on.

    Until it has heard that the page was drawn for what they show, it says so on the page.
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
    """What the browser needs to compute by itself; None: it cannot."""
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
    """Make the setting what its slider says in motion, if what the browser sends has a meaning."""
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
