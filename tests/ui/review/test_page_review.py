"""The Review page, driven without a browser."""

from __future__ import annotations

import zipfile
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest
import streamlit as st
from asgi import ask
from people import cookies, header, log_in_by
from places import SAMPLE
from streamlit.testing.v1 import AppTest

import nvcore as nv
from nvcore.common.errors import StoreError
from nvcore.subjects.review.calls import open_store
from nvcore.subjects.review.decisions import make_decision
from pages import (
    _sent,
    alone,
    begin_with,
    checked,
    measures,
    part,
    press,
    rows,
    space_of,
    texts,
    write,
)
from ui.access.people import key_of
from ui.session import state
from ui.session.workspace import Workspace
from ui.subjects.review import gallery, kept, projects

HEARS = "ui.subjects.review.gallery._hear(ui.subjects.review.gallery.cases_of(RESULT))"
PROJECTS = "ui.subjects.review.projects.draw()"
OPENS = "ui.subjects.review.projects.follow_address()"


class Context:
    """The browser of somebody who has logged in."""

    url = "https://tools.example/review"

    def __init__(self, name: str) -> None:
        self.cookies = cookies(name)
        self.theme = st.context.theme


@pytest.fixture(scope="module")
def page() -> AppTest:
    """The page on the sample, to look at."""
    return checked(alone("review").run())


def cases(page: AppTest) -> list[dict[str, Any]]:
    (data,) = _sent(page, "counts") or [{"cases": []}]
    listed: list[dict[str, Any]] = data["cases"]
    return listed


def shows(page: AppTest, **chosen: str) -> list[dict[str, Any]]:
    for name, value in chosen.items():
        page.session_state[f"review_{name}"] = value
    return cases(checked(page.run()))


def told(space: Workspace, *messages: dict[str, Any], client: str = "tab") -> None:
    """Send messages of the browser's gallery."""
    page = part(HEARS, space=space)
    page.session_state[gallery.KEY] = {"told": {"client": client, "messages": [*messages]}}
    checked(page.run())


def message(n: int, case: str, decision: str, **more: Any) -> dict[str, Any]:
    return {"n": n, "kind": "decide", "case": case, "decision": decision, "note": "", **more}


def again(space: Workspace) -> AppTest:
    """The page in a tab that is reloaded."""
    page = alone("review")
    page.session_state["workspace"] = space
    return checked(page.run())


@pytest.fixture
def own(page: AppTest) -> Iterator[Workspace]:
    """A tab's workspace with the sample open."""
    visit = checked(alone("review").run())
    yield space_of(visit)
    space_of(visit).close()


def found(x: int) -> str:
    """Detections of the pedestrian at `x`."""
    return rows(x).replace(",1,0.9", ",0.9")


def first_ids(space: Workspace, n: int) -> list[str]:
    return [one["id"] for one in cases(again(space))[:n]]


def test_every_case_is_shown_with_who_misses_and_how_severely(page: AppTest) -> None:
    shown = cases(page)
    assert len(shown) == 41
    assert shown[0]["about"] == "miss by X and Y, 1.60 s, pedestrian 3, oncoming_glare, frame 249"
    assert (shown[0]["who"], shown[0]["text"]) == ("xy", "X Y 1.60 s")
    assert shown[-1]["text"] == "Y 0.40 s, alarm"


def test_filters_and_orders_choose_what_is_shown() -> None:
    page = checked(alone("review").run())
    assert {one["who"] for one in shows(page, kind="false alarm")} == {"x", "y"}
    both = shows(page, kind="", system="xy")
    assert both
    assert {one["who"] for one in both} == {"xy"}
    by_time = shows(page, system="", order="time")
    assert [one["recording"] for one in by_time] != sorted(one["recording"] for one in by_time)
    names = [one["about"].split(", ")[-2] for one in by_time]
    assert names == sorted(names)
    assert shows(page, state="done") == []
    assert "No case passes the filters." in texts(page)


def test_a_session_without_pictures_has_its_cases(tmp_path: Path, monkeypatch: Any) -> None:
    for name, content in (("missed", ""), ("found", found(300))):
        (tmp_path / name).mkdir()
        systems = {"one": content, "two": found(300)}
        begin_with(write(tmp_path / name, systems, truth=rows(300)), monkeypatch)
        page = checked(alone("review").run())
        assert [one["who"] for one in cases(page)] == (["x"] if name == "missed" else [])
    assert "There is no case" in texts(page)


def test_decisions_are_kept_undone_and_outlast_a_reload(own: Workspace) -> None:
    one, other = first_ids(own, 2)
    first, second = message(1, one, "wrong truth", note="a pole"), message(2, other, "ask")
    told(own, first)
    told(own, first, second, message(3, "another", "ask"), message(4, one, "perfect"))
    page = again(own)
    assert [(of["mine"], of["note"], of["isDone"]) for of in cases(page)[:2]] == [
        ("wrong truth", "a pole", True),
        ("ask", "", False),
    ]
    assert _sent(page, "counts")[0]["counts"] == {"done": 1, "n": 41}
    told(own, message(5, one, "irrelevant"), {"n": 6, "kind": "undo"}, {"n": 7, "kind": "undo"})
    assert [of["mine"] for of in cases(again(own))[:2]] == ["wrong truth", ""]


@pytest.mark.parametrize("sent", [None, "x", [{"n": "1"}], ["x"], [{"n": 1, "case": []}]])
def test_malformed_messages_change_nothing(own: Workspace, sent: Any) -> None:
    page = part(HEARS, space=own)
    page.session_state[gallery.KEY] = {"told": {"client": "tab", "messages": sent}}
    checked(page.run())
    assert kept._TAB not in own.notes


def test_a_decision_that_cannot_be_stored_is_sent_again(
    own: Workspace, monkeypatch: pytest.MonkeyPatch
) -> None:
    (one,) = first_ids(own, 1)

    def refuse(*_: object, **__: object) -> None:
        raise StoreError("the file is locked")

    with monkeypatch.context() as patch:
        patch.setattr(kept, "decide", refuse)
        told(own, message(1, one, "ask"))
    told(own, message(1, one, "ask"))
    assert cases(again(own))[0]["mine"] == "ask"


def test_numbers_follow_decisions(own: Workspace) -> None:
    page = again(own)
    before = texts(page)
    assert "X leads by 0.083" in before
    assert "would turn it: **4**" in before
    chosen = [of["id"] for of in cases(page) if of["who"] == "y" and "alarm" not in of["text"]]
    told(own, *(message(n, case, "wrong truth") for n, case in enumerate(chosen, 1)))
    page = again(own)
    after = texts(page)
    assert f"Without the {len(chosen)} cases marked as wrong truth or irrelevant" in after
    assert "Y leads by" in after
    assert "before: X leads by 0.083" in after
    x, y, new_x, new_y = measures(page, "reviewed")["per encounter (s)"]
    assert (x, y) == ("0.189", "0.272")
    assert float(new_y) < float(new_x)


def test_decisions_travel_as_files(own: Workspace) -> None:
    one, other = first_ids(own, 2)
    page = again(own)
    made = make_decision(one, "wrong truth", reviewer="Bob")
    page.file_uploader[0].set_value(("bob.csv", made.to_csv(index=False).encode(), "text/csv"))
    press(checked(page.run()), "review_add")
    told(own, message(1, one, "real miss"), message(2, other, "ask"))
    shown = cases(again(own))
    assert shown[0]["others"] == "Bob: wrong truth"
    assert shown[0]["decision"] == "disputed"
    page.file_uploader[0].set_value(("no.csv", b"case\n1\n", "text/csv"))
    page = press(checked(page.run()), "review_add")
    assert "no column reviewer" in texts(page)


def kept_project(space: Workspace, name: str = "Night") -> str:
    page = checked(part(PROJECTS, space=space).run())
    page.text_input(key="review_project").set_value(name)
    press(page, "review_keep_it")
    token: str = space.notes[kept._PROJECT][0]
    return token


def test_a_comparison_is_kept_with_its_decisions_and_opened_by_its_address(
    own: Workspace, monkeypatch: pytest.MonkeyPatch
) -> None:
    (one,) = first_ids(own, 1)
    told(own, message(1, one, "wrong truth"))
    token = kept_project(own)
    page = again(own)
    assert page.query_params["project"] == token
    other = checked(alone("review", project=token, recording="winter_frost", frame="53").run())
    assert cases(other)[0]["decision"] == "wrong truth"
    assert space_of(other).opened.label == "Night"
    assert other.session_state["place"][0] == state.shared_start().opened.whole.recordings[
        "name"
    ].tolist().index("winter_frost")
    unknown = checked(alone("review", project="guessed").run())
    assert projects.NO_PROJECT.rstrip(".") in texts(unknown)
    assert len(cases(unknown)) == 41  # the sample's


def test_a_name_takes_what_its_tab_decided_along(own: Workspace) -> None:
    (one,) = first_ids(own, 1)
    told(own, message(1, one, "ask"))
    page = checked(part(PROJECTS, space=own).run())
    checked(page.text_input[0].set_value("Ann").run())
    assert cases(again(own))[0]["mine"] == "ask"
    token = kept_project(own)
    assert open_store().decisions(token)["reviewer"].tolist() == ["Ann"]
    visitor = checked(alone("review", project=token).run())
    assert cases(visitor)[0]["others"] == "Ann: ask"
    assert space_of(visitor).notes[kept.REVIEWER].startswith("guest ")


def test_two_who_decide_at_once_are_asked_which_to_keep(own: Workspace) -> None:
    one, other = first_ids(own, 2)
    token = kept_project(own)
    own.notes[kept.REVIEWER] = "Ann"
    store = open_store()
    for case in (one, other):
        store.decide(token, make_decision(case, "wrong truth", reviewer="Bob"))
    for n, (case, is_mine) in enumerate(((one, True), (other, False)), 1):
        told(own, message(n, case, "ask", seen=0))
        page = again(own)
        assert "**Bob** decided on this case meanwhile" in texts(page)
        press(page, f"review_keep_{is_mine}")
        assert "meanwhile" not in texts(page)
    shown = cases(again(own))
    assert [of["decision"] for of in shown[:2]] == ["disputed", "wrong truth"]


def test_what_others_decide_is_news_once(own: Workspace) -> None:
    (one,) = first_ids(own, 1)
    token = kept_project(own)
    page = again(own)
    news = part("import streamlit as st", "st.text(ui.subjects.review.kept.has_news())", space=own)
    assert news.run().text[0].value == "False"
    open_store().decide(token, make_decision(one, "ask", reviewer="Bob"))
    assert [news.run().text[0].value for _ in range(2)] == ["True", "False"]
    assert cases(page.run())[0]["others"] == "Bob: ask"


def test_a_project_is_exported_imported_and_deleted(own: Workspace, tmp_path: Path) -> None:
    token = kept_project(own)
    content = projects._exported(open_store(), token)
    page = checked(part(PROJECTS, space=own).run())
    press(page, f"review_ask_{token}")
    press(page, f"review_delete_{token}")
    assert open_store().projects() == []
    page.file_uploader(key="review_import").set_value(("night.zip", content, "application/zip"))
    press(checked(page.run()), "review_import_it")
    assert [of.name for of in open_store().projects()] == ["Night"]
    forged = tmp_path / "forged.zip"
    with zipfile.ZipFile(forged, "w") as archive:
        archive.writestr("project.json", "{}")
    page = checked(part(PROJECTS, space=own).run())
    sent = ("night.zip", forged.read_bytes(), "application/zip")
    page.file_uploader(key="review_import").set_value(sent)
    assert "is no project" in texts(press(checked(page.run()), "review_import_it"))


def test_uploads_are_copied(own: Workspace, tmp_path: Path, monkeypatch: Any) -> None:
    path = write(tmp_path, {"one": "", "two": found(300)}, truth=rows(300))
    begin_with(path, monkeypatch)
    page = checked(part(PROJECTS).run())
    monkeypatch.setattr(space_of(page), "folder", tmp_path)
    token = kept_project(space_of(page))
    inputs = open_store().inputs(token)
    assert {(of.path, of.is_copy) for of in inputs} == {
        (f"{name}.csv", True) for name in ("truth", "one", "two")
    }
    path.parent.joinpath("truth.csv").unlink()
    again = checked(alone("review", project=token).run())
    assert [one["who"] for one in cases(again)] == ["x"]
    # kept once more, after something was added to the copies
    with monkeypatch.context() as added:
        added.setattr(kept, "project", lambda: None)
        second = kept_project(space_of(again), "Rain")
    open_store().delete(token)
    assert open_store().changed_inputs(second) == []
    assert [one["who"] for one in cases(checked(alone("review", project=second).run()))] == ["x"]


def test_a_project_with_another_input_is_refused_and_the_page_goes_on(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = write(tmp_path, {"one": "", "two": found(300)}, truth=rows(300))
    begin_with(path, monkeypatch)
    token = kept_project(space_of(checked(part(PROJECTS).run())))
    assert not any(of.is_copy for of in open_store().inputs(token))
    (tmp_path / "one.csv").write_text((tmp_path / "two.csv").read_text())
    page = checked(alone("review", project=token, alpha="0.5").run())
    assert "changed since it was kept: one.csv" in texts(page)
    assert str(tmp_path) not in texts(page)
    assert [one["who"] for one in cases(page)] == ["x"]
    assert page.session_state["params"].alpha == 0.5


def test_only_members_open_a_project_and_only_its_owner_gets_crops(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    with log_in_by(tmp_path):
        monkeypatch.setattr(st, "context", Context("anna"))
        visit = checked(alone("review").run())
        token = kept_project(space_of(visit))
        space, one = space_of(visit), cases(visit)[0]
        url = crop_address(visit, one)
        assert ask(url, headers=header(cookies("anna"))).status == 200
        assert [ask(url, headers=header(cookies(name))).status for name in ("bert",)] == [403]
        assert ask(url).status == 403
        monkeypatch.setattr(st, "context", Context("bert"))
        assert projects.NO_PROJECT.rstrip(".") in texts(alone("review", project=token).run())
        page = part(PROJECTS).run()
        assert not [of for of in page.button if token in str(of.key)]
        open_store().add_member(token, "bert@lab.example")
        page = checked(alone("review", project=token).run())
        assert space_of(page).owner == key_of(cookies("bert")) != space.owner
        assert space_of(page).opened.label == "Night"


def crop_address(page: AppTest, one: dict[str, Any], *, box: Sequence[float] = ()) -> str:
    (data,) = _sent(page, "counts")
    at = one["at"]
    sides = ",".join(map(str, box or one["boxes"][at]))
    return f"{data['url']}/{one['recording']}/{one['rows'][at]}.jpg?box={sides}&{data['query']}"


def test_a_crop_shows_the_surroundings_of_a_box(page: AppTest) -> None:
    one = cases(page)[0]
    answer = ask(crop_address(page, one))
    assert (answer.status, answer.headers["content-type"]) == (200, "image/jpeg")
    assert answer.headers["cache-control"] == "private, max-age=3600"
    picture = cv2.imdecode(np.frombuffer(answer.body, np.uint8), cv2.IMREAD_COLOR)
    assert picture.shape == (200, 320, 3)
    # a session without pictures has boxes on a blank area
    space = space_of(page)
    pictures = space.pictures
    try:
        space.pictures = type(pictures)()
        blank = ask(crop_address(page, one))
    finally:
        space.pictures = pictures
    drawn = cv2.imdecode(np.frombuffer(blank.body, np.uint8), cv2.IMREAD_COLOR)
    assert drawn.std() < picture.std()
    assert drawn.max() > 150


@pytest.mark.parametrize(
    ("box", "status"),
    [
        ((1e9, 0, 1, 1), 400),
        ((1, 2, 3), 400),
        ((1, 2, 3, float("nan")), 400),
        ((-9, -9, 1, 1), 200),
    ],
)
def test_a_malformed_box_is_refused(page: AppTest, box: Sequence[float], status: int) -> None:
    assert ask(crop_address(page, cases(page)[0], box=box)).status == status


def test_python_sees_what_the_page_kept(own: Workspace) -> None:
    (one,) = first_ids(own, 1)
    kept_project(own)
    told(own, message(1, one, "wrong truth"))
    project = nv.open_project("Night")
    assert project.cases.set_index("case").loc[one, "decision"] == "wrong truth"
    assert SAMPLE.exists()


def test_a_project_counts_the_settings_whose_verdict_was_shown(own: Workspace) -> None:
    def overview(**address: str) -> str:
        page = alone("overview", **address)
        page.session_state["workspace"] = own
        return texts(checked(page.run()))

    assert "tried on these data" not in overview()
    kept_project(own)
    assert "setting 1 tried on these data, so each p is multiplied by 2" in overview()
    assert "setting 2 tried on these data, so each p is multiplied by 6" in overview(iou="0.3")
    assert "setting 1 tried" in overview()
