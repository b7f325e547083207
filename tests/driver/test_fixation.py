"""Where the driver looks: a gaze file, or a point that is assumed."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from nvcore.common.errors import FormatError, InputError, ParameterError
from nvcore.subjects.driver.inputs.fixation import FixedPoint, read_gaze


def gaze_file(folder: Path, *lines: str) -> Path:
    path = folder / "gaze.csv"
    path.write_text("\n".join(lines) + "\n")
    return path


def test_fixations_are_found_by_frame_in_any_order(tmp_path: Path):
    gaze = read_gaze(gaze_file(tmp_path, "y,frame,x", "540,7,960.5", "-3,5,10"))
    np.testing.assert_array_equal(
        gaze.at(np.array([5, 6, 7, 8])),
        [[10, -3], [np.nan, np.nan], [960.5, 540], [np.nan, np.nan]],
    )


@pytest.mark.parametrize("rows", [["0,0.5,0.5", "1,0.31,1"], ["4,0,0"]])
def test_shares_of_the_picture_are_refused(tmp_path: Path, rows: list[str]):
    with pytest.raises(InputError, match=r"gaze\.csv: x, y: all points lie in 0 to 1.* pixels"):
        read_gaze(gaze_file(tmp_path, "frame,x,y", *rows))


def test_a_point_in_the_corner_is_one_of_pixels_where_others_are(tmp_path: Path):
    assert len(read_gaze(gaze_file(tmp_path, "frame,x,y", "0,0.5,0.5", "1,300,200")).frame) == 2


def test_a_file_without_rows_knows_no_fixation(tmp_path: Path):
    assert np.isnan(read_gaze(gaze_file(tmp_path, "frame,x,y")).at(np.array([0, 1]))).all()


@pytest.mark.parametrize(
    ("line", "words"),
    [
        ("5,2,3", "line 4: the frame 5 has a row already"),
        ("8,,3", "line 4: x: expected a number, found ''"),
        ("8,2,nan", "line 4: y: expected a number, found 'nan'"),
        ("8,2,1e308", r"line 4: y: expected -1e\+06 to 1e\+06, found 1e308"),
        ("8.5,2,3", "line 4: frame: expected a whole number, found 8.5"),
        ("8,2", "line 4: expected 3 fields"),
    ],
)
def test_a_wrong_row_is_refused_with_file_and_line(tmp_path: Path, line: str, words: str):
    path = gaze_file(tmp_path, "frame,x,y", "7,1,1", "5,1,1", line)
    with pytest.raises(FormatError, match=rf"gaze\.csv, {words}"):
        read_gaze(path)


def test_a_missing_column_or_file_is_refused(tmp_path: Path):
    with pytest.raises(FormatError, match="y is missing, found frame, x"):
        read_gaze(gaze_file(tmp_path, "frame,x", "1,2"))
    with pytest.raises(InputError, match="cannot be opened"):
        read_gaze(tmp_path / "none.csv")


def test_the_fixed_point_is_the_middle_unless_told_otherwise():
    assert FixedPoint().in_picture(1920, 1080) == (960, 540)
    assert FixedPoint(0.25, 0.6).in_picture(1000, 500) == (250, 300)


@pytest.mark.parametrize("x", [-0.1, 1.1, float("nan")])
def test_a_fixed_point_outside_the_picture_is_refused(x: float):
    with pytest.raises(ParameterError, match="fixation: expected x as a share"):
        FixedPoint(x)
