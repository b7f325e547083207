from __future__ import annotations

import dataclasses
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from builders import Box, make_dataset

from nvcore.auditing import audit
from nvcore.auditing.overlaps import Correction, above_threshold, take_sample
from nvcore.dataset import Dataset, dataset_from_tables
from nvcore.findings import Finding, Severity
from nvcore.inputs.readers.base import ReadOptions, Role, SourceFile
from nvcore.inputs.readers.mot import read
from nvcore.params import Params

SUSPICIONS = {"time-offset", "pixel-offset", "scale-mismatch"}


def suspicions(dataset: Dataset, params: Params | None = None) -> list[Finding]:
    return [finding for finding in audit(dataset, params) if finding.code in SUSPICIONS]


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


def test_detections_in_place_are_not_suspicious() -> None:
    assert suspicions(compare(moved(WALKS))) == []


@pytest.mark.parametrize("frames", [-5, -2, 1, 4])
def test_a_time_offset_is_found_with_its_value(frames: int) -> None:
    (finding,) = suspicions(compare(moved(WALKS, frames=frames)))
    assert (finding.code, finding.severity) == ("time-offset", Severity.WARNING)
    assert finding.suggestion == (("offset_frames", -frames),)


def test_a_time_offset_says_what_it_gains_and_how_to_mend_it() -> None:
    (finding,) = suspicions(compare(moved(WALKS, frames=2)))
    # 16 px off: IoU 24 / 56 of boxes 40 px wide, 20 / 52 of those 36 px wide; each walk begins
    # with two frames without a detection: (28 * 24 / 56 + 28 * 20 / 52) / 60 = 0.38
    assert "2 frames too late" in finding.message
    assert "mean IoU 1.00 instead of 0.38" in finding.message
    assert "offset_frames = -2" in finding.advice
    assert "--offset-frames-x -2" in finding.advice
    assert finding.subject == "x"


def test_the_largest_offset_tried_may_be_too_small() -> None:
    (finding,) = suspicions(compare(moved(WALKS, frames=5)))
    assert "No larger offset was tried" in finding.advice


def test_a_time_offset_counts_frame_numbers_where_frames_are_sampled() -> None:
    (finding,) = suspicions(compare(moved(WALKS, frames=1), step=20))
    assert finding.suggestion == (("offset_frames", -20.0),)


def test_a_time_offset_of_people_that_stand_still_is_not_suspicious() -> None:
    still = [Box(f, 300, 200, 40, 100, track=1) for f in range(80)]
    assert suspicions(compare(moved(still[:-2], frames=2), truth=still)) == []


def test_irregularly_listed_frames_tell_nothing_of_time() -> None:
    numbers = [f * (f + 1) // 2 for f in range(80)]  # no two gaps are the same
    truth = [box._replace(frame=numbers[box.frame]) for box in WALKS]
    late = [box._replace(frame=numbers[box.frame]) for box in moved(WALKS, frames=2)]
    made = make_dataset(truth, late, frames=numbers, width=640, height=480)
    assert "time-offset" not in [one.code for one in suspicions(made)]


def test_a_pixel_offset_is_found_with_its_value() -> None:
    (finding,) = suspicions(compare(moved(WALKS, x=6, y=-3)))
    assert (finding.code, finding.severity) == ("pixel-offset", Severity.WARNING)
    assert finding.suggestion == (("offset_x_px", -6.0), ("offset_y_px", 3.0))
    assert "6.0 px too far right and 3.0 px too far up" in finding.message
    assert "offset_px = [-6, 3]" in finding.advice
    assert "--offset-px-x -6,3" in finding.advice


def test_a_pixel_offset_so_large_that_no_box_overlaps_is_found() -> None:
    (finding,) = suspicions(compare(moved(WALKS, x=0, y=130)))
    assert finding.suggestion == (("offset_x_px", 0.0), ("offset_y_px", -130.0))


def test_counting_pixels_from_1_is_not_suspicious() -> None:
    assert suspicions(compare(moved(WALKS, x=1, y=1))) == []


def test_scattered_boxes_have_no_constant_offset() -> None:
    scattered = [box._replace(x=box.x + (15, -15, 12, -9)[box.frame % 4]) for box in moved(WALKS)]
    assert "pixel-offset" not in [one.code for one in suspicions(compare(scattered))]


def test_offsets_in_time_and_pixels_are_both_found() -> None:
    found = suspicions(compare(moved(WALKS, frames=2, y=25)))
    assert [one.suggestion for one in found] == [
        (("offset_frames", -2.0),),
        (("offset_x_px", 0.0), ("offset_y_px", -25.0)),
    ]


@pytest.mark.parametrize(("scale", "back"), [(0.5, 2.0), (2.0, 0.5), (0.8, 1.25), (0.4, 2.5)])
def test_another_resolution_is_found_with_its_scale(scale: float, back: float) -> None:
    (finding,) = suspicions(compare(moved(WALKS, scale=scale)))
    assert (finding.code, finding.severity) == ("scale-mismatch", Severity.WARNING)
    assert finding.suggestion == (("scale", back),)
    assert f"scale = {back:g}" in finding.advice


def test_a_usual_scale_is_found_beside_a_false_alarm_in_every_frame() -> None:
    clutter = [Box(f, 600, 10, 20, 20, score=0.7) for f in range(80)]
    (finding,) = suspicions(compare([*moved(WALKS, scale=0.5), *clutter]))
    assert finding.suggestion == (("scale", 2.0),)


def test_an_unusual_scale_is_measured() -> None:
    (finding,) = suspicions(compare(moved(WALKS, scale=0.37)))
    ((name, value),) = finding.suggestion
    assert name == "scale"
    assert value == pytest.approx(1 / 0.37, abs=0.002)


def test_different_scales_across_and_down_are_found() -> None:
    squeezed = [
        box._replace(x=box.x / 2, w=box.w / 2, y=box.y * 2 / 3, h=box.h * 2 / 3)
        for box in moved(WALKS)
    ]  # as for a network with an input of 320 x 320
    (finding,) = suspicions(compare(squeezed))
    assert finding.suggestion == (("scale_x", 2.0), ("scale_y", 1.5))
    assert "scale = [2, 1.5]" in finding.advice
    assert "--scale-x 2,1.5" in finding.advice


def test_scale_and_time_offset_are_both_found() -> None:
    found = suspicions(compare(moved(WALKS, scale=0.5, frames=2)))
    assert [one.suggestion for one in found] == [(("scale", 2.0),), (("offset_frames", -2.0),)]


def test_a_system_that_misses_most_is_not_suspicious() -> None:
    assert suspicions(compare(moved(WALKS[::6]))) == []


def test_few_detections_say_nothing() -> None:
    assert suspicions(compare(moved(WALKS[:20], frames=3))) == []


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
    (finding,) = [one for one in audit(renamed, x="y", y="y") if one.code in SUSPICIONS]
    assert finding.subject == "third"
    assert "--" not in finding.advice


def test_a_large_dataset_is_judged_by_a_sample() -> None:
    # 20 pedestrians and detections in each of 800 frames: 320,000 pairs
    truth = [
        Box(f, 30 * i + 6 * (f % 5), 200, 24, 60, track=i) for f in range(800) for i in range(20)
    ]
    made = make_dataset(truth, moved(truth, y=12), n_frames=800, width=640, height=480)
    (finding,) = suspicions(made)
    assert "judged by every 4th frame" in finding.message
    assert finding.suggestion == (("offset_x_px", 0.0), ("offset_y_px", -12.0))


def test_overlaps_at_the_ends_of_recordings_are_not_known() -> None:
    made = compare(moved(WALKS))
    overlaps = take_sample(made, made.system("x")).overlaps(Correction(offset_frames=15))
    # truth of frame f is held against detections of frame f - 15; frames 10..14 have none
    assert np.count_nonzero(~overlaps.has_frame) == 5
    assert overlaps.iou[~overlaps.has_frame].tolist() == [0] * 5


def test_a_threshold_keeps_detections_without_a_score() -> None:
    boxes = [Box(0, 1, 1, 1, 1, score=s) for s in (0.2, float("nan"), 0.8)]
    kept = above_threshold(make_dataset([], boxes).system("x"), 0.5)
    np.testing.assert_equal(kept.score, [np.nan, 0.8])
    assert kept.offsets.tolist() == [0, 2]


# real recordings

RECORDINGS = ("PETS09-S2L1", "TUD-Campus", "TUD-Stadtmitte", "ETH-Sunnyday")
SYSTEMS = {"det_frcnn": "det_frcnn/det.txt", "res_devkit": "res_devkit/{}.txt"}
Change = Callable[[pd.DataFrame], pd.DataFrame]


def mot15(folder: Path, recordings: tuple[str, ...], change: Change) -> Dataset:
    """MOT15 recordings with both systems; the detections of the first one changed."""

    def read_all(pattern: str, role: Role) -> pd.DataFrame:
        files = [
            SourceFile(folder / "mot15" / name / pattern.format(name), f"{name}/gt/gt.txt")
            for name in recordings
        ]
        return read(files, ReadOptions(role=role)).boxes

    infos = {}
    for name in recordings:
        text = (folder / "mot15" / name / "seqinfo.ini").read_text()
        infos[name] = dict(line.split("=") for line in text.split() if "=" in line)
    tables = [read_all("gt/gt.txt", "truth")]
    tables += [read_all(pattern, "detections") for pattern in SYSTEMS.values()]
    tables[1] = change(tables[1])
    frames = [np.arange(1, int(infos[name]["seqLength"]) + 1) for name in recordings]
    starts = np.cumsum([0, *map(len, frames)])
    number = {name: i for i, name in enumerate(recordings)}
    placed = []
    for source, table in enumerate(tables):
        recording = table["recording"].map(number).to_numpy()
        last = np.array([len(f) for f in frames])[recording]
        inside = (table["frame"] >= 1) & (table["frame"] <= last)
        index = starts[recording] + table["frame"] - 1
        columns = table.drop(columns=["recording", "frame"])
        placed.append(columns.assign(frame_index=index, source=source)[inside])
    sizes = pd.DataFrame(
        {
            "name": recordings,
            "width": [float(infos[name]["imWidth"]) for name in recordings],
            "height": [float(infos[name]["imHeight"]) for name in recordings],
            "fps": [float(infos[name]["frameRate"]) for name in recordings],
        }
    )
    return dataset_from_tables(sizes, frames, pd.concat(placed), list(SYSTEMS))


def scaled(boxes: pd.DataFrame, factor: float) -> pd.DataFrame:
    return boxes.assign(**{name: boxes[name] * factor for name in ("x", "y", "w", "h")})


@pytest.mark.realdata
@pytest.mark.parametrize("name", RECORDINGS)
def test_real_detections_are_not_suspicious(realdata: Path, name: str) -> None:
    assert suspicions(mot15(realdata, (name,), lambda boxes: boxes)) == []


@pytest.mark.realdata
def test_real_detections_of_all_recordings_are_not_suspicious(realdata: Path) -> None:
    assert suspicions(mot15(realdata, RECORDINGS, lambda boxes: boxes)) == []


@pytest.mark.realdata
@pytest.mark.parametrize("frames", [-3, 1, 5])
def test_real_detections_moved_in_time_are_found(realdata: Path, frames: int) -> None:
    made = mot15(realdata, RECORDINGS, lambda b: b.assign(frame=b["frame"] + frames))
    (finding,) = suspicions(made)
    assert (finding.subject, finding.suggestion) == (
        "det_frcnn",
        (("offset_frames", -float(frames)),),
    )


@pytest.mark.realdata
def test_real_detections_moved_in_the_picture_are_found(realdata: Path) -> None:
    made = mot15(realdata, RECORDINGS, lambda b: b.assign(x=b["x"] + 12, y=b["y"] - 5))
    (finding,) = suspicions(made)
    offset = dict(finding.suggestion)
    # Faster R-CNN itself draws its boxes up to 1 px off
    assert offset["offset_x_px"] == pytest.approx(-12, abs=1)
    assert offset["offset_y_px"] == pytest.approx(5, abs=1)


@pytest.mark.realdata
def test_real_detections_at_half_the_resolution_are_found(realdata: Path) -> None:
    (finding,) = suspicions(mot15(realdata, RECORDINGS, lambda b: scaled(b, 0.5)))
    assert finding.suggestion == (("scale", 2.0),)


@pytest.mark.realdata
def test_real_detections_moved_in_time_and_picture_are_found(realdata: Path) -> None:
    made = mot15(realdata, RECORDINGS, lambda b: b.assign(frame=b["frame"] + 2, x=b["x"] + 12))
    time, pixel = suspicions(made)
    assert time.suggestion == (("offset_frames", -2.0),)
    assert dict(pixel.suggestion)["offset_x_px"] == pytest.approx(-12, abs=1)


def test_two_offsets_that_cancel_are_not_found_where_the_boxes_fit_well() -> None:
    # one pedestrian at constant speed: five frames later is 15 px to the right
    truth = [Box(f, 100 + 3 * f, 200, 40, 100, track=1) for f in range(120)]
    x = [box._replace(x=box.x + 0.5, track=-1, score=0.9) for box in truth]
    made = make_dataset(truth, x, x, n_frames=120, width=640, height=480)
    assert not {"time-offset", "pixel-offset"} & {one.code for one in audit(made)}
