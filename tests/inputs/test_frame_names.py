"""Pictures are found by what their names say: numbers, times, scenes, and what tools add."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from field_scene import (
    FPS,
    RIGHT,
    SIZE,
    coco_results,
    coco_truth,
    detections,
    found,
    truth,
    write_yolo,
)
from inputs import nvcore

import nvcore as nv
from nvcore.auditing.recordings import audit_frame_steps
from nvcore.common.errors import InputError
from nvcore.common.findings import Remedy, Severity, Step
from nvcore.inputs.load import load
from nvcore.inputs.readers.base import ReadOptions
from nvcore.inputs.readers.meaning.frame_names import named_pictures
from nvcore.inputs.session import Session, Source, SystemSource
from nvcore.inputs.session.toml import read_session, write_session

HASH = "0123456789abcdef0123456789abcdef"


def loaded(
    tmp_path: Path, names: dict[str, str], *, fps: float | None = FPS, **way: str
) -> nv.Dataset:
    session = Session(
        folder=tmp_path,
        truth=Source(names["truth"], **way),
        systems=tuple(SystemSource(names[side], name=side, **way) for side in "xy"),
        size=SIZE,
        fps=fps,
    )
    return load(session)


def compared(*files: Any, **facts: Any) -> tuple[dict[str, Any], nv.Dataset]:
    dataset = loaded(*files, **facts)
    return found(nv.compare(dataset)), dataset


def as_yolo(tmp_path: Path, **name_of: Callable[[int], str]) -> dict[str, str]:
    """Folders of truth, x and y; `name_of` of one side, or of `every`."""
    for side in ("truth", "x", "y"):
        write_yolo(tmp_path / side, side, name_of.get(side, name_of["every"]))
    return {side: side for side in ("truth", "x", "y")}


def as_json(tmp_path: Path, truth_document: object, of_frame: Callable[[int], dict]) -> dict:
    (tmp_path / "truth.json").write_text(json.dumps(truth_document))
    for side in "xy":
        (tmp_path / f"{side}.json").write_text(json.dumps(coco_results(side, of_frame)))
    return {side: f"{side}.json" for side in ("truth", "x", "y")}


JITTER = np.random.default_rng(4).integers(-6, 7, 40)


def at_ms(frame: int) -> int:
    return 1_598_000_000_123 + 100 * frame + int(JITTER[frame])


NAMES = {
    "milliseconds": lambda i: f"{at_ms(i)}.txt",
    "nanoseconds": lambda i: f"cam_{at_ms(i)}123456.txt",
    "seconds with a point": lambda i: f"{at_ms(i) / 1000:.3f}.txt",
    "seconds and nanoseconds": lambda i: f"{at_ms(i) // 1000}_{at_ms(i) % 1000 * 10**6}.txt",
    "nanoseconds since boot": lambda i: f"{at_ms(i) - 1_597_999_000_000}000000.txt",
    "date and time": lambda i: f"20230612_10111{i // 10}_{i % 10}00.txt",
    "Roboflow": lambda i: f"drive_mp4-{i:04d}_jpg.rf.{HASH}.txt",
    "Roboflow, short": lambda i: f"drive_mp4-{i:04d}.rf.k3JdLs9xQ2.txt",
    "camera": lambda i: f"set09_V000_I{i:05d}_lwir.txt",
    "unknown ending": lambda i: f"{i:06d}.left_eye.txt",
    "ending with a number": lambda i: f"drive_{i:06d}_cam2.txt",
    "Cityscapes": lambda i: f"ulm_000000_{i:06d}_leftImg8bit.txt",
    "Label Studio": lambda i: f"{i * 2654435761 % 2**32:08x}-frame_{i:04d}.txt",
}


@pytest.mark.parametrize(
    ("of_truth", "of_systems"),
    [
        (lambda i: f"{i:06d}_gtFine.txt", lambda i: f"{i:06d}_leftImg8bit.txt"),
        (lambda i: f"drive_mp4-{i:04d}_jpg.rf.{HASH}.txt", lambda i: f"drive-{i:04d}.txt"),
        (lambda i: f"I{i:05d}.txt", lambda i: f"I{i:05d}_lwir.txt"),
        (lambda i: f"{at_ms(i)}.txt", lambda i: f"pred_{at_ms(i)}.txt"),
        # another sensor: some milliseconds later
        (lambda i: f"{at_ms(i)}.txt", lambda i: f"{at_ms(i) + 23}.txt"),
    ],
    ids=["Cityscapes", "Roboflow", "camera", "common beginning", "other times"],
)
def test_pictures_of_truth_and_systems_meet_although_their_names_differ(
    tmp_path, of_truth, of_systems
):
    names = as_yolo(tmp_path, truth=of_truth, every=of_systems)
    assert compared(tmp_path, names)[0] == RIGHT


def test_times_give_the_frame_rate_and_are_said(tmp_path):
    dataset = loaded(tmp_path, as_yolo(tmp_path, every=NAMES["milliseconds"]), fps=None)
    assert dataset.recordings["fps"].tolist() == [10]
    assert "numbers taken as times (milliseconds)" in dataset.inputs["conversion"][0]


def test_another_rate_than_that_of_the_times_is_reported(tmp_path):
    dataset = loaded(tmp_path, as_yolo(tmp_path, every=NAMES["milliseconds"]), fps=25)
    assert "contradicted-fact" in [finding.code for finding in dataset.findings]


def test_missing_pictures_leave_gaps_in_the_frame_numbers(tmp_path):
    names = as_yolo(tmp_path, every=NAMES["milliseconds"])
    for frame in (7, 8, 20):
        (tmp_path / "truth" / NAMES["milliseconds"](frame)).unlink()
    dataset = loaded(tmp_path, names)
    assert dataset.frame_columns.frame.tolist() == sorted({*range(40)} - {7, 8, 20})
    assert "3 missing frames" in dataset.inputs["conversion"][0]


def test_large_numbers_that_are_no_times_of_a_camera_are_asked_about(tmp_path):
    rng = np.random.default_rng(1)
    numbers = np.sort(rng.integers(10**12, 10**12 + 10**7, 40))
    names = as_yolo(tmp_path, every=lambda i: f"{numbers[i]}.txt")
    with pytest.raises(InputError, match="not nearly even") as error:
        loaded(tmp_path, names)
    assert [step.remedy for step in error.value.steps] == [Remedy.FRAME_NAMES] * 2
    assert compared(tmp_path, names, frame_names="order")[0] == RIGHT


def test_times_in_a_column_of_frame_numbers_are_numbered(tmp_path):
    for side in ("truth", "x", "y"):
        table = truth() if side == "truth" else detections(side)
        table = table[table["name"] == "person"].assign(frame=table["frame"].map(at_ms))
        table.drop(columns="name").to_csv(tmp_path / f"{side}.csv", index=False)
    names = {side: f"{side}.csv" for side in ("truth", "x", "y")}
    numbers, dataset = compared(tmp_path, names, fps=None)
    assert numbers == RIGHT
    assert dataset.recordings["fps"].tolist() == [10]


@pytest.mark.parametrize("side", ["truth", "x"])
def test_a_number_too_large_for_a_frame_is_refused_with_file_and_line(tmp_path, side):
    """In the second of two files: either file alone could be guessed."""
    names = as_tables(tmp_path, dict.fromkeys(("truth", "x", "y"), int))
    wrong = [f"other,{frame},1,1,10,20,.5" for frame in (7777777777, 99999999999999999)]
    (tmp_path / "more.csv").write_text("\n".join(["recording,frame,x,y,w,h,score", *wrong]))
    with pytest.raises(InputError, match=r"more\.csv, line 2: .* too large .* found 7777777777"):
        loaded(tmp_path, names | {side: (names[side], "more.csv")})


def test_the_truth_s_last_frame_is_reported_with_file_and_line_where_it_is_too_large(tmp_path):
    names = as_tables(tmp_path, dict.fromkeys(("truth", "x", "y"), int))
    with (tmp_path / names["truth"]).open("a") as file:
        file.write("99999999999,1,1,1,10,20\n")
    n_lines = len((tmp_path / names["truth"]).read_text().splitlines())
    with pytest.raises(InputError, match=rf"truth\.csv, line {n_lines}: .* to 99999999999"):
        loaded(tmp_path, names)


@pytest.mark.parametrize(
    "of_frame",
    [
        lambda i: {"image_id": f"drive_{i:06d}"},
        lambda i: {"image_id": f"drive_{i:06d}.jpg"},
        lambda i: {"file_name": f"drive_{i:06d}.png"},
    ],
    ids=["stem", "file name", "file name alone"],
)
def test_results_find_their_picture_by_its_name(tmp_path, of_frame):
    document = coco_truth(lambda i: f"images/drive_{i:06d}.jpg")
    names = as_json(tmp_path, document, of_frame)
    assert compared(tmp_path, names)[0] == RIGHT


@pytest.mark.parametrize("first_id", [1, 5, 1000])
def test_an_image_id_that_is_the_number_in_a_name_is_told_from_an_id(tmp_path, first_id):
    document = coco_truth(lambda i: f"{i:06d}.jpg", first_id=first_id)
    by_name = as_json(tmp_path, document, lambda i: {"image_id": i})
    assert compared(tmp_path, by_name)[0] == RIGHT
    by_id = as_json(tmp_path, document, lambda i: {"image_id": i + first_id})
    assert compared(tmp_path, by_id)[0] == RIGHT


def test_where_both_ways_are_open_to_every_result_the_boxes_decide(tmp_path):
    names = [f"{(7 * i + 3) % 40:06d}.jpg" for i in range(40)]
    document = coco_truth(lambda i: names[i], first_id=0)
    by_id = as_json(tmp_path, document, lambda i: {"image_id": i})
    right = compared(tmp_path, by_id)[0]["matched"]
    by_name = as_json(tmp_path, document, lambda i: {"image_id": int(names[i][:6])})
    numbers, dataset = compared(tmp_path, by_name)
    assert numbers["matched"] == right == (60, 102)
    assert "as the boxes fit so" in dataset.inputs["conversion"][1]


def test_a_contradicted_image_id_is_said(tmp_path):
    document = coco_truth(lambda i: f"drive_{i:06d}.jpg", first_id=0)
    names = as_json(
        tmp_path, document, lambda i: {"image_id": i // 2, "file_name": f"drive_{i:06d}.jpg"}
    )
    numbers, dataset = compared(tmp_path, names)
    assert numbers == RIGHT
    assert "image-id-contradicted" in [finding.code for finding in dataset.findings]


def test_the_session_file_states_how_the_names_were_understood(tmp_path):
    dataset = loaded(tmp_path, as_yolo(tmp_path, every=NAMES["milliseconds"]))
    session = dataset.settings
    assert session.truth.frame_names == "times"
    text = write_session(session, version="0", fingerprint=dataset.fingerprint)
    (tmp_path / "session.toml").write_text(text)
    again = load(read_session(tmp_path / "session.toml"))
    assert again.fingerprint == dataset.fingerprint
    assert again.frame_columns.frame.tolist() == list(range(40))


def test_a_way_that_does_not_exist_is_refused():
    with pytest.raises(InputError, match="frame_names: expected numbers, times, order, scenes"):
        replace(Source("truth"), frame_names="dates")


def two_parts(first: Callable[[int], str], second: Callable[[int], str]) -> Callable[[int], str]:
    return lambda frame: first(frame) if frame < 20 else second(frame - 20)


LLVIP = two_parts(lambda i: f"01{i + 1:04d}.txt", lambda i: f"02{i + 1:04d}.txt")
TWO_VIDEOS = two_parts(
    lambda i: f"night_mp4-{i:04d}_jpg.rf.{HASH}.txt", lambda i: f"day_mp4-{i:04d}_jpg.rf.{HASH}.txt"
)
LONG_GAP = two_parts(lambda i: f"img_{i:06d}.txt", lambda i: f"img_{i + 5000:06d}.txt")


@pytest.mark.parametrize(
    ("name_of", "recordings"),
    [(LLVIP, ["01", "02"]), (TWO_VIDEOS, ["day", "night"])],
    ids=["LLVIP", "two videos"],
)
def test_scenes_of_one_list_are_recordings_of_their_own(tmp_path, name_of, recordings):
    numbers, dataset = compared(tmp_path, as_yolo(tmp_path, every=name_of))
    assert numbers["matched"] == RIGHT["matched"]
    assert sorted(dataset.recordings["name"]) == recordings
    # three pedestrians, each in both halves: none is linked across
    assert len(nv.compare(dataset).encounters) == 6


def test_scenes_in_a_coco_list_are_recordings_of_their_own(tmp_path):
    document = coco_truth(lambda i: LLVIP(i).replace(".txt", ".jpg"))
    numbers, dataset = compared(
        tmp_path, as_json(tmp_path, document, lambda i: {"image_id": i + 1})
    )
    assert numbers["matched"] == RIGHT["matched"]
    assert dataset.recordings["name"].tolist() == ["01", "02"]


def test_a_long_gap_in_a_list_of_pictures_is_asked_about(tmp_path):
    names = as_yolo(tmp_path, every=LONG_GAP)
    with pytest.raises(InputError, match="a gap of 4,981 numbers") as error:
        loaded(tmp_path, names)
    assert [step.value for step in error.value.steps] == ["scenes", "numbers"]
    numbers, dataset = compared(tmp_path, names, frame_names="scenes")
    assert numbers["matched"] == RIGHT["matched"]
    assert dataset.recordings["name"].tolist() == ["scene_1", "scene_2"]
    numbered = loaded(tmp_path, names, frame_names="numbers")
    assert numbered.frame_columns.frame.tolist() == [*range(20), *range(5000, 5020)]


def test_the_command_line_asks_with_exit_code_2_and_the_flag(tmp_path):
    names = as_yolo(tmp_path, every=LONG_GAP)
    paths = [part for side in names for part in (f"--{side}", str(tmp_path / side))]
    facts = ["--size", "640x480", "--fps", "10"]
    run = nvcore("check", *paths, *facts)
    assert run.exit_code == 2
    assert "Give --frame-names-truth scenes, or give --frame-names-truth numbers." in run.stderr
    assert nvcore("check", *paths, *facts, "--frame-names", "scenes").exit_code == 0


def test_a_list_of_every_thousandth_picture_has_no_gap(tmp_path):
    dataset = loaded(tmp_path, as_yolo(tmp_path, every=lambda i: f"{i * 1500:06d}.txt"))
    assert len(dataset.recordings) == 1


def as_tables(tmp_path: Path, time_of: dict[str, Callable[[int], float]]) -> dict[str, str]:
    for side, of_frame in time_of.items():
        table = truth() if side == "truth" else detections(side)
        table = table[table["name"] == "person"].assign(frame=table["frame"].map(of_frame))
        table.drop(columns="name").to_csv(tmp_path / f"{side}.csv", index=False)
    return {side: f"{side}.csv" for side in time_of}


def test_times_of_other_units_meet_in_the_nearest_frame(tmp_path):
    seconds, ns = (lambda i: at_ms(i) / 1000 + 0.02), (lambda i: at_ms(i) * 10**6)
    names = as_tables(tmp_path, {"truth": at_ms, "x": seconds, "y": ns})
    assert compared(tmp_path, names)[0] == RIGHT


def test_pictures_between_those_of_the_truth_are_left_out(tmp_path):
    names = as_yolo(tmp_path, every=NAMES["milliseconds"])
    for frame in range(39):
        (tmp_path / "x" / f"{at_ms(frame) + 30}.txt").write_text("0 0.5 0.5 0.1 0.1 0.9")
    numbers, dataset = compared(tmp_path, names)
    assert numbers == RIGHT
    assert len(dataset.left_out) == 39


def test_times_of_a_system_are_refused_where_the_truth_has_none(tmp_path):
    names = as_tables(tmp_path, {"truth": float, "x": at_ms, "y": at_ms})
    with pytest.raises(InputError, match="those of the truth are not") as error:
        loaded(tmp_path, names)
    assert error.value.steps[0].value == "times"
    assert compared(tmp_path, names, frame_names="times")[0] == RIGHT


def test_after_a_long_pause_another_recording_begins(tmp_path):
    names = as_yolo(tmp_path, every=lambda i: f"{at_ms(i) + (10**6 if i >= 20 else 0)}.txt")
    numbers, dataset = compared(tmp_path, names)
    assert numbers["matched"] == RIGHT["matched"]
    assert dataset.recordings["name"].tolist() == ["scene_1", "scene_2"]
    assert dataset.frame_columns.frame.tolist() == [*range(20)] * 2


def test_times_in_motchallenge_are_numbered(tmp_path):
    for side in ("truth", "x", "y"):
        table = truth() if side == "truth" else detections(side)
        table = table[table["name"] == "person"].assign(track=1, score=table.get("score", 1))
        rows = table.assign(frame=table["frame"].map(at_ms))[["frame", "track", *"xywh", "score"]]
        rows[["x", "y"]] += 1
        rows.assign(a=-1, b=-1, c=-1).to_csv(tmp_path / f"{side}.txt", index=False, header=False)
    names = {side: f"{side}.txt" for side in ("truth", "x", "y")}
    assert compared(tmp_path, names)[0]["matched"] == RIGHT["matched"]


def test_copies_of_a_picture_in_a_coco_list_are_refused(tmp_path):
    document = coco_truth(lambda i: f"img_{i:04d} (1).jpg" if i == 7 else f"img_{i:04d}.jpg")
    document["images"].append({"id": 99, "file_name": "img_0007.jpg", "width": 640, "height": 480})
    names = as_json(tmp_path, document, lambda i: {"image_id": i + 1})
    with pytest.raises(InputError, match=r"img_0007\.jpg is frame 7 .* as is img_0007 \(1\)\.jpg"):
        loaded(tmp_path, names)


def test_cvat_pictures_named_by_times_are_numbered(tmp_path):
    table = truth()
    table = table[table["name"] == "person"]
    images = "".join(
        f'<image id="{i}" name="{at_ms(i)}.jpg" width="640" height="480">'
        + "".join(
            f'<box label="person" occluded="0" xtl="{x}" ytl="{y}" xbr="{x + w}" ybr="{y + h}"/>'
            for x, y, w, h in table.loc[table["frame"] == i, [*"xywh"]].itertuples(index=False)
        )
        + "</image>"
        for i in range(40)
    )
    (tmp_path / "truth.xml").write_text(
        f"<annotations><version>1.1</version>{images}</annotations>"
    )
    names = as_yolo(tmp_path, every=NAMES["milliseconds"]) | {"truth": "truth.xml"}
    assert compared(tmp_path, names)[0] == RIGHT


def since_start_ms(frame: int) -> int:
    return round(frame * 1000 / 30)


def test_short_numbers_that_look_like_times_are_doubted_and_are_times_where_it_is_said(tmp_path):
    names = as_yolo(tmp_path, every=lambda i: f"{since_start_ms(i):06d}.txt")
    dataset = loaded(tmp_path, names, fps=30)
    (doubt,) = audit_frame_steps(dataset)
    assert doubt.severity is Severity.ERROR
    assert [(step.remedy, step.value) for step in doubt.steps] == [
        (Remedy.FRAME_NAMES, "times"),
        (Remedy.ACCEPT, doubt.code),
    ]
    (doubt,) = audit_frame_steps(loaded(tmp_path, names, fps=12))
    assert doubt.severity is Severity.WARNING
    numbers, dataset = compared(tmp_path, names, fps=None, frame_names="times")
    assert numbers == RIGHT
    assert dataset.recordings["fps"].tolist() == [30]
    assert not audit_frame_steps(dataset)


@pytest.mark.parametrize("step", [1, 20, 33])
def test_even_frame_numbers_are_not_doubted(tmp_path, step):
    names = as_yolo(tmp_path, every=lambda i: f"{i * step:06d}.txt")
    assert not audit_frame_steps(loaded(tmp_path, names))


def test_a_rerun_of_a_written_session_divides_scenes_in_the_same_way(tmp_path):
    dataset = loaded(tmp_path, as_yolo(tmp_path, every=LLVIP))
    text = write_session(dataset.settings, version="0", fingerprint=dataset.fingerprint)
    assert 'frame_names = "scenes"' in text
    (tmp_path / "session.toml").write_text(text)
    again = load(read_session(tmp_path / "session.toml"))
    assert again.fingerprint == dataset.fingerprint
    assert found(nv.compare(again)) == found(nv.compare(dataset))


def test_a_scene_whose_first_pictures_are_missing_is_still_one(tmp_path):
    late = two_parts(lambda i: f"01{i + 1:04d}.txt", lambda i: f"02{i + 37:04d}.txt")
    third = lambda i: late(i) if i < 39 else "030001.txt"  # noqa: E731
    dataset = loaded(tmp_path, as_yolo(tmp_path, every=third))
    assert dataset.recordings["name"].tolist() == ["01", "02", "03"]


def test_cameras_named_behind_the_number_are_recordings_of_their_own(tmp_path: Path):
    names = as_yolo(tmp_path, every=lambda f: f"{f // 2:04d}_{('left', 'right')[f % 2]}.txt")
    values, dataset = compared(tmp_path, names)
    assert (values["matched"], values["false_alarms"]) == (RIGHT["matched"], RIGHT["false_alarms"])
    assert dataset.recordings["name"].tolist() == ["left", "right"]
    assert set(dataset.frames["frame"]) == {*range(20)}


def clock(frame: int) -> str:
    return f"10-11-{13 + frame // 10}.{frame % 10}"


FRAME_FIRST = {
    "a date in all names": lambda i: f"frame_{i:06d}_20230612.txt",
    "a size in all names": lambda i: f"frame_{i:06d}_640.txt",
    "time of day": lambda i: f"{i:06d}_{clock(i)}.txt",
    "number, date and time": lambda i: f"{i:06d}_20230612_10111{3 + i // 10}.txt",
    "number and milliseconds": lambda i: f"{i:06d}_{at_ms(i)}.txt",
    "milliseconds since the start": lambda i: f"{i:06d}_{at_ms(i) % 10**7}.txt",
    "hash": lambda i: f"frame_{i:04d}_{i * 2654435761 % 2**32:08x}.txt",
    "another counter": lambda i: f"{i:06d}_{i + 300:06d}.txt",
    "number of objects": lambda i: f"{i:06d}_{i * 7 % 5}.txt",
    "time of day first": lambda i: f"{clock(i)}_{i:06d}.txt",
    "milliseconds first": lambda i: f"{at_ms(i)}_{i:06d}.txt",
}


def listed(names: list[str], **facts: object) -> set[tuple[str, int]]:
    table = named_pictures(names, ReadOptions(**facts)).table
    return {*zip(table["recording"], table["frame"].tolist(), strict=True)}


@pytest.mark.parametrize("name_of", (NAMES | FRAME_FIRST).values(), ids=NAMES | FRAME_FIRST)
def test_the_frame_is_the_number_that_counts_up_wherever_it_stands(name_of):
    names = [name_of(i) for i in range(40)]
    of_truth = named_pictures(names, ReadOptions())
    assert of_truth.table["frame"].tolist() == [*range(40)]
    assert of_truth.table["recording"].nunique() == 1
    assert listed(names, role="detections", named=of_truth) == listed(names)


CAMERAS = {
    "two, without a word": (lambda i, c: f"{i:06d}_{c}.jpg", 2, "{}"),
    "two": (lambda i, c: f"img{i}_cam{c}.jpg", 2, "img_cam{}"),
    "five": (lambda i, c: f"drive3_{i:06d}_cam{c}.jpg", 5, "drive3_cam{}"),
    "with times": (lambda i, c: f"{i:06d}_cam{c}_{at_ms(i)}.jpg", 2, "cam{}"),
    "before the frame": (lambda i, c: f"cam{c}_{i:06d}.jpg", 5, "cam{}"),
    "of many clips": (lambda i, c: f"clip_{i:04d}_{c:04d}.jpg", 10, None),
    "of clips of three": (lambda i, c: f"clip{i}_{c}.jpg", 3, None),
}


@pytest.mark.parametrize(("name_of", "n", "title"), CAMERAS.values(), ids=CAMERAS)
def test_a_number_of_few_values_is_a_camera_rather_than_the_frame(name_of, n, title):
    names = [name_of(i, c) for i in range(40) for c in range(n)]
    if title is None:  # the last number counts the frames of each clip
        assert {frame for _, frame in listed(names)} == {*range(n)}
        assert len({recording for recording, _ in listed(names)}) == 40
    else:
        assert listed(names) == {(title.format(c), i) for i in range(40) for c in range(n)}


def test_times_before_a_camera_are_still_times():
    names = [f"{1_598_000_000_000 + 100 * i}_Cam{c}.jpg" for i in range(40) for c in (1, 2)]
    assert listed(names) == {(f"Cam{c}", i) for i in range(40) for c in (1, 2)}


@pytest.mark.parametrize(
    "name_of",
    [
        lambda i: f"{i:06d}_{10 * i:06d}",
        lambda i: f"{i // 4:06d}_{i % 4}",
        lambda i: f"{i * i * 7919 % 10007}_{i * i * 3571 % 10009:06d}",
    ],
    ids=["two counters", "four cameras or frames", "two ids"],
)
def test_two_numbers_that_may_be_the_frame_are_asked_about(name_of):
    names = [f"{name_of(i)}.jpg" for i in range(80)]
    with pytest.raises(InputError, match=r"it may be 0+ or") as error:
        listed(names)
    assert [step.value for step in error.value.steps] == ["counter", "numbers", "order"]
    assert len(listed(names, frame_names="numbers")) == 80
    recording, frame = zip(*listed(names, frame_names="counter"), strict=True)
    assert (len({*recording}), len({*frame})) in ((1, 80), (4, 20))


def test_a_system_that_lists_few_frames_is_read_as_the_truth_is(tmp_path):
    names = as_yolo(tmp_path, every=lambda i: f"{i // 2:06d}_cam{i % 2}.txt")
    for path in sorted((tmp_path / "x").iterdir())[3:]:
        path.unlink()
    dataset = loaded(tmp_path, names)
    assert dataset.recordings["name"].tolist() == ["cam0", "cam1"]
    assert not len(dataset.left_out)


def test_many_recordings_of_single_frames_are_an_error_that_can_be_accepted(tmp_path):
    names = as_yolo(tmp_path, every=lambda i: f"a{i * 2654435761 % 2**32:08x}g{i}.txt")
    dataset = loaded(tmp_path, names, frame_names="numbers")
    (error,) = [finding for finding in nv.audit(dataset) if finding.code == "single-frames"]
    assert (error.severity, error.count) == (Severity.ERROR, 40)
    assert Step(Remedy.ACCEPT, "single-frames") in error.steps
    meant = dataset.with_settings(replace(dataset.settings, accept=("single-frames",)))
    assert Severity.ERROR not in [finding.severity for finding in nv.audit(meant)]
