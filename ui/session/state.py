"""State of this browser session: the open comparison, its settings and results."""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Hashable, Mapping, Sequence
from contextlib import nullcontext
from dataclasses import replace
from pathlib import Path
from typing import Any, Final, TypeVar

import numpy as np
import streamlit as st

from nvcore import notes
from nvcore.common.palette import Scheme, Shade, scheme_for
from nvcore.comparison.compare import Result, compare
from nvcore.dataset import Dataset
from nvcore.evidence.operating_points import at_operating_point
from nvcore.inputs.session import Session
from nvcore.inputs.session.changes import live_session as with_live
from nvcore.metrics.detection.operating_point import span_of_scores
from nvcore.notes import Note
from nvcore.settings.defaults import DELIVERED, OperatingPoint
from nvcore.settings.params import SETTINGS, Params
from nvcore.settings.primary import Primary, now_text
from nvcore.settings.protocols import Protocol
from nvcore.settings.stages import SALIENT, THRESHOLD
from ui.access.people import is_same
from ui.session import address, store
from ui.session.address import PLACE
from ui.session.lifetime import end_with_session, is_in_use
from ui.session.opening import load_for
from ui.session.sample import (
    SharedSample,
    as_shared,
    sample_of,
    shared_opening,
    shared_sample,
    shown_in,
)
from ui.session.workspace import Compared, Opened, Workspace, workspace_of
from ui.settings.start import start_file

ROOT: Final = Path(__file__).resolve().parents[2]
SAMPLE: Final = ROOT / "sample_data" / "session.toml"
SAMPLE_LABEL: Final = "Sample recordings"
SIGNS: Final = SAMPLE.parent / "speed_signs" / "session.toml"
SIGNS_LABEL: Final = "Sample drives past speed signs"
T = TypeVar("T")
Cached = Callable[..., Any]
"""`Caching.cached` of this session or of all visitors."""


def workspace() -> Workspace:
    """Return this session's workspace. The first call opens the start comparison."""
    return _workspace_and_opened()[0]


def opened() -> Opened:
    """Return the open comparison's data. The first call opens the start comparison."""
    return _workspace_and_opened()[1]


def _workspace_and_opened() -> tuple[Workspace, Opened]:
    space = store.WORKSPACE.get()
    if space is None:
        space = Workspace()
        store.WORKSPACE.set(space)
    if space.opened is not None:
        return space, space.opened
    with st.spinner("Opening the recordings"):
        return space, shown_in(space, shared_start().opened)


def open_session(
    session: Session, *, label: str, check: Callable[[Dataset], None] | None = None
) -> None:
    """Open another comparison in this workspace and rerun the page.

    Raises
    ------
    NvcoreError
        If an input cannot be used, or by `check`. What was open stays open.
    """
    space = workspace()
    with st.spinner("Reading the files"):
        opening = shared_opening(session, label)
        if opening is None:
            opening = Opened.of(session, load_for(space, session.of_all), label)
        if check is not None:
            check(opening.whole)
        shown_in(space, opening)
    st.rerun()  # widgets that are already drawn take their new values in the next run


def read_again(session: Session, *, then: Callable[[], None]) -> None:
    """Reload the same recordings under a changed session, and rerun the page.

    Frame, settings and choices stay unless a changed file has other frames.

    Parameters
    ----------
    then
        Called once they are open.

    Raises
    ------
    NvcoreError
        If an input cannot be used. What was open stays open.
    """
    space, before = workspace(), opened()
    with st.spinner("Reading the files"):
        again = Opened.of(session, load_for(space, session.of_all), before.label)
        if again.whole.frames.equals(before.whole.frames):
            space.look_at(again, keeps_outputs=True)
        else:
            shown_in(space, again)
    then()
    st.rerun()


def sample_session(path: Path = SAMPLE, label: str = SAMPLE_LABEL) -> Session:
    """Return the session of the sample recordings or of another sample (cheap to open)."""
    return shared_sample(path, label=label).opened.session


def shared_start() -> SharedSample:
    """Return the start data of all visitors: the session given to the app, else the sample.

    Raises
    ------
    NvcoreError
        If it cannot be read.
    """
    path = start_file()
    if path is None:
        return shared_sample(SAMPLE, label=SAMPLE_LABEL)
    return shared_sample(path, label=path.name)


def restore(token: str) -> bool:
    """Take over the workspace with this token. Return False if another page still uses it.

    Nothing changes if the workspace is not available, or if the page has opened something since.
    """
    space, own = workspace_of(token), workspace()
    if space is None or space.opened is None or not is_same(space.owner, own.owner):
        return True
    if space is own or own.n_opened > 1:
        return True
    if is_in_use(space):
        return False
    store.WORKSPACE.set(space)
    end_with_session(space)
    # until redrawn, the page requests pictures and boxes of the workspace it has left
    own.forget_values()
    store.LEFT_WORKSPACE.set(own)
    store.SEEN_OPENING.pop()
    store.PLACE.pop()
    store.BAD_LINK.pop()
    st.query_params.from_dict(store.FIRST_QUERY.get())
    return True


def set_params(**values: Any) -> None:
    """Set parameters for the next run. The caller reruns the page."""
    store.NEW_PARAMS.set({**store.NEW_PARAMS.get(), **values})


def threshold_of(letter: str) -> float | None:
    """Return the score threshold of X or Y (None: every detection counts)."""
    threshold: float | None = getattr(params(), f"threshold_{letter}")
    return threshold


def set_threshold(letter: str, threshold: float | None) -> None:
    """Move the threshold slider of X or Y (None: to its left end, where every score counts)."""
    span = span_of(letter)
    if span is not None:
        value = span[0] if threshold is None else max(threshold, span[0])
        set_params(**{f"threshold_{letter}": value})


def cached(kind: str, key: Hashable, make: Callable[[], T], *, most: int = 1) -> T:
    """Return a cached value, computing it on the first call, as in `Workspace.cached`.

    If the comparison is shared, it is computed once for all visitors.

    The value must depend only on the key and the open comparison, and must not be modified.
    """
    space, sample = workspace(), sample_of(opened())
    if sample is None:
        return space.cached(kind, key, make, most=most)
    keep = sample.cached if params() == session_params() else sample.cached_moved
    return space.cached(kind, key, lambda: keep(kind, key, make, most=most), most=most)


def known(kind: str, key: Hashable) -> Any:
    """Return the value if it is cached, or else None."""
    value, sample = workspace().peek(kind, key), sample_of(opened())
    return sample.known(kind, key) if value is None and sample is not None else value


def score_span(system: str) -> tuple[float, float] | None:
    """Return the lowest and highest score of a system, or None if they do not differ."""
    dataset = opened().dataset
    return cached("score_span", system, lambda: span_of_scores(dataset, system), most=20)


def span_of(letter: str) -> tuple[float, float] | None:
    """Return the lowest and highest score of X or Y, or None if there is no threshold to move."""
    system = systems()["xy".index(letter)]
    return None if system is None else score_span(system)


def session_params() -> Params:
    """Return the initial parameters of the open session."""
    return opened().params


def params() -> Params:
    """Return the live parameters."""
    return store.PARAMS.get() or session_params()


def systems() -> tuple[str, str | None]:
    """Return the names of X and Y. Y is None if there is only one system."""
    dataset = opened().dataset
    x, y = dataset.compared()
    return x or dataset.systems[0], y


def result() -> Result | None:
    """Return the comparison to show, with the live parameters, or None for a single system.

    If X and Y are set to unequal numbers of false alarms, the chosen operating point applies.
    """
    space, as_set = workspace(), result_as_set()
    if as_set is None:
        space.compared = None
        return None
    newest = at_operating_point(as_set, operating_point(), space.result)
    if newest is not space.result:
        names = f"{newest.x.name}\0{newest.y.name}"
        # settings that move boxes, matches or most salient misses: others keep the drawing valid
        key = f"{opened().dataset.fingerprint}{newest.params.only_for(THRESHOLD, SALIENT)!r}{names}"
        space.compared = Compared(newest, hashlib.sha256(key.encode()).hexdigest()[:12])
    return newest


def result_as_set() -> Result | None:
    """Return the comparison at the thresholds as set, not at equal false alarms.

    None for a single system.
    """
    space, dataset, settings = workspace(), opened().dataset, params()
    x, y = systems()
    if y is None:
        return None
    previous = space.result

    def make() -> Result:
        with nullcontext() if previous is not None else st.spinner("Comparing the systems"):
            return compare(dataset, settings, x=x, y=y, previous=previous)

    return kept_result(cached, settings, x, y, make)


def kept_result(
    cached: Cached, params: Params, x: str, y: str, make: Callable[[], Result]
) -> Result:
    """Return the comparison from the cache, or compute it with `make`."""
    result: Result = cached("result", (params, x, y), make)
    return result


def operating_point() -> OperatingPoint:
    """Return how unequal thresholds are compared: as set, at equal false alarms, or delivered."""
    return opened().session.operating_point or "equal-alarms"


def set_operating_point(point: OperatingPoint) -> None:
    """Set how unequal thresholds are compared."""
    before = operating_point()
    if DELIVERED in (point, before) and point != before:  # another question
        primary = primary_so_far()
        if primary.fingerprint:
            primary = replace(primary, is_changed=True, fixed_at=now_text())
        compare_as(replace(opened().session, operating_point=point, primary=primary))
    elif point != before:
        _change_session(operating_point=point)


def primary_so_far() -> Primary:
    """Return the primary measure, which a verdict on the data has fixed if it was shown."""
    fingerprint = opened().dataset.fingerprint
    primary = opened().session.primary.of_data(fingerprint)
    is_shown = store.SHOWN_VERDICT.get() == fingerprint
    return replace(primary, fingerprint=fingerprint) if is_shown else primary


def protocol() -> Protocol:
    """Return the protocol: which pedestrians the detection measures count."""
    return opened().session.protocol


def set_protocol(protocol: Protocol) -> None:
    """Set the protocol of the detection measures."""
    if opened().session.protocol != protocol:
        _change_session(protocol=protocol)


def _change_session(**fields: Any) -> None:
    workspace().opened = replace(opened(), session=replace(opened().session, **fields))


def live_session() -> Session:
    """Return the open session with the live parameters as its settings."""
    x, y = systems()
    return with_live(opened().session, opened().dataset, params(), x=x, y=y)


def compare_systems(x: str, y: str | None) -> None:
    """Make these X and Y, and keep each system's threshold. The caller reruns the page."""
    live = live_session()
    thresholds = [system.threshold for system in live.systems]
    threshold_by_name = dict(zip(opened().dataset.systems, thresholds, strict=True))
    settings = replace(opened().session.params, threshold_x=None, threshold_y=None)
    compare_as(replace(live, params=settings, x=x, y=y))
    for letter, name in (("x", x), ("y", y)):
        if name is not None:
            set_threshold(letter, threshold_by_name[name])


def compare_as(session: Session, whole: Dataset | None = None) -> None:
    """Compare the same data, or a renamed copy `whole`, with the settings of another session."""
    space, before = workspace(), opened()
    compared = space.compared
    space.look_at(as_shared(Opened.of(session, whole or before.whole, before.label)))
    if opened().dataset.boxes is before.dataset.boxes:  # `compare` reuses valid results
        space.compared = compared


def theme() -> Scheme:
    """Return the colour scheme: light or dark, with the systems' colours."""
    shade: Shade = "dark" if st.context.theme.type == "dark" else "light"
    return scheme_for(shade, opened().dataset.systems, *systems())


def say(text: str | Note, /, **values: object) -> str:
    """Render a note or template (see `nvcore.settings.objects.Objects.say`) for the objects."""
    objects = opened().dataset.objects
    return objects.say(text, **values) if isinstance(text, str) else notes.say(text, objects)


def recording_names() -> list[str]:
    """Return the names of the recordings, in their order."""
    names: list[str] = opened().dataset.recordings["name"].tolist()
    return names


def recording() -> int:
    """Return the index of the current recording."""
    return _place()[0]


def row() -> int:
    """Return the row of the current frame within the current recording."""
    return _place()[1]


def _place() -> tuple[int, int]:
    """Return the current recording and row, clipped to the open data."""
    recording_index, row_in_recording = store.PLACE.get()
    if not 0 <= recording_index < len(recording_names()):
        return 0, 0
    last = max(len(frame_numbers(recording_index)) - 1, 0)
    return recording_index, min(row_in_recording, last)


def go_to(recording_index: int, row_in_recording: int, *, writes: bool = True) -> None:
    """Move to a frame. If `writes`, update the page's address as well."""
    settle(recording_index, row_in_recording, writes=writes)
    store.SEEK.set(store.SEEK.get() + 1)


def settle(recording_index: int, row_in_recording: int, *, writes: bool = True) -> None:
    """Make this frame the current one without moving the viewer, which already shows it."""
    last = max(len(frame_numbers(recording_index)) - 1, 0)
    store.PLACE.set((recording_index, min(max(row_in_recording, 0), last)))
    if writes:
        write_address()


def write_address(own: Mapping[str, str] | None = None, names: Sequence[str] = ()) -> None:
    """Write systems, frame and changed parameters to the page's address.

    A page's `own` entries replace the entries in `names`, which belong to that page.
    """
    now = st.query_params.to_dict()
    others = {name: text for name, text in now.items() if name not in (*SETTINGS, *PLACE, *names)}
    wanted = others | dict(own or {}) | link_to(*_place())
    if wanted != now:
        st.query_params.from_dict(wanted)


def place_of(row_in_all: int) -> tuple[int, int]:
    """Split a row of the frames table into the recording and the row within it."""
    frames = opened().dataset.frame_columns
    recording_index = int(frames.recording[row_in_all])
    return recording_index, row_in_all - int(frames.first[recording_index])


def row_in_all() -> int:
    """Return the row of the current frame in the frames table."""
    return int(opened().dataset.frame_columns.first[recording()]) + row()


def link_to(recording_index: int, row_in_recording: int) -> dict[str, str]:
    """Return query parameters that open a page at this frame with the live parameters."""
    numbers = frame_numbers(recording_index)
    place = {"recording": recording_names()[recording_index]}
    if len(numbers):
        place["frame"] = str(int(numbers[row_in_recording]))
    (x, y), start = systems(), shared_start().opened
    named = {} if y is None or (x, y) == start.dataset.compared() else {"x": x, "y": y}
    if operating_point() != (start.session.operating_point or "equal-alarms"):
        named["point"] = operating_point()
    if (tags := opened().session.only_tags) != start.session.only_tags:
        named["tags"] = address.tags_text(tags)
    starts = [session_params()]
    if start.whole.fingerprint == opened().whole.fingerprint:  # a link starts from these
        starts.append(start.dataset.params_of(x, y))
    return place | named | address.changed_parameters(params(), *starts)


def frame_numbers(recording_index: int) -> np.ndarray:
    """Return the numbers of the evaluated frames of a recording."""
    frames = opened().dataset.frame_columns
    return frames.frame[frames.rows_of(recording_index)]
