"""The Driver page, driven without a browser."""

from __future__ import annotations

import re
import threading
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
import small_estimator
from builders import at, make_dataset, result_of
from held_estimate import FORM, Held, send, sent
from picture_files import write_picture
from streamlit.testing.v1 import AppTest

from nvcore.common.errors import InputError
from nvcore.inputs.session import Session, Source
from nvcore.report.verdict import verdict
from nvcore.subjects.driver.calls.python import estimate_driver
from nvcore.subjects.driver.comparison.judging import DriverRegion
from nvcore.subjects.driver.comparison.steps import driver_in
from nvcore.subjects.driver.inputs.record import EstimateRecord
from nvcore.subjects.driver.running.writing import WrittenEstimates
from pages import (
    FRAMES,
    TIMEOUT_S,
    alone,
    begin_with,
    checked,
    figures,
    opened,
    part,
    press,
    space_of,
    tables,
    texts,
    to_page,
    write,
)
from ui.jobs.background import BackgroundJob
from ui.session import state, uploads
from ui.session.store import DRIVER_REGION, ENCOUNTER
from ui.session.workspace import Workspace
from ui.subjects.driver import run
from ui.subjects.driver.run import lost_words, with_estimates
from ui.widgets import drawing

LIST = "ui.subjects.driver.listed.draw(RESULT, ui.subjects.driver.regions.draw(RESULT))"
ONE = f"ui.subjects.driver.course.draw(RESULT, {LIST})"
"""Who sees whom, the list, and the pedestrian that is chosen in it."""


def course(encounter: int = 0, *, space: Workspace | None = None, **address: str) -> AppTest:
    """The part of one pedestrian."""
    call = f"ui.subjects.driver.course.draw(RESULT, {encounter})"
    return checked(part(call, space=space, **address).run())


def rows(x: int, detectability: float | str) -> str:
    return "".join(
        f"night,{frame},{x + frame},200,40,120,{x},{detectability}\n" for frame in FRAMES
    )


def write_seen(folder: Path) -> Path:
    """X detects one of two pedestrians, whom the driver sees; Y both."""
    boxes = {
        x: "".join(f"night,{frame},{x + frame},200,40,120,0.9\n" for frame in FRAMES)
        for x in (300, 100)
    }
    path = write(folder, {"one": boxes[300], "two": boxes[300] + boxes[100]}, truth="")
    head = "recording,frame,x,y,w,h,track,detectability\n"
    (folder / "truth.csv").write_text(head + rows(300, 0.8) + rows(100, 0.2))
    return path


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    begin_with(write_seen(tmp_path), monkeypatch)
    return tmp_path


@pytest.fixture(scope="module")
def page(tmp_path_factory: pytest.TempPathFactory) -> AppTest:
    """The whole page, to look at."""
    folder = tmp_path_factory.mktemp("seen")
    with pytest.MonkeyPatch.context() as patch:
        begin_with(write_seen(folder), patch)
        return checked(alone("driver").run())


def test_regions_and_encounters_say_who_sees_whom(page):
    regions, encounters = tables(page)
    counts = dict(zip(regions["who"], regions["encounters"], strict=True))
    assert {who: n for who, n in counts.items() if n} == {"driver, X and Y": 1, "Y alone": 1}
    assert encounters["detectability"].tolist() == [0.2, 0.8]
    assert "Pedestrian 100 of night" in [item.value for item in page.header]


def test_what_another_threshold_would_change_is_folded_away(page):
    (fold,) = [item for item in page.expander if item.label == "Over the threshold"]
    (plot,) = figures(fold)
    assert "2 near encounters of which it is known" in str(plot)


def test_at_equal_operating_points_there_is_one_comparison_to_show(page):
    assert "operating_point" not in {control.key for control in page.button_group}


def test_of_values_that_the_truth_states_nothing_is_said_of_an_estimator(page):
    assert "estimator of the longest period" not in texts(page)
    assert "The band is" not in texts(page)


def test_where_only_estimates_are_known_the_page_says_what_a_simulation_needs(page):
    assert page.toggle(key="driver_tunnel").disabled
    assert "features and an estimator are needed" in texts(page)


@pytest.fixture
def unequal(folder: Path) -> Path:
    """X also detects, by low scores, the other pedestrian and much that is not there."""
    more = "".join(
        f"night,{frame},{x + frame},200,40,120,0.3\n" for frame in FRAMES for x in (100, 400, 500)
    )
    with (folder / "one.csv").open("a") as boxes:
        boxes.write(more)
    other = (folder / "two.csv").read_text()
    (folder / "two.csv").write_text(other.replace(",200,40,", ",201,40,"))  # not the truth's own
    return folder


def test_at_unequal_operating_points_the_page_shows_what_the_verdict_shows(unequal):
    page = checked(alone("driver").run())
    assert "At equal false alarms, not as set (X at a confidence threshold of" in texts(page)
    of_verdict = "Of the 1 not seen, X detects 0 and Y 1"
    assert of_verdict in texts(page)
    counts = tables(page)[0].set_index("who")["encounters"]
    assert (counts["Y alone"], counts["X and Y"]) == (1, 0)
    assert of_verdict in "".join(verdict(space_of(page).result).sentences)
    checked(page.button_group(key="operating_point").set_value("as-set").run())
    assert "Nothing is claimed from these" in texts(page)
    assert "Of the 1 not seen, X detects 1 and Y 1" in texts(page)


def test_a_region_is_chosen_and_its_encounters_are_listed(page):
    page = checked(part(LIST, space=space_of(page)).run())
    checked(page.selectbox(key="driver_region").set_value(DriverRegion.DRIVER_X_Y).run())
    assert tables(page)[1]["detectability"].tolist() == [0.8]
    checked(page.selectbox(key="driver_region").set_value(DriverRegion.NOBODY).run())
    assert "No pedestrian is seen so." in texts(page)


def test_a_chosen_encounter_that_is_not_listed_is_said(page):
    space = space_of(page)
    page = part(ONE, space=space)
    page.session_state[DRIVER_REGION.key] = DriverRegion.Y
    page.session_state[ENCOUNTER.key] = (space.n_opened, "night:300")
    checked(page.run())
    assert "Pedestrian 100 of night" in [item.value for item in page.header]
    assert (
        "Pedestrian 300 of night is chosen, but is not in this list: the encounter is among those "
        "of driver, X and Y." in texts(page)
    )
    page.session_state[ENCOUNTER.key] = (space.n_opened, "night:100")
    assert "not in this list" not in texts(checked(page.run()))


def test_of_a_pedestrian_of_whom_nothing_is_known_a_sentence_stands_in_place_of_the_plot(folder):
    with (folder / "truth.csv").open("a") as truth:
        truth.write(rows(500, ""))
    page = checked(part(ONE).run())
    assert "Click a mark to see its frame" in texts(page)
    checked(page.selectbox(key="driver_region").set_value(DriverRegion.UNKNOWN).run())
    assert "Pedestrian 500 of night" in [item.value for item in page.header]
    assert (
        "In no frame is it known how detectable this pedestrian is: neither the ground truth nor"
        in texts(page)
    )
    assert "Click a mark to see its frame" not in texts(page)
    assert not page.toggle


def test_of_other_objects_the_page_speaks_as_of_pedestrians_and_of_the_driver_as_a_person(folder):
    session = folder / "session.toml"
    session.write_text(f'{session.read_text()}[compare]\nobjects = "cyclist"\n')
    with (folder / "truth.csv").open("a") as truth:
        truth.write(rows(500, ""))
    shown = texts(checked(alone("driver").run()))
    shown = re.sub(r"Trained on [^\n]*", "", shown)  # of the estimator, whatever is compared
    assert "Detectability is known for 60 of 90 cyclist boxes" in shown
    assert "at least 50 % of drivers would see the cyclist" in shown
    of_pedestrians = re.findall(r".{40}\b(?:pedestrians?|it needs|it is taken)\b.{20}", shown)
    assert of_pedestrians == []


def test_without_detectability_the_page_says_how_to_get_it():
    page = checked(alone("driver").run())
    assert "Whether the driver sees the pedestrians is not known yet" in texts(page)
    assert "nvcore driver estimate" in page.code[0].value
    assert not tables(page)


@pytest.fixture
def visible(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Two pedestrians in pictures of visible light, of whom nobody has said who sees them."""
    begin_with(small_estimator.write_session(tmp_path), monkeypatch)
    return tmp_path


def test_the_sample_s_estimator_can_be_tried_on_any_session_behind_one_that_was_sent(
    visible, monkeypatch: pytest.MonkeyPatch
):
    page = checked(part(*FORM).run())
    monkeypatch.setattr(state, "SAMPLE", Path("elsewhere") / "session.toml")
    checked(page.run())
    words = "sample: trained on a simulated observer, not on people"
    assert page.selectbox(key="estimator").options == [words]
    assert "The subjects were **simulated**" in texts(page)
    assert not page.button(key="driver_estimate").disabled
    chosen = send(page, small_estimator.write_model(visible / "small.npz")).selectbox("estimator")
    assert [option.split(":")[0] for option in chosen.options] == ["small.npz, as sent", "sample"]
    assert chosen.value.startswith("sent ")


def estimated(page: AppTest) -> Workspace:
    """The workspace once the estimates are open."""
    page, space = press(page, "driver_estimate"), space_of(page)
    if job := space.job("driver_run"):  # it may have ended already
        job.join()
    checked(page.run())
    return space


@pytest.fixture(scope="module")
def estimates(tmp_path_factory: pytest.TempPathFactory) -> Workspace:
    """A workspace with estimates, to look at."""
    folder = tmp_path_factory.mktemp("visible")
    with pytest.MonkeyPatch.context() as patch:
        begin_with(small_estimator.write_session(folder, first=600), patch)
        return estimated(sent(folder, soon_high=50.0))


def test_an_estimator_that_was_sent_is_run_and_says_whom_the_driver_sees(visible):
    form = sent(visible)
    space = estimated(form)
    page = checked(part("ui.subjects.driver.run.draw_notes()", LIST, space=space).run())
    regions, encounters = tables(page)
    counts = dict(zip(regions["who"], regions["encounters"], strict=True))
    assert {who: n for who, n in counts.items() if n} == {"driver, X and Y": 1, "X alone": 1}
    assert encounters["detectability"].tolist() == pytest.approx([0.1, 0.8], abs=0.01)
    assert "Light by the light meter: 1 change from bright to dark" in texts(page)
    # and anew, by one that says that nobody is ever seen
    estimated(send(form, small_estimator.write_model(visible / "dim.npz", 0.2)))
    assert tables(checked(page.run()))[1]["detectability"].max() < 0.2


def test_the_list_says_in_words_who_is_open_and_whether_the_driver_is_in_time(visible):
    encounters = tables(checked(part(LIST, space=estimated(sent(visible, late=0.65))).run()))[1]
    assert encounters["detectability"].round(2).tolist() == [0.06, 0.52]
    assert encounters["within_sd"].tolist() == ["no", "yes"]
    assert set(encounters["driver_in_time"].dropna()) <= {"yes", "no"}


def fold(page: AppTest):
    """The fold with the form, as it is sent to the browser."""
    (item,) = [item.proto for item in page.expander if item.label.startswith("Features and")]
    return item


def test_the_form_is_folded_beside_estimates_and_open_while_it_is_at_work(
    tmp_path, monkeypatch: pytest.MonkeyPatch
):
    may_end = threading.Event()

    def wait(*_: object, **__: object) -> None:
        may_end.wait(TIMEOUT_S)
        raise InputError("it has ended")

    begin_with(small_estimator.write_session(tmp_path, stated=0.1), monkeypatch)
    monkeypatch.setattr(run, "run_confined", wait)
    page = sent(tmp_path, "ui.subjects.driver.run.draw(is_known=True)")
    assert not fold(page).expanded
    assert fold(press(page, "driver_estimate")).expanded
    may_end.set()
    if job := space_of(page).job("driver_run"):  # it may have ended already
        job.join()
    assert fold(checked(page.run())).expanded
    assert "it has ended" in texts(page)


@pytest.mark.parametrize(
    ("trouble", "words"), [("gone", "cannot be copied"), ("full", "A session takes")]
)
def test_an_estimator_that_cannot_be_copied_is_said(
    visible, monkeypatch: pytest.MonkeyPatch, trouble: str, words: str
):
    page = sent(visible)
    space = space_of(page)
    used = space.used_bytes
    if trouble == "gone":
        next(space.folder.rglob("small.npz")).unlink()
    else:
        monkeypatch.setattr(uploads, "MAX_SESSION_BYTES", used)
    assert words in texts(press(page, "driver_estimate"))
    assert (space.used_bytes, space.job("driver_run")) == (used, None)
    assert not [*space.folder.glob("driver-*")]


def test_files_of_an_upload_are_named_from_its_folder(tmp_path: Path):
    folder = tmp_path / "driver-1"
    names = ("session.toml", "detectability.csv", "features.csv", "driver.json")
    written = WrittenEstimates(*(folder / name for name in names), run=None)
    sessions = [Session(place, Source("truth.csv"), ()) for place in (tmp_path, tmp_path / "other")]
    named = [with_estimates(session, written).driver for session in sessions]
    assert named[0].detectability == "driver-1/detectability.csv"
    assert named[1].provenance == str(folder / "driver.json")


def test_recordings_that_are_not_chosen_are_said_to_lose_their_estimates():
    names = ["a", "b", "c"]
    record = EstimateRecord(estimated_in=frozenset("ab"), stated_in=frozenset("c"))
    assert lost_words(record, names, ["c"]).endswith(": a and b would lose theirs.")
    assert lost_words(record, names, ["a", "c"]).endswith(": b would lose theirs.")
    for estimate, chosen in ((record, ["a", "b"]), (record, []), (None, ["a"])):
        assert lost_words(estimate, names, chosen) == ""


def test_each_file_that_is_sent_takes_the_place_of_what_was_said_of_the_one_before(visible):
    page = checked(part(*FORM).run())

    def errors(name: str, content: bytes) -> str:
        file = visible / name
        file.write_bytes(content)
        return "\n".join(error.value for error in send(page, file).error).replace("\\", "")

    not_trained = "other.npz: is not an estimator that nvcore driver train wrote"
    assert not_trained in errors("other.npz", b"PK no estimator")
    of_table = errors("trials.csv", b"subject,trial\n")
    assert of_table == "trials.csv: cannot be used here; send a file that ends in .npz"
    small = small_estimator.write_model(visible / "a.npz").read_bytes()
    assert errors("small.npz", small) == ""
    chosen = page.selectbox(key="estimator").value
    assert not_trained in errors("other.npz", b"PK no estimator")
    assert page.selectbox(key="estimator").value == chosen
    assert "Trained on 306 trials" in texts(page)


def panel(page: AppTest) -> str:
    tables = [item.proto.body for item in page.get("html") if "nv-numbers" in item.proto.body]
    return re.sub("<[^>]*>", " ", " ".join(tables))


def in_tunnel(page: AppTest) -> AppTest:
    return checked(page.toggle(key="driver_tunnel").set_value(True).run())


def test_features_and_estimate_of_the_frame_and_a_simulated_change_of_light(estimates):
    page = course(space=estimates)
    assert "Pedestrian 1 of drive" in [item.value for item in page.header]
    assert re.search(r"Detectability, estimator of 4\.5\ss\s+0\.80 ± 0\.10", panel(page))
    assert re.search(r"Luminance contrast\s+80\.0 grey levels", panel(page))
    assert "eyes adapted" in panel(page)
    assert "The eyes count as adapted" in texts(page)
    assert "the estimator of the longest period (4.5\N{NO-BREAK SPACE}s) is taken" in texts(page)
    assert "one number for each adaptation period" in texts(page)
    assert "outside of the training" not in texts(page)
    page = in_tunnel(page)
    assert (
        "After the change, outside of the training: Luminance contrast 80.0, trained on 0.0 to "
        "50.0 grey levels. Take it with care." in texts(page)
    )
    assert "Detectability, outside" not in texts(page)
    assert re.search(r"Since the change\s+0\.10 s, simulated", panel(page))
    # at once it is dark: the estimator of 0.5 s until 2.5 s later
    assert re.search(r"simulated change, estimator of 0\.5\ss\s+0\.16 ± 0\.10", panel(page))
    assert "The eyes count as adapted" not in texts(page)  # not of whom it became dark for
    assert "dark from 0.00 s on" in texts(page)
    assert "25 frames (2.50 s) later; without the change, the driver sees" in texts(page)
    assert (
        "the driver would **not** have seen the pedestrian; without the change, the driver would "
        "have" in texts(page)
    )
    page = checked(page.slider(key="driver_tunnel_s").set_value(1.0).run())
    # panel, plot and words count from the first frame, whatever its number
    assert "dark from 1.00 s on" in texts(page)
    assert re.search(r"Since the change\s+eyes adapted", panel(page))
    (plot,) = (item for item in figures(page) if "light" in str(item))
    changes = plot["layout"]["shapes"]
    assert [round(line["x0"], 6) for line in changes if line["line"]["dash"] == "dot"] == [1, 4]


def test_where_nothing_is_known_of_the_light_nobody_is_said_to_be_adapted(visible):
    (visible / "lux.csv").write_text("time_s,lux\n5.8,1000\n5.9,1000\n")
    page = course(space=estimated(sent(visible)))
    assert re.search(r"Since the change\s+not known", panel(page))
    assert "It is not known when the light last changed" in texts(page)
    assert "The eyes count as adapted" not in texts(page)


def test_beside_estimates_a_value_that_the_truth_states_is_called_so(tmp_path, monkeypatch):
    session = small_estimator.write_session(tmp_path, stated=0.7)
    for frame in range(30, small_estimator.N_FRAMES):
        (tmp_path / "visible" / f"{frame:03d}.png").unlink()
    begin_with(session, monkeypatch)
    page = course(1, space=estimated(sent(tmp_path)))
    assert re.search(r"Detectability, estimator of 4\.5\ss\s+0\.10 ± 0\.10", panel(page))
    page.session_state["place"] = (0, 59)
    assert re.search(r"Detectability\s+0\.70", panel(checked(page.run())))


def test_no_change_of_light_is_simulated_where_the_truth_states_all_values(tmp_path, monkeypatch):
    session = small_estimator.write_session(tmp_path, stated=0.7)
    add_grey_recording(session)
    begin_with(session, monkeypatch)
    page = sent(tmp_path)
    (recordings,) = (choice for choice in page.multiselect if choice.label == "Recordings")
    space = estimated(checked(recordings.set_value(["drive", "heat"]).run()))
    page = part(ONE, space=space)
    page.session_state[DRIVER_REGION.key] = DriverRegion.DRIVER_X_Y
    page.session_state[ENCOUNTER.key] = (space.n_opened, "heat:1")
    checked(page.run())
    assert "Pedestrian 1 of heat" in [item.value for item in page.header]
    assert re.search(r"Detectability\s+0\.70", panel(page))
    assert page.toggle(key="driver_tunnel").disabled
    assert "what is shown is the ground truth's" in texts(page)


def add_grey_recording(session: Path) -> None:
    """Add "heat", of the same boxes, to a small session: its pictures may be far infrared."""
    folder = session.parent
    (folder / "heat").mkdir()
    for path in (folder / "visible").iterdir():
        write_picture(folder / "heat" / path.name, np.full((240, 320), 90, np.uint8))
    for name in ("truth", "x", "y"):
        path = folder / f"{name}.csv"
        lines = path.read_text()
        path.write_text(lines + lines.partition("\n")[2].replace("drive,", "heat,"))
    with session.open("a") as text:
        text.write('[[recording]]\nname = "heat"\npictures = "heat"\n')


def test_a_light_meter_that_cannot_be_read_is_said_under_the_viewer(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    path = small_estimator.write_session(tmp_path, stated=0.5)
    (tmp_path / "lux.csv").write_text("time_s,lux\n0,bright\n")
    begin_with(path, monkeypatch)
    why = "How long ago the light has changed is not known: lux.csv, line 2"
    assert why in texts(course())


def test_clips_that_are_rated_do_not_ask_for_the_light(monkeypatch: pytest.MonkeyPatch):
    asked: list[int] = []
    monkeypatch.setattr(drawing, "visible_of", asked.append)
    result = result_of(make_dataset(truth=[at(0, 50)], x=[at(0, 50)], n_frames=1))
    monkeypatch.setattr(drawing, "state", SimpleNamespace(workspace=Workspace, theme=str))
    assert drawing.viewer_arguments(result, 0, with_visible=False)["visible"] is None
    assert asked == []
    drawing.viewer_arguments(result, 0)
    assert asked == [0]


@pytest.fixture(scope="module")
def estimated_by_command(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The session with estimates that the command line made."""
    folder = tmp_path_factory.mktemp("estimated")
    session = small_estimator.write_session(folder)
    small_estimator.write_model(folder / "small.npz", simulated="some")
    settings = {"drop_factor": 1000}  # by default 10: it then becomes dark
    return estimate_driver(session, folder / "small.npz", folder / "out", settings=settings).session


def test_the_clock_beside_estimates_of_a_file_is_that_of_their_record(
    estimated_by_command: Path, monkeypatch: pytest.MonkeyPatch
):
    begin_with(estimated_by_command, monkeypatch)
    page = course(1, recording="drive", frame="59")
    assert re.search(r"Since the change\s+eyes adapted", panel(page))
    assert "by our default settings" not in texts(page)
    # and the panel names a simulated observer
    assert "Detectability (learnt in part from simulated subjects)" in panel(page)


def test_where_no_record_says_how_light_was_judged_the_page_does(
    estimated_by_command: Path, monkeypatch: pytest.MonkeyPatch
):
    lines = estimated_by_command.read_text().splitlines()
    text = "\n".join(line for line in lines if not line.startswith("provenance"))
    session = estimated_by_command.with_name("no-record.toml")
    session.write_text(text)
    begin_with(session, monkeypatch)
    page = course(1, recording="drive", frame="59")
    assert re.search(r"Since the change\s+2\.00 s", panel(page))
    assert "by our default settings" in texts(page)


@pytest.fixture
def held(visible, monkeypatch: pytest.MonkeyPatch) -> Held:
    return Held(visible, monkeypatch)


def aside(page: AppTest) -> list[str]:
    """What the sidebar says of an estimate: progress, trouble, and the way to its page."""
    words = [item.proto.text.replace("\\", "") for item in page.get("progress")]
    words += [item.value for item in page.error]
    return words + [item.value for item in page.caption]


def test_an_estimate_that_ends_while_another_page_is_open_is_taken_over_there(held):
    page = checked(opened("export", space=held.space))
    page.session_state["place"] = (0, 41)
    page.slider(key="alpha").set_value(0.25)
    n_opened = held.space.n_opened
    held.ends()
    checked(page.run())
    assert driver_in(held.space.result).n_known == 2
    assert [item.value for item in page.title] == ["Export"]
    # nothing that was chosen is lost, and a reset still goes back to what the session says
    assert page.slider(key="alpha").value == 0.25
    assert held.space.opened.params.alpha == 0.9
    assert (page.session_state["place"], held.space.n_opened) == ((0, 41), n_opened)
    news = "Whom the driver sees is estimated in 1 recording. All pages count with it now."
    assert [item.value for item in page.sidebar.success] == [news]
    assert checked(page.run()).sidebar.success  # as long as the page is open
    assert not checked(to_page(page, "metrics")).sidebar.success
    assert not checked(to_page(page, "export")).sidebar.success


def test_the_sidebar_of_other_pages_shows_an_estimate_which_waits_for_other_work(held):
    assert aside(held.beside("driver")) == []  # the page itself says it
    page = held.beside("metrics")
    assert aside(page)[0].startswith("Estimating whom the driver sees: 0 %")
    assert aside(page)[1] == "Driver"
    is_over = threading.Event()

    def work(_: object) -> str:
        assert is_over.wait(TIMEOUT_S)
        return "boxes"

    other = BackgroundJob(work, held.space, outlasts=True)
    held.space.put_job("detector_run", other)
    held.ends()
    assert aside(checked(page.run())) == [
        "It is done, and waits until other work in this tab has ended",
        "Driver",
    ]
    assert not held.is_taken_over
    is_over.set()
    other.join()
    checked(page.run())
    assert held.is_taken_over
    assert aside(checked(page.run())) == ["Driver"]
    assert held.space.job("detector_run").output == "boxes"
    assert aside(held.beside("driver")) == []


def test_what_cannot_be_taken_over_is_said_beside_every_page_until_its_own_has_said_it(
    held, monkeypatch: pytest.MonkeyPatch
):
    def refuse(*_: object, **__: object) -> None:
        raise InputError("it cannot be opened")

    monkeypatch.setattr(state, "read_again", refuse)
    assert held.space.used_bytes > held.used_before  # the estimator was copied
    held.ends()
    assert "it cannot be opened" in aside(held.beside("metrics"))[0]
    assert (held.space.used_bytes, held.space.job("driver_run")) == (held.used_before, None)
    assert not held.job.folder.exists()
    form = checked(part(*FORM, space=held.space).run())
    assert "it cannot be opened" in texts(form)
    assert "it cannot be opened" not in texts(checked(form.run()))
    assert aside(held.beside("metrics")) == []


def test_a_fault_while_it_is_taken_over_leaves_no_news_and_is_not_tried_again(
    held, monkeypatch: pytest.MonkeyPatch
):
    def break_down(*_: object, **__: object) -> None:
        raise ValueError("a fault")

    monkeypatch.setattr(state, "read_again", break_down)
    held.ends()
    folder = held.job.folder
    page = opened("metrics", space=held.space)
    assert held.space.job("driver_run") is None
    assert not held.is_taken_over
    assert not page.sidebar.success
    assert not folder.exists()
    monkeypatch.undo()
    assert not checked(page.run()).sidebar.success


def test_other_pages_say_that_an_estimate_has_failed(visible, monkeypatch: pytest.MonkeyPatch):
    held = Held(visible, monkeypatch, fails="no picture can be read")
    held.ends()
    page = held.beside("metrics")
    assert aside(page) == ["Whom the driver sees could not be estimated.", "Driver"]
    assert "no picture can be read" in texts(checked(part(*FORM, space=held.space).run()))
    assert aside(held.beside("metrics")) == []
