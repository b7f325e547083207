"""Routes: frames, boxes and uploads for the holder of a living session's token, and no one else."""

from __future__ import annotations

import asyncio
import json
import threading
from dataclasses import replace
from typing import Any

import cv2
import numpy as np
import plotly
import pytest
import streamlit as st
from asgi import ask, asked, put
from builders import at, make_dataset, result_of
from starlette.concurrency import run_in_threadpool

from nvcore.common.errors import MediaError
from nvcore.pictures.recordings import RecordingPictures
from ui.session.packed_comparison import pack_boxes, version_of
from ui.session.routes import PLOTLY, ROWS_PER_CHUNK, address, routes_below
from ui.session.workspace import Compared, Workspace
from ui.settings.start import base_path

PNG = b"\x89PNG\r\n\x1a\n" + bytes(100)
N_ROWS = ROWS_PER_CHUNK + 2


class Grey:
    """Pictures of one grey each: 40 times their index."""

    name, n, width, height, numbers = "grey", 3, 16, 8, None

    def read(self, index: int) -> np.ndarray:
        if index == 2:
            raise MediaError("picture 2 cannot be decoded", file=self.name)
        return np.full((8, 16), 40 * index, np.uint8)

    def close(self) -> None:
        """Nothing to let go of."""


class Slow(Grey):
    """Pictures that take until `go_on` is set."""

    def __init__(self) -> None:
        self.go_on = threading.Event()

    def read(self, index: int) -> np.ndarray:
        assert self.go_on.wait(60)
        return super().read(index)


@pytest.fixture
def space(space: Workspace) -> Workspace:
    """With a comparison of which the first frame has no picture, and the fourth a broken one."""
    dataset = make_dataset(truth=[at(3, 50)], x=[at(3, 50)], n_frames=N_ROWS)
    space.compared = Compared(result_of(dataset), "v1")
    space.pictures = RecordingPictures({0: Grey()}, {0: np.array([-1, 0, 1, 2])})
    return space


def frame(space: Workspace, row: object, query: str = "", recording: object = 0):
    return ask(f"{address(space)}/frame/{recording}/{row}.jpg{query}")


def test_a_row_gives_the_picture_that_shows_it_to_its_browser_alone(space: Workspace):
    answer = frame(space, 2)
    assert (answer.status, answer.headers["content-type"]) == (200, "image/jpeg")
    picture = cv2.imdecode(np.frombuffer(answer.body, np.uint8), cv2.IMREAD_GRAYSCALE)
    assert picture.shape == (8, 16)
    assert abs(float(picture.mean()) - 40) < 3
    assert answer.headers["cache-control"] == "private, max-age=3600"
    assert answer.headers["x-content-type-options"] == "nosniff"
    assert answer.headers["cross-origin-resource-policy"] == "same-origin"


def test_pictures_that_take_long_keep_no_thread_from_other_visitors(space: Workspace):
    slow = Slow()
    space.pictures = replace(space.pictures, sources={0: slow})
    url = f"{address(space)}/frame/0/1.jpg"

    async def visit() -> list[int]:
        many = [asyncio.create_task(asked(url)) for _ in range(60)]
        other = run_in_threadpool(lambda: "answered")
        assert await asyncio.wait_for(other, 30) == "answered"
        slow.go_on.set()
        return [(await answer).status for answer in many]

    assert asyncio.run(visit()) == [200] * 60


def test_a_comparison_that_is_no_longer_open_is_no_error(space: Workspace):
    assert space.compared is not None
    here = f"{address(space)}/comparison?v="
    version = version_of(space.compared.result)
    assert [ask(here + of).status for of in (version, "another")] == [200, 204]
    space.compared = None  # while another one is being opened
    assert ask(here + version).status == 204


@pytest.mark.parametrize(
    ("row", "recording"),
    [(0, 0), (4, 0), (10**30, 0), ("9" * 5000, 0), ("-1", 0), ("x", 0), (1, 1), (1, "9" * 40)],
)
def test_a_row_without_a_picture_is_not_found(space: Workspace, row: object, recording: object):
    answer = frame(space, row, recording=recording)
    assert answer.status == 404
    assert answer.headers["content-type"].startswith("text/plain")


def test_a_picture_that_cannot_be_decoded_is_told_in_words(space: Workspace):
    answer = frame(space, 3)
    assert (answer.status, answer.text) == (404, "picture 2 cannot be decoded")


@pytest.mark.parametrize(
    ("query", "status"),
    [
        *((query, 200) for query in ("?lo=1&hi=99", "?lo=0", "?hi=100")),
        *((query, 400) for query in ("?lo=60&hi=40", "?lo=nan", "?hi=inf", "?lo=-1", "?hi=x")),
    ],
)
def test_a_stretch_is_applied_or_refused(space: Workspace, query: str, status: int):
    assert frame(space, 1, query).status == status


@pytest.mark.parametrize("rest", ["frame/0/1.jpg", "visible/0/1.jpg", "boxes/0/0", "reasons/0/3"])
def test_neither_another_token_nor_that_of_an_ended_session_finds_anything(
    space: Workspace, rest: str
):
    space.visible = RecordingPictures({0: Edge()}, {0: np.array([-1, 0])}, maps={0: (1, 1, 0, 0)})
    start = address(space)
    assert ask(f"{start}/{rest}").status == 200
    assert ask(f"/nv/guess/{rest}").status == 404
    space.close()
    assert ask(f"{start}/{rest}").status == 404


def test_one_session_does_not_get_anothers_boxes(space: Workspace):
    other = Workspace()
    other.compared = Compared(result_of(make_dataset(truth=[at(0, 10)], n_frames=1)), "v1")
    mine, theirs = (ask(f"{address(of)}/boxes/0/0").body for of in (space, other))
    assert theirs == pack_boxes(other.result, 0, 1)
    assert mine != theirs


def test_boxes_come_in_chunks_of_rows(space: Workspace):
    assert space.result is not None
    first, last = (ask(f"{address(space)}/boxes/0/{chunk}").body for chunk in (0, 1))
    assert first == pack_boxes(space.result, 0, ROWS_PER_CHUNK)
    assert last == pack_boxes(space.result, ROWS_PER_CHUNK, N_ROWS)


def test_what_each_box_counts_and_costs_is_told_and_never_kept(space: Workspace):
    answer = ask(f"{address(space)}/reasons/0/3")
    assert answer.headers["content-type"] == "application/json"
    assert answer.headers["cache-control"] == "no-store"
    pedestrian, detection = json.loads(answer.body)
    assert (pedestrian["encounter"], detection["encounter"], detection["truth"]) == (0, 0, 0)
    assert detection["title"].startswith("Detection of X: matches")


@pytest.mark.parametrize("place", ["0/99999", "1/0", "0/99999999999999999999", "x/0", "0/x"])
def test_boxes_of_a_frame_that_is_not_there_are_not_explained(space: Workspace, place: str):
    assert ask(f"{address(space)}/reasons/{place}").status == 404


@pytest.mark.parametrize("place", ["0/2", "1/0", "0/99999999999999999999", "x/0"])
def test_boxes_of_frames_that_are_not_there_are_not_found(space: Workspace, place: str):
    assert ask(f"{address(space)}/boxes/{place}").status == 404


def test_boxes_of_the_newest_analysis_are_kept_under_its_version_only(space: Workspace):
    kept = ask(f"{address(space)}/boxes/0/0?v={space.version}")
    other = ask(f"{address(space)}/boxes/0/0?v=old")
    assert kept.headers["cache-control"] == "private, max-age=3600"
    assert other.headers["cache-control"] == "no-store"
    space.compared = None  # before an analysis there are none
    assert ask(f"{address(space)}/boxes/0/0").status == 404


def upload(space: Workspace, content: bytes = PNG, **more: str):
    return put(f"{address(space)}/upload/pictures?name=a.png", content, **more)


def test_a_sent_picture_is_stored_and_the_answer_holds_no_path_of_the_machine(space: Workspace):
    answer = put(f"{address(space)}/upload/pictures?name=..%2Fnight%2001.png", PNG)
    assert answer.status == 201
    assert (space.folder / "pictures" / "0" / "images" / "night 01.png").read_bytes() == PNG
    assert answer.headers["cache-control"] == "no-store"
    assert str(space.folder) not in answer.text


@pytest.mark.parametrize("slot", ["annotations", "..", "truth"])
def test_only_pictures_are_taken_and_only_for_a_known_token(space: Workspace, slot: str):
    assert put(f"{address(space)}/upload/{slot}?name=a.png", PNG).status == 404
    assert put("/nv/guess/upload/pictures?name=a.png", PNG).status == 404


def test_a_wrong_content_is_told_with_its_status(space: Workspace):
    answer = upload(space, b"frame,x,y\n")
    assert (answer.status, answer.headers["content-type"]) == (415, "text/plain; charset=utf-8")


@pytest.mark.parametrize(
    ("sent", "status"),
    [
        ({"headers": {"content-length": str(1 << 50)}}, 413),  # refused at once
        ({"chunks": [PNG]}, 400),
    ],
)
def test_an_upload_that_is_too_large_or_breaks_off_leaves_nothing(
    space: Workspace, sent: dict[str, Any], status: int
):
    place = f"{address(space)}/upload/pictures?name=a.png"
    assert ask(place, method="PUT", breaks_off=True, **sent).status == status
    assert [path for path in space.folder.rglob("*") if path.is_file()] == []


@pytest.mark.parametrize("method", ["POST", "DELETE"])
def test_other_methods_are_not_allowed(space: Workspace, method: str):
    assert ask(f"{address(space)}/upload/pictures", method=method).status == 405


@pytest.mark.parametrize("base", ["apps/night", "/apps/night/"])
def test_routes_and_addresses_lie_below_the_apps_base_path(
    space: Workspace, base: str, monkeypatch: pytest.MonkeyPatch
):
    monkeypatch.setattr(st, "get_option", lambda _: base)
    paths = {route.path.split("{")[0] for route in routes_below(base_path())}
    assert paths == {f"/apps/night{path}" for path in ("/overview", "/nv/", PLOTLY)}
    assert address(space) == f"/apps/night/nv/{space.token}"


def test_the_library_that_draws_figures_is_kept_by_the_browser():
    answer = ask(PLOTLY)
    assert answer.status == 200
    assert answer.headers["content-type"].startswith("text/javascript")
    assert "immutable" in answer.headers["cache-control"]
    assert plotly.__version__ in PLOTLY


@pytest.mark.parametrize("query", ["", "?alpha=0.4&recording=a%20b"])
def test_the_overview_s_own_name_leads_to_where_the_app_opens(query: str):
    answer = ask(f"/overview{query}")
    assert (answer.status, answer.headers["location"]) == (307, f"./{query}")


def test_an_address_that_is_no_text_is_none_that_is_known():
    assert ask("/overview?x=\udcff").headers["location"] == "./?x=%EF%BF%BD"


def visible(space: Workspace, row: object, query: str = ""):
    return ask(f"{address(space)}/visible/0/{row}.jpg{query}")


@pytest.fixture
def with_visible(space: Workspace) -> Workspace:
    space.visible = RecordingPictures({0: Edge()}, {0: np.array([-1, 0])}, maps={0: (1, 1, 0, 0)})
    return space


class Edge(Grey):
    """An edge of low contrast."""

    def read(self, index: int) -> np.ndarray:
        return np.repeat(np.uint8([[100 + index, 108 + index]]), 64, axis=0).repeat(64, axis=1)


def test_a_picture_of_visible_light_is_shown_as_it_is(with_visible: Workspace):
    answer = visible(with_visible, 1)
    picture = cv2.imdecode(np.frombuffer(answer.body, np.uint8), cv2.IMREAD_GRAYSCALE)
    assert (answer.status, picture.shape, int(np.ptp(picture))) == (200, (64, 128), 8)
    assert visible(with_visible, 0).status == 404
    assert frame(with_visible, 0).status == 404


def test_the_driver_sees_less_of_it_soon_after_the_light_has_changed(with_visible: Workspace):
    answer = visible(with_visible, 1, "?seen_s=0.5")
    picture = cv2.imdecode(np.frombuffer(answer.body, np.uint8), cv2.IMREAD_GRAYSCALE)
    assert np.ptp(picture[:, 54:74]) <= 2


@pytest.mark.parametrize("seconds", ["-1", "nan", "inf", "soon"])
def test_what_is_no_time_since_a_change_is_refused(with_visible: Workspace, seconds: str):
    assert visible(with_visible, 1, f"?seen_s={seconds}").status == 400


def test_a_recording_without_visible_light_has_no_such_picture(space: Workspace):
    assert visible(space, 1).status == 404
