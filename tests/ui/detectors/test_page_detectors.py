"""The Detectors page, driven without a browser."""

from __future__ import annotations

import re
from concurrent.futures import CancelledError
from pathlib import Path

import pytest
import small_icf
from onnx_models import blob_model
from streamlit.testing.v1 import AppTest

from nvcore.auditing import audit
from nvcore.common.findings import Severity
from nvcore.dataset.provenance import read_provenance
from nvcore.subjects.detectors.icf.model import fingerprint, from_bytes
from pages import (
    FRAMES,
    begin_with,
    checked,
    figures,
    opened,
    part,
    press,
    rows,
    texts,
    to_page,
    write,
)
from ui.access.files import LocalRoot
from ui.session.store import DETECTOR_BOX, DETECTOR_LEVELS, NEXT_PAGE
from ui.subjects.detectors import run, trial
from ui.subjects.detectors.confined import DetectorSpec
from ui.widgets.models import models_below

PEOPLE = {"recording": "urban_crossing", "frame": "120"}


@pytest.fixture(scope="module")
def model(tmp_path_factory: pytest.TempPathFactory) -> bytes:
    return small_icf.write(tmp_path_factory.mktemp("model") / "bars.npz").read_bytes()


def send(page: AppTest, name: str, content: bytes) -> AppTest:
    page.file_uploader(key="detector_file").set_value([(name, content, "")])
    return checked(page.run())


def parts(detector: str = "", **address: str) -> AppTest:
    """The choice, of this detector if any is named, the frame, and the run."""
    on_screen = "None if spec is None else ui.subjects.detectors.frame.draw(spec)"
    calls = (
        "spec = ui.subjects.detectors.choose.draw()",
        f"ui.subjects.detectors.run.draw_last({on_screen})",
    )
    page = part(*calls, **address)
    if detector:
        page.session_state["detector"] = detector
    return checked(page.run())


def with_model(model: bytes) -> AppTest:
    return send(parts(**PEOPLE), "bars.npz", model)


def headings(page: AppTest) -> list[str]:
    """Titles and subtitles of the figures, in their order."""
    metas = (figure["layout"]["meta"] for figure in figures(page))
    return [f"{title}: {subtitle}" for title, subtitle, *_ in metas if title]


def slider(page: AppTest, label: str):
    (labelled,) = [item for item in page.slider if item.label == label]
    return labelled


def recordings(page: AppTest):
    (field,) = [field for field in page.multiselect if field.label == "Recordings"]
    return field


def counts(page: AppTest) -> tuple[int, int]:
    before, after, *_ = page.metric
    return int(before.value.replace(",", "")), int(after.value.replace(",", ""))


def job(page: AppTest, kind: str):
    return page.session_state["workspace"].job(kind)


def timed(page: AppTest) -> AppTest:
    """The page on one recording, its run timed."""
    checked(recordings(page).set_value(["urban_crossing"]).run())
    press(page, "time_detector")
    job(page, run.TIMING.name).join()
    return checked(page.run())


def test_the_sample_begins_with_a_detector_whose_training_is_marked_and_not_chosen():
    page = parts(**PEOPLE)
    assert page.selectbox(key="detector").value == "icf:sample"
    assert "That is 7 of the 10 open recordings" in texts(page)
    assert counts(page)[1] > 0
    unseen = ["urban_sidewalk", "rural_cyclist", "odd_pose"]
    assert recordings(page).value == unseen
    assert "trained on this frame" in texts(page)
    assert "say nothing of others" not in texts(page)
    checked(recordings(page).set_value(["odd_pose", "urban_crossing", "winter_frost"]).run())
    trained = (
        "Trained on 2 of these 3: urban_crossing and winter_frost. Figures on them say nothing"
    )
    assert trained in texts(page)
    checked(page.selectbox(key="detector").set_value("hog").run())
    assert len(recordings(page).value) == 10  # it has seen none of them
    assert "trained on this frame" not in texts(page)


def test_a_detector_that_has_seen_all_recordings_is_run_over_all():
    page = parts(tags="summer", **PEOPLE)
    assert recordings(page).value == recordings(page).options
    assert "Trained on all that is chosen: summer_night. Figures on them say" in texts(page)


def test_a_built_in_detector_is_tried_on_the_current_frame_and_stays_over_other_pages():
    page = checked(opened("detectors", is_folded=True, **PEOPLE))
    checked(page.selectbox(key="detector").set_value("hog").run())
    (heading,) = headings(page)
    assert heading.startswith("HOG on frame 120")
    assert "the truth has 4" in heading
    assert counts(page) == (0, 0)
    assert "No box reaches the threshold: the most confident has" in texts(page)
    checked(slider(page, "Threshold").set_value(-1.0).run())
    n_before, n_after = counts(page)
    assert 0 < n_after < n_before
    assert "Click the mark in the middle of a box" in texts(page)
    page.session_state[DETECTOR_BOX.key] = (DetectorSpec("hog"), page.session_state["place"]), 0
    checked(slider(page, "Overlap").set_value(1.0).run())
    assert counts(page) == (n_before, n_before)
    pattern = r"\*\*Chosen box:\*\* score \S+, \d+ × \d+ px, IoU with the truth \S+: \w+"
    assert re.search(pattern, texts(page))
    # both stay while other frames are looked at
    (frame,) = [field for field in page.number_input if field.label == "Frame"]
    checked(frame.set_value(121).run())
    # and with the other choices when one comes back from another page
    checked(recordings(page).set_value(["odd_pose"]).run())
    checked(to_page(checked(to_page(page, "metrics")), "detectors"))
    assert page.selectbox(key="detector").value == "hog"
    assert recordings(page).value == ["odd_pose"]
    assert headings(page)[0].startswith("HOG on frame 121")
    assert slider(page, "Threshold").value == pytest.approx(-1.0, abs=0.02)


def test_what_the_comparison_would_make_of_the_boxes_stands_beside_them():
    page = parts(recording="odd_pose", frame="255")
    assert [metric.value for metric in page.metric][1:] == ["1", "0", "1", "1"]  # IoU 0.457
    assert "1 after: 0 matched, 1 false; the truth has 1, 1 missed" in headings(page)[0]
    page.session_state["settings"] = {"iou": 0.45}
    checked(page.run())
    assert [metric.value for metric in page.metric][2:] == ["1", "0", "0"]


def test_settings_and_training_are_the_detectors_own_and_what_the_page_is_told(
    monkeypatch: pytest.MonkeyPatch,
):
    page = parts("hog", **PEOPLE)
    items = [*page.number_input, *page.toggle, *page.selectbox]
    fields = {item.label: item for item in items}
    assert {"Stride", "Scale step", "Upscale", "Padding", "Person box"} <= {*fields}
    assert "Hit threshold" not in fields  # moved beside the picture
    checked(fields["Stride"].set_value(12).run())
    assert "stride: expected one of 8, 16, 24 ... 64, found 12" in texts(page)
    assert not page.metric
    (stride,) = [field for field in page.number_input if field.label == "Stride"]
    checked(stride.set_value(16).run())
    assert page.metric
    (trained,) = [box for box in page.multiselect if box.label.startswith("Also trained on")]
    checked(trained.set_value(["rural_road"]).run())
    timed(page)
    abouts = []

    def start(detector, *_: object, **__: object) -> None:
        abouts.append(detector.about)
        raise CancelledError

    monkeypatch.setattr(run, "run_detector", start)
    press(page, "run_detector")
    cancelled = job(page, run.RUN.name)
    cancelled.join()
    assert [part.recording for part in abouts[0].trained_on] == ["rural_road"]
    assert abouts[0].settings["stride"] == 16
    assert "Cancelled. No run was made." in texts(checked(page.run()))
    assert not cancelled.folder.exists()


def test_a_sent_model_is_described_and_shows_its_inside(model: bytes):
    page = with_model(model)
    assert page.selectbox(key="detector").value.startswith("sent ")
    words = texts(page)
    assert "20 trees" not in words  # the last round alone is the model
    assert "16 trees over windows of 16 × 32 px" in words
    assert "Trained on: urban_crossing, frames 0 to 20." in words
    names = [heading.partition(":")[0] for heading in headings(page)]
    assert names == ["bars on frame 120 of urban_crossing", "The picture, step by step", "Channels"]
    for view, names in {
        "map": ["Trees that each window came through"],
        "window": ["Running confidence of the window", "Tree 1"],
        "traces": ["Objects and background over the trees"],
        "training": ["Training error over the rounds"],
    }.items():
        checked(page.button_group(key="detector_view").set_value(view).run())
        assert [heading.partition(":")[0] for heading in headings(page)][1:] == names
        assert ("Windows of a picture" in texts(page)) == (view == "map")
    labels = {item.label for item in [*page.text_input, *page.number_input, *page.selectbox]}
    assert {"Scales", "Stride", "Cascade", "Overlap of"} <= labels


def test_what_is_no_model_is_refused_in_words():
    page = checked(part("ui.subjects.detectors.choose.draw()").run())
    for content, words in {
        b"PK\3\4 and so on": "bars.npz: is not a detector that nvcore train wrote, or is damaged",
        b"frame,x,y\n": "bars.npz: is text, no model; send a model that nvcore train wrote (.npz)",
        b"\x08\x08\x12\x04nvco": "those of visitors do not run here",
    }.items():
        shown = texts(send(page, "bars.npz", content))
        assert words in shown
        assert "model-detector" not in shown
        assert str(page.session_state["workspace"].folder) not in shown
    shown = texts(checked(page.selectbox(key="detector").set_value("hog:daimler").run()))
    assert "Detects the class" in shown


def test_networks_are_run_from_the_local_folder_alone(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    (tmp_path / "models").mkdir()
    blob_model(tmp_path / "models" / "blob.onnx", 640, 480)
    small_icf.write(tmp_path / "bars.npz")
    (tmp_path / "notes.txt").write_text("no model")
    assert models_below(LocalRoot(tmp_path), (".npz", ".onnx")) == ["bars.npz", "models/blob.onnx"]
    monkeypatch.setenv("NVCORE_LOCAL_ROOT", str(tmp_path))
    page = parts("local models/blob.onnx", **PEOPLE)
    assert headings(page)[0].startswith("blob on frame 120")
    assert slider(page, "Threshold").value == pytest.approx(0.25)
    assert counts(page)[1] > 0


def test_without_pictures_it_is_said_what_is_missing(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    lines = "".join(f"night,{frame},300,200,40,120,0.9\n" for frame in FRAMES)
    begin_with(write(tmp_path, {"one": lines}, truth=rows(300)), monkeypatch)
    page = parts()
    assert "A detector needs pictures, and none of the open recordings has any." in texts(page)
    assert not page.metric
    assert [button.key for button in page.button if button.key == "time_detector"] == []


def test_a_run_becomes_a_system_whose_training_the_audit_knows(
    model: bytes, monkeypatch: pytest.MonkeyPatch
):
    page = with_model(model)
    checked(slider(page, "Overlap").set_value(0.3).run())
    timed(page)
    assert "300 pictures of 1 recording on" in texts(page)
    levels = page.session_state[DETECTOR_LEVELS.key]
    press(page, "run_detector")
    done = job(page, run.RUN.name)
    done.join()
    checked(page.run())
    assert "**bars**: " in texts(page)
    assert "in 300 pictures of 1 recording" in texts(page)
    assert "Run over urban_crossing." in texts(page)
    assert run.packed(done.output).startswith(b"PK")
    own = fingerprint(from_bytes(model, "bars.npz"))
    record = read_provenance(done.output.provenance, "provenance.json").about
    assert record.settings["overlap"] == 0.3
    assert record.fingerprint == done.output.run.about.fingerprint != own
    words = "It becomes Y, at the threshold 0: where the slider stood when the run was started."
    assert words in texts(page)
    assert "other settings than those now on screen" not in texts(page)
    reruns = []
    with monkeypatch.context() as context:
        context.setattr(trial.st, "rerun", lambda: reruns.append("page"))
        checked(slider(page, "Threshold").set_value(1.0).run())
    assert reruns == ["page"]  # in a browser the slider alone would run the picture's part only
    assert "those now on screen: threshold 0 (now 1)." in texts(page)
    # it stays whatever cannot be used above
    (region,) = [field for field in page.text_input if field.label == "Region"]
    checked(region.set_value("5 5 5 5 5 5").run())
    assert "expected" in page.error[0].value
    assert "**bars**: " in texts(page)
    space = page.session_state["workspace"]
    press(page, "compare_detector")
    assert page.session_state[NEXT_PAGE.key] == "overview"
    session, dataset = space.opened.session, space.opened.dataset
    assert space.opened.label == "Sample recordings, with bars"
    assert dataset.compared() == ("FIR", "bars")
    assert dataset.systems == ("FIR", "NIR", "NIR 2", "bars")
    assert dataset.recordings["name"].tolist() == ["urban_crossing"]
    assert session.systems[3].threshold == next(iter(levels.values())).threshold
    assert len(dataset.system("bars")) == done.output.run.n_boxes
    (finding,) = [item for item in audit(dataset) if item.code == "trained-on-tested"]
    assert finding.severity is Severity.ERROR
    # and back
    page = checked(part("ui.subjects.detectors.run.draw_way_back()", space=space).run())
    press(page, "before_detector")
    assert space.opened.label == "Sample recordings"
    assert space.opened.dataset.systems == ("FIR", "NIR", "NIR 2")
    assert [button.key for button in page.button if button.key == "before_detector"] == []
