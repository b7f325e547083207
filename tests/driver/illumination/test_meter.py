"""Readings of a light meter, and pictures that stand in for one."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from nvcore.common.errors import FormatError
from nvcore.subjects.driver.illumination import LightSource, picture_level, read_light


def light_file(folder: Path, *lines: str) -> Path:
    path = folder / "lux.csv"
    path.write_text("\n".join(lines) + "\n")
    return path


def test_the_last_reading_holds_until_the_next(tmp_path: Path):
    light = read_light(light_file(tmp_path, "lux,time_s", "1000,-1", "10,2.5"))
    assert light.source is LightSource.METER
    levels = light.at(np.array([-2.0, -1.0, 2.4, 2.5]))
    np.testing.assert_array_equal(levels, [np.nan, 1000, 1000, 10])


def test_the_last_reading_holds_as_long_as_others_or_a_second(tmp_path: Path):
    light = read_light(light_file(tmp_path, "time_s,lux", "0,5", "3,5", "6,7"))
    np.testing.assert_array_equal(light.at(np.array([9.0, 9.1])), [7, np.nan])
    quick = read_light(light_file(tmp_path, "time_s,lux", "0,5", "0.1,7"))
    np.testing.assert_array_equal(quick.at(np.array([1.1, 1.2])), [7, np.nan])


def test_without_readings_nothing_is_known(tmp_path: Path):
    light = read_light(light_file(tmp_path, "time_s,lux"))
    assert np.isnan(light.at(np.array([0.0, 1.0]))).all()


@pytest.mark.parametrize(
    ("line", "words"),
    [
        ("1.0,5", "line 3: time_s: expected a time after 1 of the row before, found 1"),
        (
            "1e300,5",
            r"line 3: time_s: expected seconds from frame 0 of the recording, -1e\+08 to 1e\+08, "
            r"found 1e\+300; subtract the time of frame 0",
        ),
        ("-1e12,5", "line 3: time_s: expected seconds from frame 0"),
        ("2.0,-5", "line 3: lux: expected 0 or more, found -5"),
        ("2.0,bright", "line 3: lux: expected a number, found 'bright'"),
    ],
)
def test_a_wrong_row_is_refused_with_file_and_line(tmp_path: Path, line: str, words: str):
    with pytest.raises(FormatError, match=rf"lux\.csv, {words}"):
        read_light(light_file(tmp_path, "time_s,lux", "1.0,5", line))


def test_the_level_of_a_picture_is_its_mean_intensity():
    assert picture_level(np.full((40, 60), 255, np.uint8)) == 1.0
    assert picture_level(np.zeros((40, 60), np.uint8)) == 0.0
    half = np.zeros((40, 60), np.uint8)
    half[:20] = 255
    assert picture_level(half) == pytest.approx(0.5)
    # 8-bit values are not linear: 188 is half of the light
    assert picture_level(np.full((8, 8), 188, np.uint8)) == pytest.approx(0.5, abs=0.003)
