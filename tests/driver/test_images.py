"""Features of the pedestrians of single pictures."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from picture_files import write_picture

from nvcore.common.errors import FormatError, InputError
from nvcore.subjects.driver.features import FEATURE_KEYS, features_of
from nvcore.subjects.driver.features.feature_record import about_features, record_beside
from nvcore.subjects.driver.features.images import IMAGE_FEATURE_COLUMNS, image_features

HEAD = "image,pedestrian,x,y,w,h"
OF_FIXATION = f"{HEAD},fixation_x,fixation_y"


def scene(seed: int) -> np.ndarray:
    return np.random.default_rng(seed).integers(0, 256, (60, 80, 3), dtype=np.uint8)


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    for name, seed in (("park.png", 1), ("night/road.png", 2)):
        write_picture(tmp_path / "study" / name, np.ascontiguousarray(scene(seed)[..., ::-1]))
    return tmp_path / "study"


def boxes(folder: Path, *rows: str, head: str = HEAD) -> Path:
    path = folder.parent / "boxes.csv"
    path.write_text("\n".join([head, *rows]) + "\n")
    return path


def test_rows_are_those_of_the_boxes_in_their_order(folder: Path):
    listed = boxes(folder, "park.png,1,10,10,8,20", "night/road.png,1,5,5,10,20",
                   "park.png,b,50,20,10,30")  # fmt: skip
    result = image_features(folder, listed)
    table = result.table
    assert tuple(table.columns) == IMAGE_FEATURE_COLUMNS
    assert table["image"].tolist() == ["park.png", "night/road.png", "park.png"]
    assert table["pedestrian"].tolist() == ["1", "1", "b"]
    expected = features_of(scene(1), np.array([[10, 10, 8, 20], [50, 20, 10, 30.0]]), (40.0, 30.0))
    np.testing.assert_array_equal(table[list(FEATURE_KEYS)].to_numpy()[[0, 2]], expected)
    assert str(result) == (
        "3 pedestrians in 2 pictures\nFixation assumed: the middle of the picture."
    )


def test_the_size_of_the_pictures_stands_in_the_record(folder: Path):
    listed = boxes(folder, "park.png,1,10,10,8,20")
    run = image_features(folder, listed)
    out = folder / "features.csv"
    out.write_bytes(b"as written")
    record_beside(out).write_bytes(run.record({out.name: out.read_bytes()}))
    assert run.picture_px == about_features(out)[1] == (80, 60)
    assert "sizes" not in str(run)


def test_pictures_of_several_sizes_are_said_to_be(folder: Path):
    write_picture(folder / "wide.png", np.zeros((60, 160, 3), np.uint8))
    run = image_features(folder, boxes(folder, "park.png,1,1,1,8,9", "wide.png,1,1,1,8,9"))
    assert run.picture_px is None
    assert "The pictures have 2 sizes, from 80 x 60 to 160 x 60 px" in str(run)


def test_the_fixation_may_be_given_for_each(folder: Path):
    rows = "park.png,1,10,10,8,20,14,23", "park.png,2,10,10,8,20,,"
    listed = boxes(folder, *rows, head=OF_FIXATION)
    result = image_features(folder, listed)
    assert result.table["fixation_distance_px"].tolist() == [3.0, np.hypot(26, 10)]
    assert "Fixation of 1 assumed" in str(result)


@pytest.mark.parametrize(
    ("row", "words", "head"),
    [
        ("none.png,1,10,10,8,20", "image: there is no 'none.png' in study", HEAD),
        ("../boxes.csv,1,10,10,8,20", "image: '../boxes.csv' lies outside the folder", HEAD),
        ("park.png,1,10,10,0,20", "w: expected more than 0, found 0", HEAD),
        ("park.png,1,10,60,8,20", "the box lies outside the picture of 80 x 60 px", HEAD),
        ("park.png,1,80,10,8,20", "the box lies outside the picture of 80 x 60 px", HEAD),
        ("park.png,1,-8,10,8,20", "the box lies outside the picture of 80 x 60 px", HEAD),
        ("park.png,1,10,10,8,tall", "h: expected a number, found 'tall'", HEAD),
        (",1,10,10,8,20", "image is empty", HEAD),
        ("park.png,2,10,10,8,20", r"the picture park\.png has the pedestrian 2 a second", HEAD),
        (f"{'a' * 300},1,10,10,8,20", "image: there is no 'a{20}", HEAD),
        (
            f"{'a' * 1001},1,10,10,8,20",
            "image: expected 1,000 characters at the most, found 1,001: 'a{20}",
            HEAD,
        ),
        (f"park.png,{'p' * 1001},10,10,8,20", "pedestrian: expected 1,000 characters", HEAD),
        ("park.png,1,10,10,8,20,4,", "expected both fixation_x and fixation_y", OF_FIXATION),
        (
            "park.png,1,10,10,8,20,5,1e308",
            r"fixation_y: expected -1e\+06 to 1e\+06, found 1e308",
            OF_FIXATION,
        ),
    ],
)
def test_a_wrong_row_is_refused_with_file_and_line(folder: Path, row: str, words: str, head: str):
    first = f"park.png,2,10,10,8,20{',1,1' if head == OF_FIXATION else ''}"
    with pytest.raises(FormatError, match=rf"boxes\.csv, line 3: {words}"):
        image_features(folder, boxes(folder, first, row, head=head))


@pytest.mark.parametrize(
    ("head", "words"),
    [
        ("fixation_x,note", "found fixation_x; give both, or neither"),
        ("note,fixation_y", "found fixation_y; give both, or neither"),
        (
            "fixation_x,fixaton_y",
            r"found fixation_x and fixaton_y; did you mean 'fixation_y'\? Give both, or neither",
        ),
        (
            "fixaton_x,fixaton_y",
            r"found fixaton_x and fixaton_y; did you mean 'fixation_x'\? Give both, or neither",
        ),
    ],
)
def test_a_lone_or_misspelt_column_of_the_fixation_is_refused(folder: Path, head: str, words: str):
    listed = boxes(folder, "park.png,1,10,10,8,20,5,5", head=f"{HEAD},{head}")
    expected = r"boxes\.csv, line 1: expected both fixation_x and fixation_y, "
    with pytest.raises(FormatError, match=expected + words):
        image_features(folder, listed)


def test_columns_of_other_names_are_not_taken_for_the_fixation(folder: Path):
    listed = boxes(folder, "park.png,1,10,10,8,20,5,5", head=f"{HEAD},note,fix_s")
    assert image_features(folder, listed).n_assumed == 1


def test_a_damaged_picture_is_refused_by_its_name(folder: Path):
    (folder / "bad.png").write_bytes(b"\x89PNG damaged")
    with pytest.raises(InputError, match=r"bad\.png"):
        image_features(folder, boxes(folder, "bad.png,1,10,10,8,20"))
