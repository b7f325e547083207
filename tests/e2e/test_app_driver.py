"""The Driver page in a real browser: its diagram, and the way from a study to an estimate."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path

import pytest
import small_estimator
from app_server import ROOT, serve
from app_visit import Visit
from playwright.sync_api import BrowserContext, expect
from study_visit import (
    begins,
    choose_folder,
    join,
    phase,
    pixel_on_screen,
    practise,
    shorten,
    start,
)

import nvcore as nv
from nvcore.subjects.driver.calls.python import image_features
from nvcore.subjects.driver.study.plan import plan_trials
from nvcore.subjects.driver.study.settings import Timing
from nvcore.subjects.driver.trials import Judging

N_FRAMES = 30
N_PICTURES = 16
"""Eight pedestrians at each time: fewer are too few to train an estimator."""
TIMES_S = (0.0, 0.1)
# Place in the plot's area of the region of that name.
REGION = """(plot, name) => {
  const { _fullData: [regions], _fullLayout: { xaxis, yaxis } } = plot;
  const at = regions.customdata.indexOf(name);
  return [xaxis.d2p(regions.x[at]), yaxis.d2p(regions.y[at])];
}"""

# Whether the diagram counts so many in the regions of these names; it may not be drawn yet.
COUNTS = """([diagram, wanted]) => {
  const plot = diagram.querySelector(".js-plotly-plot");
  if (!plot?._fullData?.length) return false;
  const { _fullData: [regions], _fullLayout: { annotations } } = plot;
  const count = (name) => {
    const at = regions.customdata.indexOf(name);
    const text = annotations.find(({ x, y }) => x === regions.x[at] && y === regions.y[at])?.text;
    return Number(text?.replace(/<[^>]*>/g, ""));
  };
  return Object.entries(wanted).every(([name, number]) => count(name) === number);
}"""


def boxes(x: int, last: str) -> str:
    lines = (f"night,{frame},{x + frame},200,40,120,{last}\n" for frame in range(N_FRAMES))
    return "".join(lines)


@pytest.fixture
def address(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[str]:
    """The app with two pedestrians: the driver sees the first, X detects both, Y the first."""
    head = "recording,frame,x,y,w,h,"
    truth = boxes(100, "1,0.8") + boxes(300, "2,0.2")
    (tmp_path / "truth.csv").write_text(f"{head}track,detectability\n{truth}")
    (tmp_path / "x.csv").write_text(f"{head}score\n{boxes(100, '0.9')}{boxes(300, '0.9')}")
    (tmp_path / "y.csv").write_text(f"{head}score\n{boxes(100, '0.9')}")
    (tmp_path / "session.toml").write_text(
        f'[defaults]\nsize = "640x480"\nfps = 10\nframes = "0:{N_FRAMES - 1}"\n'
        '[truth]\npath = "truth.csv"\n'
        '[[system]]\nname = "one"\npath = "x.csv"\n[[system]]\nname = "two"\npath = "y.csv"\n'
    )
    monkeypatch.setenv("NVCORE_SESSION", str(tmp_path / "session.toml"))
    with serve(ROOT / "app.py") as url:
        yield url


def test_a_region_of_the_diagram_lists_its_encounters(address: str, person: BrowserContext):
    one = Visit(person, address)
    one.go("driver")
    expect(one.heading("Driver", level=1)).to_be_visible()
    expect(one.heading("Pedestrian 2 of night")).to_be_visible()  # the least detectable
    one.click_plot("driver_venn", REGION, "driver_x_y")
    expect(one.heading("Pedestrian 1 of night")).to_be_visible()
    assert one.accessibility_faults() == []
    assert one.complaints == []
    one.close()


@pytest.fixture
def study_and_drive(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[str]:
    """The app with a drive of which the truth says that no driver sees anybody, and a study."""
    session = small_estimator.write_session(tmp_path, stated=0.1)
    monkeypatch.setenv("NVCORE_SESSION", str(session))
    monkeypatch.setenv("NVCORE_LOCAL_ROOT", str(tmp_path / "root"))
    monkeypatch.setenv("NVCORE_STUDIES", str(tmp_path / "studies.sqlite"))
    small_estimator.write_study(tmp_path / "root" / "dusk", N_PICTURES)
    with serve(ROOT / "app.py") as url:
        yield url


def counts(one: Visit, regions: dict[str, int]) -> None:
    """Wait until the diagram counts so many in these regions."""
    diagram = one.keyed("driver_venn").element_handle()
    one.page.wait_for_function(COUNTS, arg=[diagram, regions])


def take_part(one: Visit, figures: list[tuple[int, int, int]]) -> None:
    """Go through the study as somebody who sees bright pedestrians and no others."""
    join(one)
    practise(one)
    timing = Timing(adaptation_s=TIMES_S, answer_s=0)
    run, n_runs = 0, N_PICTURES // 2
    for trial in plan_trials(N_PICTURES, 0, design="latin", timing=timing):
        if trial.run != run:
            run = trial.run
            begins(one, f"Begin run {run} of {n_runs}")
        x, y, level = figures[trial.picture]
        expect(phase(one, "answer")).to_have_count(1)
        with one.page.expect_response(lambda sent: sent.url.endswith("/answer")):
            if level == small_estimator.BRIGHT:
                size = small_estimator.WIDTH, small_estimator.HEIGHT
                w, h = small_estimator.FIGURE
                one.page.mouse.click(*pixel_on_screen(one, x + w / 2, y + h / 2, size))
            else:
                one.page.keyboard.press("n")
    expect(one.heading("Thank you")).to_be_visible()


def test_from_a_study_to_whom_the_driver_sees(
    study_and_drive: str, person: BrowserContext, tmp_path: Path
):
    pictures = tmp_path / "root" / "dusk"
    conductor = Visit(person, study_and_drive)
    conductor.go("study")
    choose_folder(conductor, "dusk")
    shorten(conductor, TIMES_S)
    study, conduct = start(conductor)

    # one subject goes through it
    subject = Visit(person, study_and_drive)
    subject.go(study)
    take_part(subject, small_estimator.study_figures(N_PICTURES))

    # the subject's answers train an estimator
    conductor.go(conduct)
    with conductor.page.expect_download() as download:
        conductor.page.get_by_role("button", name="Trials (CSV)").click()
    download.value.save_as(tmp_path / "trials.csv")
    image_features(pictures, pictures / "boxes.csv", tmp_path / "features.csv")
    nv.train_driver(
        tmp_path / "trials.csv",
        tmp_path / "features.csv",
        tmp_path / "trained.npz",
        judging=Judging(square_px=40, display_s=0.2),
        quick=True,
        n_threads=1,
    )

    # which says that a driver sees the bright one of two pedestrians
    one = Visit(person, study_and_drive)
    one.go("driver")
    expect(one.page.get_by_text("the driver sees 0 of 2 encounters")).to_be_visible()
    counts(one, {"x_y": 1, "driver_x_y": 0, "x": 1})
    one.page.get_by_text("Features and estimate").click()
    one.page.get_by_text("An estimator of your own").click()
    one.page.locator("input[type=file]").set_input_files(tmp_path / "trained.npz")
    expect(one.page.get_by_text("Trained on 16 trials of 1 subject")).to_be_visible()
    one.wait_until_drawn()
    one.page.get_by_role("button", name="Estimate", exact=True).click()
    expect(one.page.get_by_text("the driver sees 1 of 2 encounters")).to_be_visible()
    one.wait_until_drawn()
    counts(one, {"x_y": 0, "driver_x_y": 1, "x": 1})
    expect(one.page.get_by_text(re.compile("How it was estimated"))).to_be_visible()

    # each of them in the picture; and a change of light is simulated
    expect(one.viewer).to_have_attribute("data-picture", "visible")
    one.keyed("driver_tunnel").locator("label").first.click()
    expect(one.page.get_by_text("Simulated: dark from 0.00 s on")).to_be_visible()
    # the large viewer, not the small one that goes along
    one.heading("Pedestrian 2 of drive").evaluate("element => element.scrollIntoView()")
    one.viewer.press("d")
    expect(one.page.get_by_text("simulated: 0.10 s after the change")).to_be_visible()
    assert one.accessibility_faults() == []
    for visit in (conductor, subject, one):
        assert visit.complaints == []
        visit.close()


def test_an_estimate_is_taken_over_on_the_page_that_is_open_when_it_ends(visit):
    one = visit("driver")
    one.page.get_by_role("button", name="Estimate", exact=True).click()
    expect(one.page.get_by_text(re.compile("^Looking at the pictures"))).to_be_visible()
    one.find_entry("Export").click()
    expect(one.heading("Export", level=1)).to_be_visible()
    # the files that only the app has
    expect(one.page.get_by_text("(the ZIP has what was made here)")).to_be_visible()
    one.switch_to("Overview")
    expect(one.page.get_by_text("useful alerts: detected").first).to_be_visible()
