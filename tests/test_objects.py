"""A comparison of two detectors of speed signs, from the files to the verdict and the reports."""

from __future__ import annotations

import os
import re
from dataclasses import replace
from pathlib import Path

import pandas as pd
import pytest
from click.testing import CliRunner
from places import SAMPLE
from signs import write_signs

import nvcore as nv
from nvcore.cli import main
from nvcore.inputs.session import Session, Source
from nvcore.metrics.encounter_classes import classes_of
from nvcore.metrics.proximity.horizon import estimate_horizons
from nvcore.report.terminal import render_scorecard
from nvcore.settings.defaults import Settings
from nvcore.settings.objects import SPEED_SIGN, objects_from
from nvcore.subjects.time_left.kinds import Urgency
from nvcore.subjects.time_left.steps import time_left_in

OF_PEDESTRIANS = re.compile(r"\b(pedestrians?|persons?|him|his|whom|feet|ped)\b", re.IGNORECASE)


def said_of_pedestrians(text: str) -> list[str]:
    """What is still said of pedestrians, each with its surroundings."""
    return [text[max(0, m.start() - 60) : m.end() + 30] for m in OF_PEDESTRIANS.finditer(text)]


@pytest.fixture(scope="module")
def result(tmp_path_factory: pytest.TempPathFactory) -> nv.Comparison:
    return nv.compare(write_signs(tmp_path_factory.mktemp("signs")))


def test_a_sign_seen_in_one_of_five_frames_is_detected_at_a_coverage_of_a_fifth(
    result: nv.Comparison,
):
    # X matches sign 1 in 2 of 10 frames and sign 2 in none, Y in 1 of 10 and in 5 of 10
    table = result.encounters.set_index("track")
    assert table["coverage_x"].tolist() == [0.2, 0.0]
    assert table["coverage_y"].tolist() == [0.1, 0.5]
    assert table["category"].tolist() == ["x_only", "y_only"]
    at_a_half = nv.compare(result.dataset, coverage=0.5)
    assert at_a_half.encounters["category"].tolist() == ["neither", "y_only"]


def test_other_signs_of_the_file_are_left_out(result: nv.Comparison):
    assert len(result.dataset.truth) == 20
    assert "give way left out" in result.dataset.inputs["conversion"][0]


def test_scorecard_and_verdict_speak_of_speed_signs(result: nv.Comparison):
    text = render_scorecard(result.result)
    assert "20 speed sign boxes, 2 encounters" in text
    assert "severity of missed speed signs (s)" in text
    assert said_of_pedestrians(text) == []
    assert "time left" not in text.lower()


def test_tables_and_figures_do_too(result: nv.Comparison):
    labels = result.evidence()["label"].tolist()
    assert any("speed sign" in label for label in labels)
    assert said_of_pedestrians(" ".join(labels)) == []
    figures = [
        getattr(result.figures, name)()
        for name in dir(result.figures)
        if not name.startswith("_") and name != "dark"
    ]
    assert len(figures) > 20
    assert said_of_pedestrians(" ".join(figure.to_json() for figure in figures)) == []
    assert "speed sign 1" in result.figures.lanes().to_json()


def test_the_report_does_and_has_no_section_on_time_left(result: nv.Comparison, tmp_path: Path):
    result.write_html(
        tmp_path / "report.html", stability=False, author="The people of pedestrian-1"
    )
    page = (tmp_path / "report.html").read_text()
    page = re.sub(r"[A-Za-z0-9+/=]{200,}", "", page)  # pictures and Plotly
    assert [text for text in said_of_pedestrians(page) if "pedestrian-1" not in text] == []
    assert "The people of pedestrian-1" in page  # as the author wrote it
    assert "speed sign" in page
    assert 'id="time-left"' not in page


def test_names_that_users_gave_stay_as_they_are(tmp_path: Path):
    session = write_signs(tmp_path, x="Pedestrian_net", y="people counter")
    result = nv.compare(session)
    assert str(result).startswith("X = Pedestrian_net, all scores; Y = people counter, all scores")
    assert "20 speed sign boxes" in str(result)
    result.write_html(tmp_path / "report.html", stability=False)
    assert "Pedestrian_net (X) and people counter (Y) compared" in (
        tmp_path / "report.html"
    ).read_text(encoding="utf-8")


def test_the_files_of_a_report_compare_the_same_objects_again(
    result: nv.Comparison, tmp_path: Path
):
    result.write(tmp_path / "out")
    encounters = pd.read_csv(tmp_path / "out" / "encounters.csv")
    assert encounters["category"].tolist() == ["x_only", "y_only"]
    again = nv.compare(tmp_path / "out" / "session.toml")
    assert again.dataset.objects is SPEED_SIGN
    assert again.dataset.fingerprint == result.dataset.fingerprint
    assert str(again) == str(result)


def test_the_gate_judges_them(result: nv.Comparison):
    assert nv.gate(result, ["encounters_detected_y >= 1", "boxes_matched_x >= 2"])
    assert not nv.gate(result, ["newly_missed == 0"])


def test_flags_name_the_objects_as_the_session_does(tmp_path: Path):
    session = write_signs(tmp_path)
    files = [f"--{name}={tmp_path / name}.csv" for name in ("truth", "x", "y")]
    facts = [
        "--size=640x480",
        "--fps=10",
        "--frames=0:39",
        "--coverage=0.2",
        "--midpoint=20",
        "--spread=4",
    ]
    by_flags = CliRunner().invoke(main, ["compare", *files, *facts, "--objects=speed signs"])
    assert by_flags.exit_code == 0, by_flags.output
    assert "20 speed sign boxes, 2 encounters" in by_flags.output
    wrong = CliRunner().invoke(main, ["check", str(session), "--objects", "<b>"])
    assert wrong.exit_code == 2
    assert "expected a name of letters" in wrong.output


def test_python_names_them_likewise(tmp_path: Path):
    dataset = nv.load(write_signs(tmp_path), objects=("give way", "give ways"))
    assert len(dataset.truth) == 1
    assert dataset.objects.say("2 {many}") == "2 give ways"
    with pytest.raises(nv.NvcoreError, match="objects: expected a name of letters"):
        nv.load(write_signs(tmp_path), objects="<b>")


def test_without_a_word_a_class_of_signs_is_refused_with_the_classes_there_are(tmp_path: Path):
    session = nv.read_session(write_signs(tmp_path))
    with pytest.raises(nv.NvcoreError, match="no category is called person or pedestrian; found"):
        nv.compare(replace(session, objects=objects_from("pedestrian")))


def test_what_is_about_the_road_is_left_out_of_signs():
    # walkers and cyclists of the sample, told to be signs
    dataset = nv.load(SAMPLE).with_settings(Settings(x="FIR", y="NIR", objects=SPEED_SIGN))
    assert estimate_horizons(dataset) == (None,) * len(dataset.recordings)
    assert classes_of(dataset).members == {}
    counts = time_left_in(nv.compare(dataset).result).count_urgency()
    assert counts[Urgency.UNKNOWN] == sum(counts.values())


@pytest.mark.realdata
def test_real_signs_against_boxes_moved_by_known_shares(realdata: Path):
    # moved by a tenth of the width: IoU 0.9 / 1.1; by six tenths: 0.4 / 1.6
    source = Source(os.fspath(realdata / "gtsdb" / "train" / "gt.txt"))
    size = {"size": (1360, 800), "fps": 1.0}
    truth = nv.load(Session(realdata, source, (), **size, objects=SPEED_SIGN)).truth  # type: ignore[arg-type]
    frame = nv.load(Session(realdata, source, (), **size, objects=SPEED_SIGN)).frames["frame"]  # type: ignore[arg-type]
    boxes = pd.DataFrame(
        {
            "frame": frame.to_numpy()[truth.frame_index],
            "x": truth.x,
            "y": truth.y,
            "w": truth.w,
            "h": truth.h,
        }
    )
    x, y = (boxes.assign(x=boxes["x"] + share * boxes["w"]) for share in (0.1, 0.6))
    result = nv.compare(truth=source, x=x, y=y, size="1360x800", fps=1, objects="speed sign")
    assert (result.boxes.both, result.boxes.x_only, result.boxes.y_only) == (0, 238, 0)
    assert len(result.frames) == 248
    assert "238 speed sign boxes" in str(result)
    assert said_of_pedestrians(str(result)) == []
