"""A study in a real browser: one participant, a reload in the middle, and the conductor."""

from __future__ import annotations

import csv
import re
from collections.abc import Iterator
from pathlib import Path

import pytest
import study_pictures
from app_server import ROOT, held_port, serve
from app_visit import Visit
from playwright.sync_api import BrowserContext, expect
from study_visit import (
    answer_both,
    begins,
    choose_folder,
    join,
    phase,
    pixel_on_screen,
    practise,
    shorten,
    start,
)

from nvcore.subjects.driver.study.touch_task import DetectabilityStore

N_PICTURES = 6  # so that every participant has three runs of two pictures
TIMES = (0, 0.1, 0.2, 0.3, 0.4, 0.5)


@pytest.fixture(scope="module")
def app(tmp_path_factory: pytest.TempPathFactory) -> Iterator[str]:
    """A server with a folder of pictures, which keeps its studies in a folder of the test."""
    folder = tmp_path_factory.mktemp("study")
    study_pictures.write(folder / "root" / "dusk", N_PICTURES)
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("NVCORE_LOCAL_ROOT", str(folder / "root"))
        patch.setenv("NVCORE_STUDIES", str(folder / "studies.sqlite"))
        with serve(ROOT / "app.py") as address:
            yield address


@pytest.fixture(scope="module")
def links(person: BrowserContext, app: str) -> tuple[str, str]:
    """Pages of the participants and of the conductor of a study that takes seconds."""
    one = Visit(person, app)
    one.go("study")
    choose_folder(one, "dusk")
    shorten(one, TIMES)
    expect(one.page.get_by_text("6 pictures in 3 runs")).to_be_visible()
    study, conduct = start(one)
    assert study.startswith("study?study=")
    assert conduct.startswith("study?conduct=")
    assert one.complaints == []
    one.close()
    return study, conduct


def place_on_screen(one: Visit, x: float, y: float) -> tuple[float, float]:
    """Where a pixel of a picture is in the window."""
    return pixel_on_screen(one, x, y, (study_pictures.WIDTH, study_pictures.HEIGHT))


def kept(place: int, kind: str) -> re.Pattern[str]:
    return re.compile(f"/study/{place}/{kind}$")


def test_a_participant_answers_by_mouse_keys_and_touch_and_a_reload_goes_on(
    visit, links, tmp_path: Path
):
    study, conduct = links
    one = visit(study)
    expect(one.keyed("navigation")).to_have_count(0)
    code = join(one)
    practise(one)

    # the first picture, by mouse; the second is seen, and the page loaded again
    begins(one, "Begin run 1 of 3")
    expect(phase(one, "answer")).to_have_count(1)
    with one.page.expect_response(kept(1, "answer")), one.page.expect_response(kept(2, "shown")):
        one.page.mouse.click(*place_on_screen(one, 100, 90))
    expect(phase(one, "answer")).to_have_count(1)
    one.page.reload()
    one.wait_until_drawn()
    expect(one.heading("Run 1 of 3")).to_be_visible()
    begins(one, "Begin run 1 of 3")
    expect(phase(one, "answer")).to_have_count(1)
    for key in ("ArrowLeft", "Shift+ArrowUp", "Enter"):  # from the middle
        one.page.keyboard.press(key)

    # by touch, then not seen; all that without leaving the dark
    begins(one, "Begin run 2 of 3")
    expect(phase(one, "answer")).to_have_count(1)
    x, y = place_on_screen(one, 300, 20)
    touch = {"pointerType": "touch", "clientX": x, "clientY": y}
    with one.page.expect_response(kept(3, "answer")):
        one.page.locator(".nv-study canvas").dispatch_event("pointerdown", touch)
    expect(phase(one, "answer")).to_have_count(1)
    one.page.get_by_role("button", name="Not seen").click()
    begins(one, "Begin run 3 of 3")
    answer_both(one)
    expect(one.heading("Thank you")).to_be_visible()
    expect(one.page.get_by_text(code).first).to_be_visible()

    conductor = visit(conduct)
    with conductor.page.expect_download() as download:
        conductor.page.get_by_role("button", name="Trials (CSV)").click()
    download.value.save_as(tmp_path / "trials.csv")
    with (tmp_path / "trials.csv").open(newline="") as file:
        rows = list(csv.DictReader(file))
    check_trials(rows)
    metrics = conductor.page.get_by_test_id("stMetric")
    expect(metrics.filter(has_text="have seen all pictures")).to_contain_text("1")


def test_a_run_that_is_stopped_goes_on_with_what_was_not_answered(visit, links):
    one = visit(links[0])
    join(one)
    practise(one)
    begins(one, "Begin run 1 of 3")
    expect(phase(one, "answer")).to_have_count(1)
    with one.page.expect_response(kept(1, "answer")), one.page.expect_response(kept(2, "shown")):
        one.page.keyboard.press("n")
    expect(phase(one, "answer")).to_have_count(1)
    one.page.keyboard.press("Escape")
    expect(one.page.locator(".nv-study dialog")).not_to_be_visible()
    expect(one.page.locator('.nv-study[data-run^="2 of"]')).to_have_count(1)
    begins(one, "Begin run 1 of 3")
    expect(phase(one, "answer")).to_have_count(1)
    with one.page.expect_response(kept(2, "answer")):
        one.page.get_by_role("button", name="Not seen").click()
    expect(one.page.locator('.nv-study[data-run^="3 of"]')).to_have_count(1)


def test_answers_outlive_a_restart_of_the_app_and_no_picture_is_shown_again(
    person: BrowserContext, app: str, links, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    file = tmp_path / "studies.sqlite"
    monkeypatch.setenv("NVCORE_STUDIES", str(file))
    with held_port() as port:
        with serve(ROOT / "app.py", port=port) as address:
            conductor = Visit(person, address)
            conductor.go("study")
            choose_folder(conductor, "dusk")
            shorten(conductor, TIMES)
            study, _ = start(conductor)
            conductor.close()
            one = Visit(person, address)
            one.go(study)
            code = join(one)
            practise(one)
            begins(one, "Begin run 1 of 3")
            expect(phase(one, "answer")).to_have_count(1)
            with one.page.expect_response(kept(2, "shown")):
                one.page.keyboard.press("n")
            expect(phase(one, "answer")).to_have_count(1)
        one.page.keyboard.press("n")
        expect(one.page.get_by_text("trying again. Leave this page open").first).to_be_visible()
        with serve(ROOT / "app.py", port=port):
            expect(one.page.locator('.nv-study[data-run^="3 of"]')).to_have_count(1)
            one.page.reload()
            expect(one.heading("Run 2 of 3")).to_be_visible()
            one.close()
    store = DetectabilityStore(file)
    begun = store.study(study.partition("=")[2])
    answers = store.answers(begun)[store.by_code(begun, code).name]
    assert {place: n_shown for place, (_, n_shown) in answers.items()} == {1: 1, 2: 1}


def check_trials(rows: list[dict[str, str]]) -> None:
    assert len({row["subject"] for row in rows}) == 1
    assert [(row["run"], row["position"], row["order"]) for row in rows] == [
        ("1", "1", "1"), ("1", "2", "2"), ("2", "1", "3"), ("2", "2", "4"),
        ("3", "1", "5"), ("3", "2", "6"),
    ]  # fmt: skip
    assert sorted(row["image"] for row in rows) == [f"scene_{i}.png" for i in range(N_PICTURES)]
    assert [row["not_seen"] for row in rows] == ["0", "0", "0", "1", "1", "1"]
    assert rows[3]["touch_x"] == rows[3]["touch_y"] == ""
    expected = [(100, 90), (160 - 64 / 6, 90 - 8 / 6), (300, 20)]
    for row, place in zip(rows, expected, strict=False):
        touch = (float(row["touch_x"]), float(row["touch_y"]))
        assert touch == pytest.approx(place, abs=0.5)
    assert [row["device"].split(",")[0] for row in rows] == [
        "mouse", "keyboard", "touch", "mouse", "keyboard", "keyboard",
    ]  # fmt: skip
    assert "shown 2 times" in rows[1]["device"]
    for row in rows:
        asked, measured = (
            float(row[name]) for name in ("adaptation_asked_s", "adaptation_measured_s")
        )
        assert asked in TIMES
        assert measured > asked - 0.03  # never early; how late depends on the machine
        assert float(row["response_s"]) > 0.15
        if measured > asked + 0.05:
            assert "late" in row["device"]


def test_the_pages_have_no_accessibility_fault(visit, links):
    study, conduct = links
    faults = []
    for theme in ("light", "dark"):
        one = visit("study", theme=theme)
        choose_folder(one, "dusk")
        faults += one.accessibility_faults()
        one.go(study)
        faults += one.accessibility_faults()
        join(one)
        expect(phase(one, "ready")).to_have_count(1)
        faults += one.accessibility_faults()
        one.go(conduct)
        faults += one.accessibility_faults()
    assert faults == []
