"""Crops of objects and pictures of background as folders."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest

import nvcore as nv
from nvcore.common.errors import InputError, ParameterError
from nvcore.subjects.detectors.calls.arguments import TrainArguments
from nvcore.subjects.detectors.icf import SIGNS
from nvcore.subjects.detectors.registry import open_detector
from nvcore.subjects.detectors.training.folders import folder_shots
from nvcore.subjects.detectors.training.shots import TrainingData


def shots_of(crops: Path | None, background: Path | None = None, **options: Any) -> TrainingData:
    arguments = TrainArguments(None, "m.npz", crops=crops, background=background, **options)
    return folder_shots(SIGNS, arguments)


def disc(path: Path, size: int, shift: int = 0) -> None:
    picture = np.full((size, size, 3), 90, np.uint8)
    middle = size // 2
    cv2.circle(picture, (middle + shift, middle), size // 3, (240, 240, 240), -1)
    cv2.circle(picture, (middle + shift, middle), size // 3, (20, 20, 200), 3)
    path.parent.mkdir(parents=True, exist_ok=True)
    cv2.imwrite(str(path), picture)


@pytest.fixture
def crops(tmp_path: Path) -> Path:
    folder = tmp_path / "crops"
    for sign in range(4):
        for i in range(3):
            disc(folder / f"30/{sign:05}_{i:05}.png", 40 + sign)
    return folder


@pytest.fixture
def background(tmp_path: Path) -> Path:
    folder = tmp_path / "roads"
    folder.mkdir()
    for i in range(3):
        picture = np.random.default_rng(i).integers(0, 255, (120, 160, 3), np.uint8)
        cv2.imwrite(str(folder / f"{i}.png"), cv2.GaussianBlur(picture, (5, 5), 0))
    return folder


def test_an_object_fills_the_stated_share_of_its_crop(crops: Path):
    shots = shots_of(crops, crop_share=0.5).shots
    (box,) = (*shots[0].learned, *shots[0].held_out)
    assert box.tolist() == [10, 10, 20, 20]
    as_in_window = shots_of(crops).shots[0]
    (box,) = (*as_in_window.learned, *as_in_window.held_out)
    assert box[3] == 40 * 27 / 32
    assert not any(shot.has_background for shot in shots)


def test_a_track_of_crops_is_on_one_side(crops: Path):
    given = shots_of(crops, share=0.25)
    assert given.held_out == "1 of 4 physical objects in crops"
    out = [len(shot.held_out) for shot in given.shots]
    assert sum(out) == 3
    assert {sum(out[i : i + 3]) for i in range(0, 12, 3)} == {0, 3}


def test_crops_that_are_all_named_as_of_one_object_are_refused_before_they_are_read(tmp_path: Path):
    folder = tmp_path / "crops"
    folder.mkdir()
    for i in range(3):
        (folder / f"IMG_{i:04}.jpg").write_bytes(b"")
    with pytest.raises(InputError, match="all 3 pictures are named as of one physical object"):
        shots_of(folder)
    (folder / "other.jpg").write_bytes(b"")
    assert shots_of(folder).held_out == "1 of 2 physical objects in crops"


def test_boxes_are_those_of_the_table(crops: Path):
    (crops / "boxes.csv").write_text(
        "file,x,y,w,h\n30/00000_00000.png,1,2,10,11\n30/00000_00000.png,20,2,10,11\n"
    )
    shots = shots_of(crops).shots
    boxes = [np.concatenate([shot.learned, shot.held_out]).tolist() for shot in shots]
    assert boxes[0] == [[1, 2, 10, 11], [20, 2, 10, 11]]
    assert not any(boxes[1:])


def test_the_fingerprint_is_of_contents_and_boxes(crops: Path, background: Path):
    first = shots_of(crops, background)
    assert len(first.trained_on) == 2
    moved = crops.rename(crops.with_name("elsewhere"))
    assert shots_of(moved, background).trained_on == first.trained_on
    assert shots_of(moved, crop_share=0.5).trained_on[0] != first.trained_on[0]
    disc(moved / "30/00000_00000.png", 44)
    assert shots_of(moved).trained_on[0] != first.trained_on[0]


@pytest.mark.parametrize(
    ("table", "words"),
    [
        ("name,x,y,w,h\n", r"boxes.csv, line 1: expected the columns file, x, y, w, h"),
        ("file,x,y,w,h\n30/00000_00000.png,1,2,0,5\n", "line 2: expected a file name"),
        ("file,x,y,w,h\n30/00000_00000.png,1,2,nan,5\n", "line 2: expected a file name"),
        ("file,x,y,w,h\n30/00000_00000.png,1,2\n", "line 2: expected a file name"),
        ("file,x,y,w,h\n../../secret.png,1,2,3,4\n", r"line 2: there is no picture '../../sec"),
        ("\xff\xfe", "is not UTF-8 text"),
    ],
)
def test_a_wrong_table_is_refused(table: str, words: str, crops: Path):
    (crops / "boxes.csv").write_bytes(table.encode("latin-1"))
    with pytest.raises(InputError, match=words):
        shots_of(crops)


def test_folders_without_pictures_are_refused(tmp_path: Path):
    with pytest.raises(InputError, match="there is no such folder"):
        shots_of(tmp_path / "gone")
    (tmp_path / "notes.txt").write_text("")
    with pytest.raises(InputError, match="there are no pictures in it"):
        shots_of(None, tmp_path)
    for share in (0, 1.5, float("nan")):
        with pytest.raises(ParameterError, match="crop_share"):
            shots_of(tmp_path, crop_share=share)


def test_crops_and_background_give_a_model(crops: Path, background: Path, tmp_path: Path):
    (crops / "30/damaged.png").write_bytes(b"\x89PNG\r\n\x1a\n")
    settings = {"features": 200, "trees_per_round": (8,), "negatives": 300, "copies": 1}
    training = nv.train(
        None, tmp_path / "signs.npz", preset="signs", settings=settings,
        crops=crops, background=background, share=0.3,
    )  # fmt: skip
    assert (training.n_objects, training.n_held_out, training.n_kept) == (9, 3, 3)
    assert training.faults == ("damaged.png: the picture is damaged or cut off; copy it again",)
    model = training.model
    assert (model.label, model.is_colour, model.n_objects) == ("speed sign", True, 18)
    assert [part.recording for part in model.trained_on] == ["", ""]


def test_the_classes_of_a_table_are_those_of_the_model(
    crops: Path, background: Path, tmp_path: Path
):
    names = sorted(path.relative_to(crops).as_posix() for path in crops.rglob("*.png"))
    rows = [f"{name},5,5,30,30,{30 + 20 * (i % 2)}" for i, name in enumerate(names)]
    plain = shots_of(crops).trained_on
    table = crops / "boxes.csv"
    table.write_text("\n".join(["file,x,y,w,h,class", *rows]))
    given = shots_of(crops)
    assert given.trained_on != plain
    assert [shot.labels for shot in given.shots if len(shot.learned)][:2] == [("30",), ("50",)]
    settings = {"features": 200, "trees_per_round": (8,), "negatives": 300, "copies": 1}
    options = {"preset": "signs", "settings": settings, "background": background}
    training = nv.train(None, tmp_path / "signs.npz", crops=crops, **options)
    assert training.model.labels == ("30", "50")
    assert open_detector(tmp_path / "signs.npz").about.labels == ("30", "50")
    table.write_text("\n".join(["file,x,y,w,h,class", *(f"{row}\x1b" for row in rows)]))
    with pytest.raises(ParameterError, match="class: expected at most 200 printable"):
        nv.train(None, tmp_path / "signs.npz", crops=crops, seed=3, **options)


def test_there_has_to_be_something_to_learn(tmp_path: Path, crops: Path, background: Path):
    out = tmp_path / "signs.npz"
    with pytest.raises(InputError, match="there is nothing to learn from"):
        nv.train(None, out)
    with pytest.raises(InputError, match="there is no background"):
        nv.train(None, out, crops=crops, preset="signs")
    with pytest.raises(InputError, match="there is no object"):
        nv.train(None, out, background=background, preset="signs")
    with pytest.raises(InputError, match="is an input, and would be replaced"):
        nv.train(None, crops / "30/00000_00000.png", crops=crops)
    assert not out.exists()
