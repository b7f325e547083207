"""Frame viewer: picture, boxes of truth, X and Y, curves over time, and playback controls.

This Streamlit component fetches pictures and boxes from the routes itself. Python sends traces and
marks, and receives the row that the viewer settles on.

    data/       content of the viewer: boxes, pictures, the recording
    drawing/    painting on the canvas
    controls/   elements around the canvas, keys, mouse and touch
    player/     order and timing of rows (Streamlit calls `show.js`)
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any, Literal, NamedTuple

import numpy as np
import streamlit as st

from nvcore.common.palette import TRUTH_COLOUR, Theme, scheme_of
from nvcore.metrics.cost_map import CostMap
from nvcore.settings.objects import PEDESTRIAN, Objects
from ui.session import store
from ui.settings.start import base_path
from ui.subject import all_sights
from ui.widgets.drawing import OWN_PICTURES, Look, VisiblePictures, read_look
from ui.widgets.script import read_script
from ui.widgets.viewer.packing import (
    decimate_minima,
    find_spans,
    pack,
    pack_cost,
    pack_frames,
    pack_times,
)

FOLDER = Path(__file__).parent


WORDS = ("a_one", "one", "Nobody", "feet_are")
"""Words for the objects in the viewer's texts, filled in by `worded` in elements.js."""


class ListedBox(NamedTuple):
    """Entry of a list: row within the recording, and box x, y, w, h in px.

    Row -1: the entry is in another recording. Box None: the entry has no box.
    """

    row: int
    box: tuple[float, float, float, float] | None


_COMPONENT = st.components.v2.component(
    "nvcore_viewer",
    css=(FOLDER / "viewer.css").read_text(encoding="utf-8"),
    js=read_script(FOLDER / "player" / "show.js"),
)


def viewer(
    *,
    token: str,
    recording: int,
    n_rows: int,
    width: float,
    height: float,
    fps: float,
    frames: np.ndarray,
    times_s: np.ndarray,
    has_picture: np.ndarray,
    version: str,
    traces: Mapping[str, np.ndarray],
    low: float,
    intervals: Sequence[Any],
    misses: Sequence[int] | np.ndarray,
    names: Sequence[str],
    seek: tuple[int, int],
    lo: float,
    hi: float,
    theme: Theme,
    height_px: int,
    key: str,
    fits_window: bool = False,
    picture_version: str = "",
    only: Literal["x", "y"] | None = None,
    rows: range | None = None,
    cost: CostMap | None = None,
    chosen: int | None = None,
    on_choose: Callable[[int], None] | None = None,
    listed: ListedBox | None = None,
    objects: Objects = PEDESTRIAN,
    visible: VisiblePictures | None = None,
    look: Look = OWN_PICTURES,
    on_look: Callable[[Look], None] | None = None,
) -> int | None:
    """Draw the viewer and return the row it has settled on.

    Parameters
    ----------
    token : str
        The session's token, for the routes.
    recording, n_rows : int
        Index of the recording and the number of its rows (listed frames).
    width, height : float
        Size of the recording, px. Pictures of another size are scaled to it.
    fps : float
        Frames per second.
    frames, times_s : array, shape (n_rows,)
        Frame number and time of every row.
    has_picture : array of bool, shape (n_rows,)
        True if a row has a picture. Without pictures, boxes are drawn on a blank frame.
    version : str
        Changes with every analysis. The boxes are then fetched again.
    traces : mapping of "x" and "y" to array of float, shape (n_rows,)
        Similarity, NaN where undefined, decimated here to the lowest value of each bucket.
    low : float
        Limit of low similarity.
    intervals : pair of array-like of int, shape (n, 2)
        Low-similarity intervals of X and of Y, as rows (first, one past the last).
    misses : array of int
        Rows where a miss begins, in rising order (`nvcore.tables.moments.next_misses`).
    names : pair of str
        Names of X and Y, shown as text.
    seek : (int, int)
        Row to go to, and a number that changes with every request to go there and with the
        recording. The viewer starts at the row. Later it goes there only when the number is new,
        so the row may follow what this function returned.
    lo, hi : float
        Percentiles of the display stretch.
    theme : {"light", "dark"} or Scheme
        Theme of the page, and style of X and Y. The picture's ground is always dark.
    height_px : int
        Largest height of the picture.
    key : str
        Streamlit's key of the component.
    fits_window : bool
        True if the picture must be low enough for the controls below it to fit in the window.
    picture_version : str
        Changes when the recording gets other pictures. They are then fetched again.
    only : {"x", "y"} or None
        System of a clip for raters. They see the picture and the boxes of this system alone, in a
        style that does not reveal the system. One button plays the clip from the first row to the
        last, without seeking. The browser never gets `names`, and does not show `traces` and
        `misses`. In the first of `intervals` the picture has a warning sign.
    rows : range or None
        Rows that can be shown, at least one. None: all rows.
    cost : CostMap or None
        Cost of missing a pedestrian in this recording, laid over the picture on request. It is
        never sent with `only`.
    chosen : int or None
        Track of the pedestrian who is marked and followed. None: nobody in this recording.
    on_choose
        Called with a row of ``result.encounters`` when its pedestrian is chosen in the picture.
    listed : ListedBox or None
        Current entry of a list. Its box is marked, and the page gets the keys n and p, which
        otherwise lead to misses. None: there is no list.
    objects : Objects
        Objects in the boxes, which determine the words in the viewer's texts.
    visible : VisiblePictures or None
        Pictures of visible light beside the recording's own. None: there are none.
    look : Look
        Look of the pictures when the viewer is first drawn.
    on_look
        Called with the look that was chosen in the browser.

    Returns
    -------
    int or None
        Row within the recording that the user has settled on since the last new `seek`, else the
        row of `seek`. None for a recording without rows.
    """
    minima = {system: decimate_minima(traces[system], n_rows) for system in ("x", "y")}
    row, nonce = int(seek[0]), int(seek[1])
    answer = _COMPONENT(
        key=key,
        data={
            "token": token,
            "base": base_path(),
            "recording": int(recording),
            "n_rows": int(n_rows),
            "width": float(width),
            "height": float(height),
            "fps": float(fps) if fps > 0 else None,  # JSON has no NaN
            "frames": pack_frames(frames),
            "times": pack_times(times_s, frames, fps),
            "picture_spans": pack(find_spans(has_picture), "i4"),
            "version": version,
            "picture_version": picture_version,
            "traces": {system: pack(minima[system][0], "f4") for system in ("x", "y")},
            "bucket_rows": minima["x"][1],
            "low": float(low),
            "intervals": {"x": pack(intervals[0], "i4"), "y": pack(intervals[1], "i4")},
            "misses": pack(misses, "i4"),
            "names": [] if only else [str(name) for name in names],
            "seek": [row, nonce],
            "lo": float(lo),
            "hi": float(hi),
            "theme": scheme_of(theme).shade,
            "colours": colours_of(theme),
            "height_px": int(height_px),
            "fits_window": fits_window,
            "only": only,
            "rows": None if rows is None else [rows.start, rows.stop - 1],
            "cost": None if cost is None or only else pack_cost(cost, objects),
            "chosen": None if chosen is None or only else int(chosen),
            "words": {word: objects.say("{" + word + "}") for word in WORDS},
            "listed": None if listed is None or only else listed._asdict(),
            "visible": None if visible is None or only else _pack_visible(visible),
            "look": look._asdict(),
        },
        default={"settled": None},
        on_settled_change=_nothing,
        on_chosen_change=partial(_tell_choice, key, on_choose),
        on_look_change=partial(_tell_look, key, on_look),
    )
    if n_rows == 0:
        return None
    return settled_row(answer.get("settled"), recording=recording, n_rows=n_rows, seek=(row, nonce))


def _pack_visible(visible: VisiblePictures) -> dict[str, Any]:
    spans = pack(find_spans(visible.has_picture), "i4")
    sight = next(iter(all_sights()), None)
    is_simulated = np.zeros(0, bool) if visible.is_simulated is None else visible.is_simulated
    return {
        "area": [float(side) for side in visible.area],
        "spans": spans,
        "seen_s": None if visible.seen_s is None else pack(visible.seen_s, "f4"),
        "changes": pack(visible.change_s, "f8"),
        "simulated": pack(find_spans(is_simulated), "i4"),
        "can_simulate": visible.can_simulate,
        "sight": sight and {"label": sight.label, "hint": sight.hint},
    }


def settled_in(key: str, *, recording: int, n_rows: int, seek: tuple[int, int]) -> int:
    """Return the row that the `viewer` with this key will return, before it is drawn."""
    settled = store.sent(key, "settled")
    return settled_row(settled, recording=recording, n_rows=n_rows, seek=seek)


def _tell_choice(key: str, on_choose: Callable[[int], None] | None) -> None:
    """Pass the selected encounter to `on_choose`, which must validate what the browser sent."""
    encounter = store.sent(key, "chosen", "encounter")
    if on_choose is not None and isinstance(encounter, int) and not isinstance(encounter, bool):
        on_choose(encounter)


def _tell_look(key: str, on_look: Callable[[Look], None] | None) -> None:
    look = read_look(store.sent(key, "look"))
    if on_look is not None and look is not None:
        on_look(look)


def n_plays_in(key: str) -> int | None:
    """Return how often this `viewer` played its clip to the end, or None if not known."""
    n_plays = store.sent(key, "settled", "n_plays")
    return n_plays if isinstance(n_plays, int) and n_plays >= 0 else None


def settled_row(settled: Any, *, recording: int, n_rows: int, seek: tuple[int, int]) -> int:
    """Return the row reported by the browser, if it is current, else the row of `seek`.

    A row from before Python's newest `seek`, or from another recording, is out of date. The row of
    `seek` then applies.
    """
    if isinstance(settled, Mapping):
        row = settled.get("row")
        is_current = settled.get("recording") == recording and settled.get("nonce") == seek[1]
        if is_current and isinstance(row, int) and 0 <= row < n_rows:
            return row
    return max(0, min(n_rows - 1, seek[0]))


def colours_of(theme: Theme) -> dict[str, dict[str, Any]]:
    """Return colours and line styles of X, Y and truth, for the picture and the page around it."""
    scheme = scheme_of(theme)
    styles = {letter: scheme.style(letter) for letter in "xy"}
    return {
        "picture": {
            **{letter: style.dark for letter, style in styles.items()},
            "truth": TRUTH_COLOUR["dark"],
            "dash": {letter: list(style.pattern) for letter, style in styles.items()},
        },
        "chrome": {
            **{letter: style.colour(scheme.shade) for letter, style in styles.items()},
            "truth": TRUTH_COLOUR[scheme.shade],
            **{f"line-{letter}": style.css for letter, style in styles.items()},
        },
    }


def _nothing() -> None:
    """Do nothing. Streamlit requires a callback for every value with a default."""
