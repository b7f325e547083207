"""Boxes whose numbers mean another thing than they were taken for: found, named, and put right."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from field_files import session_of, written
from field_scene import PERSON, RIGHT, SIZE, detections, found, truth

from nvcore.auditing import audit
from nvcore.common.findings import Finding, Severity
from nvcore.comparison.compare import compare
from nvcore.inputs.box_layouts import BoxLayout
from nvcore.inputs.load import load
from nvcore.inputs.session import Session, Source, SystemSource
from nvcore.inputs.session.changes import applied


def layout_findings(session: Session) -> list[Finding]:
    return [finding for finding in audit(load(session)) if finding.code == "box-layout"]


def mended(session: Session) -> Session:
    """The session with the way on of each finding about the layout taken."""
    for finding in layout_findings(session):
        session = applied(session, finding.steps[0], ["x", "y"]) or session
    return session


LAYOUTS = [
    "corners",
    "centres",
    "sizes-yx",
    "corners-yx",
    "sizes-shares",
    "corners-shares",
    "centres-shares",
    "corners-percent",
    "corners-yx-thousandths",
]


@pytest.mark.parametrize("layout", LAYOUTS)
def test_a_wrong_meaning_of_the_numbers_is_an_error_whose_way_on_gives_the_right_values(
    tmp_path, layout
):
    session = session_of(tmp_path, x=layout, y=layout)
    findings = layout_findings(session)
    assert [(f.severity, f.subject, f.steps[0].value) for f in findings] == [
        (Severity.ERROR, "x", layout),
        (Severity.ERROR, "y", layout),
    ]
    right = mended(session)
    assert found(compare(load(right))) == RIGHT
    assert layout_findings(right) == []


def test_one_system_of_two_is_named_alone(tmp_path):
    session = session_of(tmp_path, y="corners")
    assert [finding.subject for finding in layout_findings(session)] == ["y"]
    assert found(compare(load(mended(session)))) == RIGHT


@pytest.mark.parametrize("layout", ["corners", "centres", "sizes-yx", "corners-shares"])
def test_the_truth_is_named_where_its_boxes_are_wrong(tmp_path, layout):
    session = session_of(tmp_path, truth=layout)
    (finding,) = layout_findings(session)
    assert (finding.subject, finding.steps[0].value) == ("truth", layout)
    assert "the systems agree" in finding.advice
    assert found(compare(load(mended(session)))) == RIGHT


def test_a_single_system_that_may_be_wrong_as_well_as_the_truth_is_said_to_be_either(tmp_path):
    session = session_of(tmp_path)
    session = replace(
        session, truth=replace(session.truth, boxes="centres"), systems=session.systems[:1]
    )
    (finding,) = layout_findings(session)
    ways = [(step.subject, step.value) for step in finding.steps]
    assert ways == [("x", "centres"), ("truth", "sizes")]


def test_sizes_where_corners_are_expected_are_found_though_most_have_no_area(tmp_path):
    session = session_of(tmp_path)
    for name in "xy":
        table = pd.read_csv(tmp_path / f"{name}.csv")
        names = {"x": "x1", "y": "y1", "w": "x2", "h": "y2"}
        table.rename(columns=names).to_csv(tmp_path / f"{name}.csv", index=False)
    findings = layout_findings(session)
    assert {(finding.subject, finding.steps[0].value) for finding in findings} == {
        ("x", "sizes"),
        ("y", "sizes"),
    }
    assert found(compare(load(mended(session)))) == RIGHT


def test_right_boxes_are_not_doubted(tmp_path):
    assert layout_findings(session_of(tmp_path)) == []


def test_a_system_that_sees_nobody_is_not_doubted(tmp_path):
    session = session_of(tmp_path)
    table = pd.read_csv(tmp_path / "x.csv")
    rng = np.random.default_rng(3)
    far = table.assign(x=rng.uniform(0, 600, len(table)), y=rng.uniform(0, 60, len(table)), h=40)
    far.to_csv(tmp_path / "x.csv", index=False)
    assert layout_findings(session) == []


def test_a_false_alarm_that_never_moves_fits_no_pedestrian_by_chance(tmp_path):
    session = session_of(tmp_path)
    standing = truth().query("track == 3").assign(x=100, y=200, w=40, h=110)
    written(tmp_path, "truth", standing, "sizes")
    for name in "xy":
        alarms = standing.assign(x=200, y=100, w=110, h=40, score=0.5).drop(columns="track")
        written(tmp_path, name, alarms, "sizes")
    assert layout_findings(session) == []


def test_results_of_coco_with_corners_are_read_as_corners_when_the_session_says_so(tmp_path):
    session = session_of(tmp_path)
    images = [
        {"id": n, "file_name": f"drive/{n:06d}.png", "width": SIZE[0], "height": SIZE[1]}
        for n in range(40)
    ]
    people = truth()[truth()["name"] == PERSON]
    boxes = [
        {"id": n, "image_id": row.frame, "category_id": 1, "bbox": [row.x, row.y, row.w, row.h]}
        for n, row in enumerate(people.itertuples(), start=1)
    ]
    content = {"images": images, "annotations": boxes, "categories": [{"id": 1, "name": PERSON}]}
    (tmp_path / "truth.json").write_text(json.dumps(content))
    for name in "xy":
        table = detections(name)
        results = [
            {
                "image_id": row.frame,
                "category_id": 1,
                "bbox": [row.x, row.y, row.x + row.w, row.y + row.h],
                "score": row.score,
            }
            for row in table[table["name"] == PERSON].itertuples()
        ]
        (tmp_path / f"{name}.json").write_text(json.dumps(results))
    session = replace(
        session,
        truth=Source("truth.json"),
        systems=tuple(SystemSource(f"{name}.json", name=name) for name in "xy"),
    )
    assert found(compare(load(session)))["matched"] == (0, 0)
    assert found(compare(load(mended(session)))) == RIGHT


def yolo(folder: Path, table: pd.DataFrame, layout: BoxLayout) -> None:
    """The pedestrians of a table as YOLO text, their numbers in this layout."""
    folder.mkdir()
    table = table[table["name"] == PERSON]
    whole = tuple(np.full(len(table), float(side)) for side in SIZE * 2)
    box = tuple(table[column].to_numpy(float) for column in "xywh")
    numbers = layout.numbers(box, table["score"].to_numpy(), whole)
    rows = pd.DataFrame(np.column_stack(numbers)).round(6)
    rows.insert(0, "class", 0)
    for frame in range(40):
        of_frame = rows[(table["frame"] == frame).to_numpy()]
        of_frame.to_csv(folder / f"{frame:06d}.txt", sep=" ", header=False, index=False)


@pytest.mark.parametrize("layout", ["centres", "corners"])
def test_yolo_text_with_other_numbers_is_found(tmp_path, layout):
    session = session_of(tmp_path)
    for name in "xy":
        yolo(tmp_path / name, detections(name), BoxLayout(layout, unit="shares"))
    session = replace(session, systems=tuple(SystemSource(name, name=name) for name in "xy"))
    assert found(compare(load(mended(session)))) == RIGHT


def test_a_confidence_taken_from_the_wrong_end_of_yolo_s_rows_is_found(tmp_path):
    # scores so low that the second number may be one, and a box that sticks out of the picture
    session = session_of(tmp_path)
    for name in "xy":
        table = detections(name)
        table = table.assign(score=table["score"] / 20)
        out = (table["frame"] == 0) & (table["x"] > 400)
        table.loc[out, "x"] = 630
        yolo(tmp_path / name, table, BoxLayout("centres", unit="shares"))
    session = replace(session, systems=tuple(SystemSource(name, name=name) for name in "xy"))
    (finding,) = layout_findings(session)  # X has no box at that edge
    assert (finding.subject, finding.steps[0].value) == ("y", "centres-shares")
    assert "score, centre x" in finding.message
    assert found(compare(load(mended(session))))["matched"] == (60, 101)
