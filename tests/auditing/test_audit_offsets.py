from __future__ import annotations

import dataclasses
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from builders import Box, make_dataset

from nvcore.auditing import audit, transforms
from nvcore.auditing.transform_search import trial_of
from nvcore.auditing.transforms import above_threshold
from nvcore.common.findings import Finding, Severity
from nvcore.dataset import Dataset
from nvcore.inputs.load import load
from nvcore.inputs.session import Session, Source, SystemSource
from nvcore.settings.params import Params

SUSPICIONS = {"time-offset", "pixel-offset", "scale-mismatch"}


def suspicions(dataset: Dataset, params: Params | None = None, **names: str) -> list[Finding]:
    return [finding for finding in audit(dataset, params, **names) if finding.code in SUSPICIONS]


def moved(
    boxes: list[Box], *, frames: int = 0, x: float = 0, y: float = 0, scale: float = 1
) -> list[Box]:
    return [
        box._replace(
            frame=box.frame + frames, x=scale * box.x + x, y=scale * box.y + y,
            w=scale * box.w, h=scale * box.h, score=0.5 + (box.frame % 7) / 20,
        )
        for box in boxes
    ]  # fmt: skip


# 80 frames: one pedestrian walks right by 8 px a frame, then another one left
WALKS = [
    *(Box(f, 40 + 8 * f, 200, 40, 100, track=1) for f in range(10, 40)),
    *(Box(f, 640 - 8 * f, 150, 36, 90, track=2) for f in range(40, 70)),
]


def compare(x: list[Box], *, step: int = 1, truth: list[Box] = WALKS) -> Dataset:
    """X against the walks; Y has every pedestrian exactly. Every `step`-th number is a frame."""
    rows = [[box._replace(frame=step * box.frame) for box in boxes] for boxes in (truth, x)]
    y = moved(rows[0])
    return make_dataset(*rows, y, frames=range(0, 80 * step, step), width=640, height=480)


STILL = [Box(f, 300, 200, 40, 100, track=1) for f in range(80)]


@pytest.mark.parametrize(
    ("x", "truth"),
    [
        (moved(WALKS), WALKS),
        (moved(WALKS, x=1, y=1), WALKS),
        (moved(WALKS[::6]), WALKS),
        (moved(WALKS[:20], frames=3), WALKS),
        (moved(STILL[:-2], frames=2), STILL),
    ],
    ids=["in place", "pixels from 1", "misses most", "few detections", "people stand still"],
)
def test_is_not_suspicious(x: list[Box], truth: list[Box]) -> None:
    assert suspicions(compare(x, truth=truth)) == []


@pytest.mark.parametrize(
    ("frames", "severity"),
    [
        (9, Severity.ERROR),
        (-5, Severity.ERROR),
        (-2, Severity.ERROR),
        (1, Severity.WARNING),
        (4, Severity.ERROR),
    ],
)
def test_a_time_offset_is_found_with_its_value_and_an_error_where_it_halves_the_overlap(
    frames: int, severity: Severity
) -> None:
    (finding,) = suspicions(compare(moved(WALKS, frames=frames)))
    assert (finding.code, finding.severity) == ("time-offset", severity)
    assert finding.suggestion == (("offset_frames", -frames),)


def test_a_time_offset_says_what_it_gains_and_how_to_mend_it() -> None:
    (finding,) = suspicions(compare(moved(WALKS, frames=2)))
    # 16 px off: IoU 24 / 56 of boxes 40 px wide, 20 / 52 of those 36 px wide; each walk begins
    # with two frames without a detection: (28 * 24 / 56 + 28 * 20 / 52) / 60 = 0.38
    assert "2 frames too late" in finding.message
    assert "mean IoU 1.00 instead of 0.38" in finding.message
    assert finding.subject == "x"


def test_a_time_offset_counts_frame_numbers_where_frames_are_sampled() -> None:
    (finding,) = suspicions(compare(moved(WALKS, frames=1), step=20))
    assert finding.suggestion == (("offset_frames", -20.0),)


def test_irregularly_listed_frames_tell_nothing_of_time() -> None:
    numbers = [f * (f + 1) // 2 for f in range(80)]  # no two gaps are the same
    truth = [box._replace(frame=numbers[box.frame]) for box in WALKS]
    late = [box._replace(frame=numbers[box.frame]) for box in moved(WALKS, frames=2)]
    made = make_dataset(truth, late, frames=numbers, width=640, height=480)
    assert "time-offset" not in [finding.code for finding in suspicions(made)]


def test_a_pixel_offset_is_found_with_its_value() -> None:
    (finding,) = suspicions(compare(moved(WALKS, x=6, y=-3)))
    assert (finding.code, finding.severity) == ("pixel-offset", Severity.WARNING)
    assert finding.suggestion == (("offset_x_px", -6.0), ("offset_y_px", 3.0))
    assert "6.0 px too far right and 3.0 px too far up" in finding.message


def test_a_pixel_offset_so_large_that_no_box_overlaps_is_found() -> None:
    (finding,) = suspicions(compare(moved(WALKS, x=0, y=130)))
    assert finding.suggestion == (("offset_x_px", 0.0), ("offset_y_px", -130.0))


def test_scattered_boxes_have_no_constant_offset() -> None:
    scattered = [box._replace(x=box.x + (15, -15, 12, -9)[box.frame % 4]) for box in moved(WALKS)]
    assert "pixel-offset" not in [finding.code for finding in suspicions(compare(scattered))]


@pytest.mark.parametrize(
    ("change", "code", "suggestion"),
    [
        ({"y": 25}, "time-offset", (("offset_x_px", 0.0), ("offset_y_px", -25.0))),
        ({"scale": 0.5}, "scale-mismatch", (("scale", 2.0),)),
    ],
)
def test_a_time_offset_is_found_together_with_another_fault(
    change: dict[str, float], code: str, suggestion: tuple
) -> None:
    (finding,) = suspicions(compare(moved(WALKS, frames=2, **change)))
    assert finding.code == code
    assert {*finding.suggestion} == {("offset_frames", -2.0), *suggestion}


@pytest.mark.parametrize(("scale", "back"), [(0.5, 2.0), (2.0, 0.5), (0.8, 1.25), (0.4, 2.5)])
def test_another_resolution_is_found_with_its_scale(scale: float, back: float) -> None:
    (finding,) = suspicions(compare(moved(WALKS, scale=scale)))
    assert (finding.code, finding.severity) == ("scale-mismatch", Severity.ERROR)
    assert finding.suggestion == (("scale", back),)


def test_a_usual_scale_is_found_beside_a_false_alarm_in_every_frame() -> None:
    clutter = [Box(f, 600, 10, 20, 20, score=0.7) for f in range(80)]
    (finding,) = suspicions(compare([*moved(WALKS, scale=0.5), *clutter]))
    assert finding.suggestion == (("scale", 2.0),)


def test_an_unusual_scale_is_measured() -> None:
    (finding,) = suspicions(compare(moved(WALKS, scale=0.37)))
    assert dict(finding.suggestion) == {"scale": pytest.approx(1 / 0.37, abs=0.002)}


def test_an_unusual_scale_is_measured_where_only_the_near_are_detected() -> None:
    far = [box._replace(x=box.x + 60, w=8, h=20, track=box.track + 2) for box in WALKS]
    x = moved(WALKS, scale=1.1, x=-8, y=4)
    (finding,) = suspicions(compare(x, truth=[*WALKS, *far, *far]))
    found = dict(finding.suggestion)
    assert found.pop("scale") == 0.909
    assert found == pytest.approx({"offset_x_px": 8 / 1.1, "offset_y_px": -4 / 1.1}, abs=1)


def test_different_scales_across_and_down_are_found() -> None:
    squeezed = [
        box._replace(x=box.x / 2, w=box.w / 2, y=box.y * 2 / 3, h=box.h * 2 / 3)
        for box in moved(WALKS)
    ]  # as for a network with an input of 320 x 320
    (finding,) = suspicions(compare(squeezed))
    assert finding.suggestion == (("scale_x", 2.0), ("scale_y", 1.5))


def test_only_detections_that_count_are_looked_at() -> None:
    late = [box._replace(score=0.9) for box in moved(WALKS, frames=2)]
    weak = [box._replace(score=0.1) for box in moved(WALKS)]
    dataset = compare([*late, *weak])
    assert suspicions(dataset) == []
    (finding,) = suspicions(dataset, Params(threshold_x=0.5))
    assert finding.suggestion == (("offset_frames", -2.0),)


def test_a_third_system_is_looked_at_without_naming_a_flag() -> None:
    made = compare(moved(WALKS, frames=2))
    renamed = dataclasses.replace(made, systems=("third", "y"))
    (finding,) = suspicions(renamed, x="y", y="y")
    assert finding.subject == "third"
    assert "--" not in finding.advice


def test_a_large_dataset_is_judged_by_a_sample(monkeypatch: pytest.MonkeyPatch) -> None:
    # 20 pedestrians and detections in each of 80 frames: 32,000 pairs
    monkeypatch.setattr(transforms, "MAX_PAIRS", 10_000)
    truth = [
        Box(f, 30 * i + 6 * (f % 5), 200, 24, 60, track=i) for f in range(80) for i in range(20)
    ]
    (finding,) = suspicions(compare(moved(truth, y=12), truth=truth))
    assert "judged by every 4th frame" in finding.message
    assert finding.suggestion == (("offset_x_px", 0.0), ("offset_y_px", -12.0))


def test_boxes_that_share_no_frame_are_judged_by_a_sample_too(monkeypatch: pytest.MonkeyPatch):
    # 20 pedestrians in each of 40 frames, 20 detections in each of the next 40: 16,000 pairs
    monkeypatch.setattr(transforms, "MAX_PAIRS", 10_000)
    truth = [Box(f, 30 * i, 200, 24, 60, track=i) for f in range(40) for i in range(20)]
    trial = trial_of(compare(moved(truth, frames=40), truth=truth), "x")
    assert (trial.every, trial.with_left_out().every) == (1, 2)


def test_a_threshold_keeps_detections_without_a_score() -> None:
    boxes = [Box(0, 1, 1, 1, 1, score=s) for s in (0.2, float("nan"), 0.8)]
    above = above_threshold(make_dataset([], boxes).system("x"), 0.5)
    np.testing.assert_equal(above.score, [np.nan, 0.8])
    assert above.offsets.tolist() == [0, 2]


# real recordings

RECORDINGS = ("PETS09-S2L1", "TUD-Campus", "TUD-Stadtmitte", "ETH-Sunnyday")


def suspicions_of_mot15(folder: Path, names: tuple[str, ...], **change: Any) -> list[Finding]:
    """What is said of MOT15 recordings with both systems, the first one's boxes changed."""

    def files(pattern: str) -> tuple[str, ...]:
        return tuple(f"{name}/{pattern.format(name)}" for name in names)

    systems = (
        SystemSource(files("det_frcnn/det.txt"), **change),
        SystemSource(files("res_devkit/{}.txt")),
    )
    session = Session(folder / "mot15", Source(files("gt/gt.txt")), systems)
    return suspicions(load(session))


@pytest.mark.realdata
@pytest.mark.parametrize("names", [*((name,) for name in RECORDINGS), RECORDINGS])
def test_real_detections_are_not_suspicious(realdata: Path, names: tuple[str, ...]) -> None:
    assert suspicions_of_mot15(realdata, names) == []


@pytest.mark.realdata
def test_real_detections_moved_in_time_and_picture_are_found(realdata: Path) -> None:
    change = {"offset_frames": 2, "offset_px": (12.0, 0.0)}
    (finding,) = suspicions_of_mot15(realdata, RECORDINGS, **change)
    # what the session has to say in the end: the offsets that were given are wrong
    suggestion = {"offset_frames": 2.0, "offset_x_px": 12.0, **dict(finding.suggestion)}
    assert suggestion["offset_frames"] == 0
    assert suggestion["offset_x_px"] == pytest.approx(0, abs=1)


def test_two_offsets_that_cancel_are_not_found_where_the_boxes_fit_well() -> None:
    # one pedestrian at constant speed: five frames later is 15 px to the right
    truth = [Box(f, 100 + 3 * f, 200, 40, 100, track=1) for f in range(120)]
    x = [box._replace(x=box.x + 0.5, track=-1, score=0.9) for box in truth]
    made = make_dataset(truth, x, x, n_frames=120, width=640, height=480)
    assert not {"time-offset", "pixel-offset"} & {finding.code for finding in audit(made)}
