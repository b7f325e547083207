"""One search over transforms: what was done to the files is found, and following it mends them."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from field_scene import FPS, PERSON, RIGHT, SIZE, detections, found, truth

from nvcore.auditing import audit
from nvcore.common.findings import Finding, Severity
from nvcore.comparison.compare import compare
from nvcore.inputs.load import load
from nvcore.inputs.session import Session, Source, SystemSource
from nvcore.inputs.session.changes import applied
from nvcore.settings.params import Params

CODES = {"box-layout", "frame-rate", "time-offset", "pixel-offset", "scale-mismatch"}
Change = Callable[[pd.DataFrame], pd.DataFrame]


def people(name: str) -> pd.DataFrame:
    table = truth() if name == "truth" else detections(name)
    return table[table["name"] == PERSON].drop(columns="name")


def session_of(folder: Path, **changes: Change) -> Session:
    """The scene as CSV, its tables changed."""
    for name in ("truth", "x", "y"):
        table = people(name).pipe(changes.get(name, lambda table: table))
        table.to_csv(folder / f"{name}.csv", index=False)
    systems = tuple(SystemSource(f"{name}.csv", name=name) for name in "xy")
    return Session(folder, Source("truth.csv"), systems, size=SIZE, fps=FPS)


def transforms_of(session: Session, params: Params | None = None) -> list[Finding]:
    return [finding for finding in audit(load(session), params) if finding.code in CODES]


def followed(session: Session, findings: list[Finding]) -> Session:
    """The session with what the findings suggest: their first step, and their corrections."""
    for finding in findings:
        if finding.steps:
            session = applied(session, finding.steps[0], ["x", "y"]) or session
        values, at = dict(finding.suggestion), "xy".index(finding.subject)
        system = session.systems[at]
        scale = (values["scale"],) * 2 if "scale" in values else system.scale
        x, y = system.offset_px
        system = replace(
            system,
            frame_step=values.get("frame_step", system.frame_step),
            offset_frames=int(values.get("offset_frames", system.offset_frames)),
            scale=(values.get("scale_x", scale[0]), values.get("scale_y", scale[1])),
            offset_px=(values.get("offset_x_px", x), values.get("offset_y_px", y)),
        )
        systems = list(session.systems)
        systems[at] = system
        session = replace(session, systems=tuple(systems))
    return session


def numbered(step: int, first: int) -> Change:
    return lambda table: table.assign(frame=step * table["frame"] + first)


def boxed(sx: float, sy: float, dx: float, dy: float) -> Change:
    return lambda table: table.assign(
        x=sx * table["x"] + dx, y=sy * table["y"] + dy, w=sx * table["w"], h=sy * table["h"]
    )


def corners(table: pd.DataFrame) -> pd.DataFrame:
    return table.assign(w=table["x"] + table["w"], h=table["y"] + table["h"])


def centres(table: pd.DataFrame) -> pd.DataFrame:
    return table.assign(x=table["x"] + table["w"] / 2, y=table["y"] + table["h"] / 2)


def of_all(change: Change) -> dict[str, Change]:
    return {"x": change, "y": change}


CASES: dict[str, tuple[dict[str, Change], str]] = {
    "every 20th frame, renumbered": (
        {"truth": numbered(20, 0), "x": numbered(20, 0)},
        "frame = 20 x number",
    ),
    "every 10th frame, renumbered from 1": (
        {"truth": numbered(10, 0), "x": numbered(10, 0), "y": numbered(1, 1)},
        "frame = 10 x number - 10",
    ),
    "every 30th frame from 29, both renumbered": (
        {"truth": numbered(30, 29)},
        "frame = 30 x number + 29",
    ),
    "an uncommon step of the evaluated frames": (
        {"truth": numbered(25, 3)},
        "frame = 25 x number + 3",
    ),
    "a clip counted from 1": (
        {"truth": numbered(1, 98)} | of_all(numbered(1, 1)),
        "97 frames too early",
    ),
    "late": ({"y": numbered(1, 3)}, "3 frames too late"),
    "cropped": (of_all(boxed(1, 1, -40, -100)), "40.0 px too far left and 100.0 px too far up"),
    "bars above and below": (of_all(boxed(1, 1, 0, 80)), "80.0 px too far down"),
    "half the size": (of_all(boxed(0.5, 0.5, 0, 0)), "multiplied by 2"),
    "fitted into a square": (of_all(boxed(0.5, 0.5, 0, 40)), "multiplied by 2"),
    "squeezed into a square": (of_all(boxed(0.5, 2 / 3, 0, 0)), "2 across and 1.5 down"),
    "corners": (of_all(corners), "left, top, right, bottom"),
    "centres": (of_all(centres), "centre x, centre y, width, height"),
    "corners, late": (
        of_all(lambda table: corners(table).pipe(numbered(1, 2))),
        "left, top, right, bottom",
    ),
    "cropped, late": (
        of_all(lambda table: boxed(1, 1, -40, -60)(table).pipe(numbered(1, 2))),
        "2 frames too late",
    ),
}


@pytest.mark.parametrize(("changes", "text"), CASES.values(), ids=CASES)
def test_what_was_done_is_named_and_following_it_gives_the_right_numbers(tmp_path, changes, text):
    session = session_of(tmp_path, **changes)
    findings = transforms_of(session)
    assert findings
    assert {finding.severity for finding in findings} == {Severity.ERROR}
    assert len({finding.subject for finding in findings}) == len(findings)
    assert text in findings[-1].message
    right = followed(session, findings)
    assert transforms_of(right) == []
    matched = found(compare(load(right)))["matched"]
    assert abs(matched[0] - RIGHT["matched"][0]) <= 3  # of the frames at the ends of a lag
    assert abs(matched[1] - RIGHT["matched"][1]) <= 6


def test_half_a_correction_is_replaced_and_not_added_to(tmp_path):
    session = session_of(tmp_path, y=boxed(1, 1, -40, -100))
    half = replace(session.systems[1], offset_px=(20.4, 45.3))
    session = replace(session, systems=(session.systems[0], half))
    (finding,) = transforms_of(session)
    assert dict(finding.suggestion) == pytest.approx(
        {"offset_x_px": 40, "offset_y_px": 100}, abs=0.5
    )
    assert found(compare(load(followed(session, [finding])))) == RIGHT


def test_rows_without_a_place_are_not_reported_beside_the_frame_numbers_that_explain_them(tmp_path):
    findings = audit(load(session_of(tmp_path, truth=numbered(1, 98))))
    codes = {finding.code for finding in findings}
    assert "time-offset" in codes
    assert not codes & {"frame-not-listed", "no-detections", "agreed-by-both-alone"}


def kaist(folder: Path, left: float, top: float) -> Session:
    """Two pedestrians near the top left corner, and rows image number, x, y, w, h, score."""
    rows = [(f, 1, left + f / 2, top + f / 3, 90 + f / 2, 220 + f) for f in range(40)]
    rows += [(f, 2, left + 60 - f / 2, top + 20, 130, 260 - f / 2) for f in range(5, 40)]
    boxes = pd.DataFrame(rows, columns=["frame", "track", *"xywh"])
    content = {
        "images": [
            {"id": f, "file_name": f"set00_V000_I{f:05d}.jpg", "width": 640, "height": 512}
            for f in range(40)
        ],
        "annotations": [
            {"id": n, "image_id": f, "category_id": 1, "track_id": track, "bbox": box}
            for n, (f, track, *box) in enumerate(rows)
        ],
        "categories": [{"id": 1, "name": PERSON}],
    }
    (folder / "truth.json").write_text(json.dumps(content))
    rng = np.random.default_rng(0)
    sees = {"x": "track == 1 or frame >= 25", "y": "track == 2 or frame >= 10"}
    for name, condition in sees.items():
        table = boxes.query(condition).drop(columns="track")
        table[[*"xywh"]] += rng.uniform(-1.5, 1.5, (len(table), 4))
        table = table.assign(frame=table["frame"] + 1, score=rng.uniform(0.5, 1, len(table)))
        table.round(3).to_csv(folder / f"{name}.txt", header=False, index=False)
    systems = tuple(SystemSource(f"{name}.txt", name=name) for name in "xy")
    return Session(folder, Source("truth.json"), systems, fps=20)


@pytest.mark.parametrize(("left", "top"), [(4, 20), (60, 120)])
def test_two_systems_read_in_a_wrong_format_do_not_outvote_the_truth(tmp_path, left, top):
    session = kaist(tmp_path, left, top)
    findings = transforms_of(session)
    assert [(finding.subject, finding.steps[0].value) for finding in findings] == [
        ("x", "kaist-results"),
        ("y", "kaist-results"),
    ]
    right = followed(session, findings)
    assert transforms_of(right) == []
    assert found(compare(load(right)))["matched"] == (55, 65)


def test_another_format_is_judged_at_the_same_threshold(tmp_path):
    frames = range(1, 101)
    truth = [f"{f},{3 + f % 3},{10 + f % 5},120,300,1" for f in frames]
    (tmp_path / "drive.csv").write_text("\n".join(["frame,x,y,w,h,track", *truth]))
    # corners; as sizes they would fit nearly as well
    rows = [f"{f},{3 + f % 3},{10 + f % 5},{122 + f % 3},{309 + f % 5},{f / 100}" for f in frames]
    (tmp_path / "x").mkdir()
    (tmp_path / "x" / "drive.txt").write_text("\n".join(rows))
    source = SystemSource("x/drive.txt", name="x")
    session = Session(tmp_path, Source("drive.csv"), (source,), fps=FPS, size=SIZE)
    assert transforms_of(session) == []
    assert transforms_of(session, Params(threshold_x=0.9)) == []


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("are_frames_kept", [True, False])
def test_boxes_at_random_are_not_explained(tmp_path, seed, are_frames_kept):
    rng = np.random.default_rng(seed)

    def shuffled(table: pd.DataFrame) -> pd.DataFrame:
        if are_frames_kept:  # everything in a frame stays together
            order = rng.permutation(40)
            return table.assign(frame=order[table["frame"]]).sort_values("frame")
        return table.assign(**table[[*"xywh"]].sample(frac=1, random_state=seed).to_dict("list"))

    assert transforms_of(session_of(tmp_path, x=shuffled, y=shuffled)) == []
