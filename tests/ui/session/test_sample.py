"""Visitors share the sample recordings and what is computed of them, and nothing of their own."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from threading import Barrier

import pytest
from places import SAMPLE
from streamlit.testing.v1 import AppTest

from nvcore.common.errors import MediaError, NvcoreError
from nvcore.pictures import Pictures, open_pictures, recordings
from nvcore.settings.protocols import PROTOCOLS
from pages import TIMEOUT_S, checked, session
from ui.session import sample, state
from ui.session.sample import SharedSample, sample_of, shared_sample

SCRIPT = """
import streamlit as st
from ui.session import settings, state
from ui.widgets import drawing
from ui.session.results import measure_evidence
from ui.shell import live_params
settings.begin_run()
live_params.read()
if "wanted" in st.session_state:
    wanted = st.session_state["wanted"]
    del st.session_state["wanted"]
    state.open_session(wanted(), label="Mine" if wanted is not state.sample_session
                       else state.SAMPLE_LABEL)
if "protocol" in st.session_state:
    state.set_protocol(st.session_state["protocol"])
st.session_state["opened"] = state.opened()
result = state.result()
st.session_state["made"] = (result, measure_evidence(result), drawing.thumbnail(3, lambda: MINE))
"""


def visit(mine: bytes = b"drawn", alpha: float | None = None, **given: object) -> AppTest:
    page = AppTest.from_string(SCRIPT.replace("MINE", repr(mine)), default_timeout=TIMEOUT_S)
    if alpha is not None:
        page.query_params["alpha"] = str(alpha)
    for name, value in given.items():
        page.session_state[name] = value
    return checked(page.run())


def made(page: AppTest) -> tuple:
    return page.session_state["made"]


def stored() -> set[int]:
    """All that the shared store holds."""
    caches = shared_sample(SAMPLE, label="")._caches
    return {id(value) for cache in caches.values() for value in cache.values()}


def test_two_visitors_share_what_is_read_and_computed():
    first, second = visit(), visit(b"not drawn again")
    assert first.session_state["workspace"] is not second.session_state["workspace"]
    assert first.session_state["opened"] is second.session_state["opened"]
    assert all(mine is yours for mine, yours in zip(made(first), made(second), strict=True))
    assert {id(value) for value in made(first)} <= stored()


def test_pictures_are_opened_once_and_each_visitor_reads_them_by_himself(
    monkeypatch: pytest.MonkeyPatch,
):
    def refuse(_path: Path) -> Pictures:
        raise MediaError("not at hand")

    shared = SharedSample(SAMPLE, "")
    monkeypatch.setattr(recordings, "open_pictures", refuse)
    assert shared.new_pictures().sources == {}
    monkeypatch.setattr(recordings, "open_pictures", open_pictures)
    first = shared.new_pictures()  # tried again
    monkeypatch.setattr(recordings, "open_pictures", refuse)
    second = shared.new_pictures()
    first.close()
    assert first.sources[0] is not second.sources[0]
    assert second.sources[0].read(0).any()


def test_a_change_is_of_its_visitor_alone():
    before = visit()
    changed = visit(b"another drawing", protocol=PROTOCOLS["near"])
    assert not {id(value) for value in made(changed)} & stored()
    assert made(changed)[2] == b"another drawing"
    assert made(visit())[0] is made(before)[0]


def test_who_moves_a_setting_alike_shares_what_it_moves_and_nobody_else():
    as_opened = visit()
    first, second = visit(alpha=0.123), visit(alpha=0.123)
    assert made(first)[0].params.alpha == 0.123
    assert all(mine is yours for mine, yours in zip(made(first), made(second), strict=True))
    assert made(first)[0] is not made(as_opened)[0]
    assert made(first)[1] is not made(as_opened)[1]
    assert made(first)[2] == made(as_opened)[2]  # the boxes of a picture do not depend on alpha
    assert made(visit())[0] is made(as_opened)[0]


def test_long_recordings_are_not_kept_for_settings_that_were_moved(monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr(sample, "MOVED_FRAMES", 10)
    assert SharedSample(SAMPLE, "long").most_moved == 0
    n_made: list[int] = []
    long = SharedSample(SAMPLE, "long")
    for _ in range(2):
        long.cached_moved("kind", "key", lambda: n_made.append(1))
    assert len(n_made) == 2


def test_a_change_taken_back_shares_again():
    page = visit(alpha=0.123)
    page.session_state["settings"] = {"alpha": made(visit())[0].params.alpha}
    checked(page.run())
    assert {id(value) for value in made(page)[:2]} <= stored()  # the drawing holds for any alpha


def test_what_a_visitor_opens_never_gets_into_the_store(tmp_path: Path):
    visit()
    before = stored()
    page = visit(b"private", wanted=lambda: session(tmp_path, "fir.csv", "nir.csv"))
    assert page.session_state["opened"].label == "Mine"
    assert sample_of(page.session_state["opened"]) is None
    assert stored() == before
    page.session_state["wanted"] = state.sample_session
    checked(page.run())
    assert page.session_state["opened"] is visit().session_state["opened"]
    assert made(page)[2] == b"drawn"


def test_the_store_is_bounded_and_makes_for_all_threads_at_once_one_value():
    sample = SharedSample(SAMPLE, "sample")
    at_once = Barrier(4, timeout=600)
    made: list[object] = []

    def make() -> object:
        made.append(object())
        return made[-1]

    def ask(_: int) -> object:
        at_once.wait()
        return sample.cached("kind", 0, make)

    with ThreadPoolExecutor(4) as pool:
        assert list(pool.map(ask, range(4))) == made * 4
    assert len(made) == 1
    first = sample.cached("kind", 1, object, most=2)
    sample.cached("kind", 2, object, most=2)
    assert sample.cached("kind", 1, object, most=2) is first
    assert sample.peek("kind", 0) is None


def test_a_sample_that_cannot_be_read_is_tried_again(tmp_path: Path):
    path = tmp_path / "session.toml"
    with pytest.raises(NvcoreError):
        shared_sample(path, label="")
    own = SAMPLE.read_text().replace('path = "', f'path = "{SAMPLE.parent}/')
    path.write_text(own.replace('pictures = "', f'pictures = "{SAMPLE.parent}/'))
    assert shared_sample(path, label="").opened.dataset.systems
