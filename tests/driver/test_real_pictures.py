"""The features of real pedestrians: a red and a grey jacket, seen by eye and in far infrared."""

from __future__ import annotations

from pathlib import Path

import pytest

from scripts.driver_features import cell, twins

pytestmark = pytest.mark.realdata


def test_a_red_jacket_stands_out_by_colour_and_far_infrared_has_none(realdata: Path):
    visible, infrared = twins(realdata)
    grey, red = visible["lab_distance"]
    assert red > 3 * grey
    assert visible["colour_emd"][1] > 2 * visible["colour_emd"][0]
    assert infrared[["lab_distance", "colour_emd"]].isna().all(axis=None)
    assert infrared["luminance_contrast"].notna().all()


def test_a_cell_shows_the_median_and_eight_of_ten(realdata: Path):
    visible, _ = twins(realdata)
    assert cell(visible["height_px"], "height_px") == "186.5 (184.5 to 188.5)"
