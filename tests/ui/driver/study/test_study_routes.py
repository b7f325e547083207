"""Routes of a study: pictures and answers of the participant before the screen, and no one else."""

from __future__ import annotations

import json
import math
import sqlite3
from contextlib import closing
from pathlib import Path

import cv2
import numpy as np
import pytest
import study_pictures
from asgi import ask, put

from nvcore.common.errors import InputError
from nvcore.subjects.driver.study.pictures import read_pictures
from nvcore.subjects.driver.study.settings import StudySettings
from nvcore.subjects.driver.study.touch_task import DetectabilityStore
from ui.session.routes import address
from ui.session.workspace import Workspace
from ui.subjects.driver.study.on_screen import MOST_BYTES, OnScreen, answer_of, sent_by_browser
from ui.subjects.people.studies import ON_SCREEN

TOUCH = {
    "measured_s": 4.01, "shown_s": 0.5, "touch": [30.5, 80], "response_s": 1.25,
    "is_answered": True, "pointer": "touch", "shown_px": 1152, "screen_px": 1280,
}  # fmt: skip


@pytest.fixture
def screen(space: Workspace, tmp_path: Path) -> OnScreen:
    """A participant of a study of three pictures; there are two for practice."""
    folder = study_pictures.write(tmp_path / "dusk", 3)
    store = DetectabilityStore(tmp_path / "studies.sqlite")
    study = store.begin(StudySettings(), read_pictures(folder), folder="local:dusk")
    person, _ = store.join(study, {})
    screen = OnScreen(store, study, person.name, folder, "24 inch")
    space.notes[ON_SCREEN] = screen
    return screen


def picture(space: Workspace, name: str) -> np.ndarray:
    answer = ask(f"{address(space)}/study/{name}.png")
    assert (answer.status, answer.headers["content-type"]) == (200, "image/png")
    return cv2.imdecode(np.frombuffer(answer.body, np.uint8), cv2.IMREAD_COLOR)


def test_pictures_come_whole_and_coarse(space: Workspace, screen: OnScreen):
    full, coarse = picture(space, "1/full"), picture(space, "1/coarse")
    assert full.shape == (study_pictures.HEIGHT, study_pictures.WIDTH, 3)
    assert full.max() == 190
    assert coarse.shape[1] == 48
    assert coarse.max() == 40  # the sky: nobody is to be seen
    assert picture(space, "2/full").shape == full.shape
    assert picture(space, "practice-1/full").shape == (720, 1280, 3)
    assert picture(space, "practice-0/full").shape == (720, 1280, 3)


@pytest.mark.parametrize(
    "name",
    ["3/full", "-1/full", "x/full", "0/other", "practice-2/full", "practice-/full", "9999999/full"],
)
def test_other_pictures_are_not_found(space: Workspace, screen: OnScreen, name: str):
    assert ask(f"{address(space)}/study/{name}.png").status == 404


def test_a_picture_that_was_changed_is_told(space: Workspace, screen: OnScreen):
    (screen.folder / "scene_0.png").write_bytes((screen.folder / "scene_1.png").read_bytes())
    answer = ask(f"{address(space)}/study/0/full.png")
    assert answer.status == 404
    assert "has changed since the study began" in answer.text


def test_an_answer_is_kept_at_once(space: Workspace, screen: OnScreen):
    start = f"{address(space)}/study/1"
    assert put(f"{start}/shown", b"{}").status == 204
    assert put(f"{start}/shown", b"{}").status == 204
    assert put(f"{start}/answer", json.dumps(TOUCH).encode()).status == 204
    answer, n_shown = screen.store.answers(screen.study)[screen.name][1]
    assert n_shown == 2
    assert (answer.touch_x, answer.touch_y, answer.response_s) == (30.5, 80, 1.25)
    assert answer.device == "touch, picture 1152 px of a screen of 1280 px, 24 inch"


def test_a_report_that_is_sent_again_counts_once(space: Workspace, screen: OnScreen):
    start = f"{address(space)}/study/1"
    sent = [put(f"{start}/shown", json.dumps({"name": name}).encode()) for name in "aabb"]
    assert [answer.status for answer in sent] == [204] * 4
    assert put(f"{start}/answer", json.dumps(TOUCH).encode()).status == 204
    _, n_shown = screen.store.answers(screen.study)[screen.name][1]
    assert n_shown == 2


def test_an_answer_that_cannot_be_kept_now_is_the_servers_fault_and_kept_later(
    space: Workspace, screen: OnScreen, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    monkeypatch.setattr("nvcore.common.output.sqlite_file.WAIT_S", 0.01)
    address_of = f"{address(space)}/study/1/answer"
    with closing(sqlite3.connect(tmp_path / "studies.sqlite")) as other:
        other.execute("BEGIN EXCLUSIVE")
        answer = put(address_of, json.dumps(TOUCH).encode())
        other.rollback()
    assert (answer.status, "database is locked" in answer.text) == (503, True)
    assert put(address_of, json.dumps(TOUCH).encode()).status == 204


def test_an_answer_of_another_participant_is_not_taken_for_this_ones(
    space: Workspace, screen: OnScreen
):
    theirs = json.dumps({**TOUCH, "whose": f"{screen.study.token} OTHER"}).encode()
    assert put(f"{address(space)}/study/1/answer", theirs).status == 404
    assert screen.store.answers(screen.study) == {}
    own = json.dumps({**TOUCH, "whose": screen.whose}).encode()
    assert put(f"{address(space)}/study/1/answer", own).status == 204


def test_a_touch_outside_the_picture_is_no_answer(space: Workspace, screen: OnScreen):
    beside = json.dumps({**TOUCH, "touch": [study_pictures.WIDTH, 5]}).encode()
    answer = put(f"{address(space)}/study/1/answer", beside)
    assert (answer.status, "outside the picture (320 x 180 px)" in answer.text) == (400, True)
    assert screen.store.answers(screen.study) == {}


@pytest.mark.parametrize("place", ["0", "4", "x", "9" * 30])
def test_what_is_no_trial_of_the_participant_is_refused(
    space: Workspace, screen: OnScreen, place: str
):
    for kind, content in (("answer", json.dumps(TOUCH).encode()), ("shown", b"{}")):
        assert put(f"{address(space)}/study/{place}/{kind}", content).status == 400
    assert screen.store.answers(screen.study) == {}


def test_nobody_else_gets_pictures_or_sends_answers(space: Workspace, screen: OnScreen):
    start = f"{address(space)}/study/1"
    assert put("/nv/guess/study/1/answer", json.dumps(TOUCH).encode()).status == 404
    assert put(f"{start}/other", b"{}").status == 404
    assert put(f"{start}/answer", b" " * (MOST_BYTES + 1)).status == 413
    del space.notes[ON_SCREEN]
    assert put(f"{start}/answer", json.dumps(TOUCH).encode()).status == 404
    assert ask(f"{start}/full.png").status == 404
    assert screen.store.answers(screen.study) == {}


@pytest.mark.parametrize(
    "sent",
    [
        b"", b"[]", b"{", b"\xff", b"[" * 1900, b"{}",
        *(
            json.dumps({**TOUCH, **change}).encode()
            for change in (
                {"touch": [1]}, {"touch": "here"}, {"touch": [1, None]}, {"touch": [1, True]},
                {"measured_s": -1}, {"measured_s": "1"}, {"shown_s": math.nan},
                {"measured_s": 10**400}, {"response_s": math.inf}, {"is_answered": False},
            )
        ),
    ],
)  # fmt: skip
def test_what_is_no_answer_is_refused(sent: bytes):
    with pytest.raises(InputError):
        answer_of(sent_by_browser(sent))


def test_not_seen_no_answer_and_strange_devices():
    unseen = answer_of({**TOUCH, "touch": None, "pointer": "<b>"})
    assert (unseen.is_seen, unseen.is_answered) == (False, True)
    assert unseen.device == "picture 1152 px of a screen of 1280 px"
    sent = {**TOUCH, "touch": None, "response_s": None, "is_answered": False, "screen_px": -1}
    late = answer_of(sent, "24 inch")
    assert (late.is_answered, late.device) == (False, "touch, 24 inch")
    assert math.isnan(late.response_s)
