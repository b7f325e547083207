"""Frame numbers of a system at another rate than those of the truth."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from builders import Box, Place, make_dataset
from field_scene import FPS, PERSON, SIZE, detections, truth

import nvcore as nv
from nvcore.auditing import audit, audit_inputs, audit_system
from nvcore.auditing.coverage import PART_CODE
from nvcore.common.findings import Finding, Severity
from nvcore.inputs.load import load
from nvcore.inputs.session import Session, Source, SystemSource

RATE_CODE = "frame-rate"


def session_of(tmp_path: Path, ground_truth: pd.DataFrame, system: pd.DataFrame) -> Session:
    ground_truth.to_csv(tmp_path / "truth.csv", index=False)
    system.to_csv(tmp_path / "y.csv", index=False)
    return Session(
        folder=tmp_path,
        truth=Source("truth.csv"),
        systems=(SystemSource("y.csv", name="Y"), SystemSource("y.csv", name="X")),
        size=SIZE,
        fps=FPS,
    )


def of_scene(tmp_path: Path, keep: object, renumber: object) -> Session:
    """Y ran on the frames that `keep` says, and numbered them as `renumber` says."""
    tables = []
    for table in (truth(), detections("y")):
        tables.append(table[table["name"] == PERSON].drop(columns="name"))
    y = tables[1][tables[1]["frame"].map(keep)]
    return session_of(tmp_path, tables[0], y.assign(frame=y["frame"].map(renumber)))


def always(frame: int) -> bool:
    return frame >= 0


def findings_of(session: Session) -> dict[str, Finding]:
    return {finding.code: finding for finding in audit_system(load(session), "Y", None)}


def n_matched(session: Session) -> int:
    return int(nv.compare(replace(session, x="Y", y="X")).x.matches.is_matched.sum())


def test_half_the_rate_is_an_error_that_names_the_factor_and_no_offset(tmp_path):
    session = of_scene(tmp_path, lambda i: i % 2 == 0, lambda i: i // 2)
    by_code = findings_of(session)
    assert by_code["frame-rate"].severity is Severity.ERROR
    assert "(frame = 2 x number)" in by_code["frame-rate"].message
    assert "51 of 110 pedestrians overlap one" in by_code["frame-rate"].message
    assert by_code["frame-rate"].suggestion == (("frame_step", 2.0),)
    assert "time-offset" not in by_code


def test_detections_in_a_part_only_are_not_told_beside_the_rate_that_explains_it(tmp_path):
    session = of_scene(tmp_path, lambda i: i % 2 == 0, lambda i: i // 2)
    dataset = load(session)
    assert PART_CODE in {finding.code for finding in audit_inputs(dataset)}
    codes = {finding.code for finding in audit(dataset)}
    assert RATE_CODE in codes
    assert PART_CODE not in codes


def test_with_the_factor_the_boxes_match_and_nothing_is_found(tmp_path):
    session = of_scene(tmp_path, lambda i: i % 2 == 0, lambda i: i // 2)
    right = replace(
        session, systems=(replace(session.systems[0], frame_step=2), session.systems[1])
    )
    assert n_matched(right) == 51
    assert n_matched(replace(right, frames="0:39:2")) == 51
    assert not {"frame-rate", "time-offset"} & findings_of(right).keys()


def test_an_offset_taken_before_does_not_hide_the_rate(tmp_path):
    session = of_scene(tmp_path, lambda i: i % 2 == 0, lambda i: i // 2)
    moved = replace(
        session, systems=(replace(session.systems[0], offset_frames=5), session.systems[1])
    )
    finding = findings_of(moved)["frame-rate"]
    assert "(frame = 2 x number)" in finding.message
    assert finding.suggestion == (("frame_step", 2.0), ("offset_frames", 0.0))


@pytest.mark.parametrize(
    ("keep", "renumber", "text"),
    [
        (lambda i: i % 2 == 1, lambda i: i // 2, "frame = 2 x number + 1"),
        (lambda i: i % 3 == 0, lambda i: i // 3, "frame = 3 x number"),
        (always, lambda i: 2 * i, "frame = 0.5 x number"),
        (always, lambda i: round(i * 30 / 25), "frame = 0.833333 x number"),
        (lambda i: i % 6 != 5, lambda i: i - (i + 1) // 6, "frame = 1.2 x number"),
    ],
    ids=["odd ones", "every third", "twice as many", "25 as 30 Hz", "30 as 25 Hz"],
)
def test_other_rates_are_found(tmp_path, keep, renumber, text):
    finding = findings_of(of_scene(tmp_path, keep, renumber))["frame-rate"]
    assert f"({text})" in finding.message


def walking(n_frames: int) -> pd.DataFrame:
    """Somebody who walks to and fro."""
    frame = np.arange(n_frames)
    x = 300 + 250 * np.sin(frame / 15)
    return pd.DataFrame({"frame": frame, "x": x, "y": 200, "w": 40, "h": 100})


@pytest.mark.parametrize("drift", [1.02, 0.985])
def test_clocks_that_drift_apart_are_found(tmp_path, drift):
    table = walking(800)
    system = table.assign(frame=np.rint(table["frame"] * drift).astype(int), score=0.9)
    finding = findings_of(session_of(tmp_path, table, system))["frame-rate"]
    factor = dict(finding.suggestion)["frame_step"]
    assert factor == pytest.approx(1 / drift, abs=0.002)


@pytest.mark.parametrize("offset", [0, 3])
def test_the_same_rate_is_not_doubted(tmp_path, offset):
    session = of_scene(tmp_path, always, lambda i: i + offset)
    assert "frame-rate" not in findings_of(session)


def test_boxes_that_fit_at_no_rate_are_not_doubted_for_it(tmp_path):
    rng = np.random.default_rng(3)
    table = walking(300)
    system = table.assign(x=rng.uniform(0, 600, 300), score=0.9)
    assert "frame-rate" not in findings_of(session_of(tmp_path, table, system))


def test_of_several_numbers_that_come_to_one_frame_the_nearest_stays(tmp_path):
    table = walking(40)
    system = pd.concat([table.assign(frame=2 * table["frame"] + half) for half in (0, 1)])
    session = session_of(tmp_path, table, system.sort_values("frame"))
    dataset = load(replace(session, systems=(replace(session.systems[0], frame_step=0.5),)))
    assert len(dataset.system("Y")) == 40
    assert "39 boxes between the frames left out" in dataset.inputs["conversion"][1]


def test_recordings_too_short_for_any_drift_have_no_other_rate():
    truth_boxes, system_boxes = (
        [
            Box(frame, 100 * i + 5 * frame + shift, 10, 20, 40, recording=recording)
            for recording in (0, 1)
            for frame in range(6)
            for i in range(4)
        ]
        for shift in (0, 50)
    )
    made = make_dataset(truth_boxes, system_boxes, places=[Place(range(6)), Place(range(6))])
    assert RATE_CODE not in [finding.code for finding in audit(made)]
