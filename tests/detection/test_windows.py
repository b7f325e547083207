"""Windows of a sliding-window detector: published counts, plain loops, limits."""

from __future__ import annotations

import math
from itertools import product

import numpy as np
import pytest
from builders import Place, make_dataset

from nvcore.common.errors import ParameterError
from nvcore.metrics.detection.windows import WindowGrid, scale_steps, windows_per_image

SIGNS = WindowGrid(64, 64, 6, scale_steps(1.0, 1.7, 0.1))
HEADS = WindowGrid(30, 30, 1, scale_steps(1.0, 2.4, 0.2))


@pytest.mark.parametrize(
    ("grid", "size", "published"), [(SIGNS, (1360, 800), 122_648), (HEADS, (640, 480), 921_548)]
)
def test_the_formula_gives_the_published_counts(grid, size, published):
    area = WindowGrid(grid.width, grid.height, grid.stride, grid.scales, count="area")
    assert round(float(area.per_image(*size))) == published


@pytest.mark.parametrize(("grid", "size"), [(SIGNS, (1360, 800)), (HEADS, (64, 48))])
def test_whole_windows_are_those_that_one_can_lay_down(grid, size):
    n = 0
    for scale in grid.scales:
        across, down = (int(side / scale + 1e-9) for side in size)
        places = product(
            range(0, across - int(grid.width) + 1, int(grid.stride)),
            range(0, down - int(grid.height) + 1, int(grid.stride)),
        )
        n += sum(1 for _ in places)
    assert n > 0
    assert grid.per_image(*size) == n


@pytest.mark.parametrize(
    ("size", "n"), [((64, 128), 1), ((63.9, 128), 0), ((71, 128), 1), ((72, 136), 4)]
)
def test_a_window_as_large_as_the_image_fits_once_and_a_larger_one_never(size, n):
    assert WindowGrid(64, 128, 8).per_image(*size) == n


@pytest.mark.parametrize("count", ["whole", "area"])
def test_images_too_small_in_both_directions_have_no_window(count):
    # two negative factors would give a positive count
    assert WindowGrid(64, 64, 1, count=count).per_image(10, 10) == 0


def test_scales_with_rounding_errors_lose_no_window():
    sloppy = tuple(np.arange(1.0, 1.75, 0.1))  # 1.7000000000000006
    assert WindowGrid(64, 64, 6, sloppy).per_image(1360, 800) == 123_673


def test_scale_steps_include_both_ends():
    assert scale_steps(1.0, 2.4, 0.2) == (1.0, 1.2, 1.4, 1.6, 1.8, 2.0, 2.2, 2.4)
    assert scale_steps(1, 1, 0.5) == (1.0,)
    inf = math.inf
    for wrong in ((0, 1, 0.1), (2, 1, 0.1), (1, 2, 0), (1, math.nan, 1), (1, inf, 1), (1, 2, inf)):
        with pytest.raises(ParameterError, match="the first scale must be above 0, the last"):
            scale_steps(*wrong)


def test_the_mean_over_images_of_several_sizes():
    places = [Place(range(3), 64, 128), Place(range(1), 72, 136)]
    dataset = make_dataset(places=places)
    grid = WindowGrid(64, 128, 8)
    assert windows_per_image(dataset, np.ones(4, dtype=bool), grid) == (3 * 1 + 1 * 4) / 4
    assert math.isnan(windows_per_image(dataset, np.zeros(4, dtype=bool), grid))


@pytest.mark.parametrize(
    "wrong",
    [{"width": 0}, {"height": math.nan}, {"stride": -1}, {"scales": ()}, {"scales": (1, 0)}],
)
def test_grids_that_mean_nothing_are_refused(wrong):
    with pytest.raises(ParameterError, match="windows: expected positive"):
        WindowGrid(**{"width": 64, "height": 128, **wrong})


def test_an_unknown_way_of_counting_is_refused():
    with pytest.raises(ParameterError, match="expected whole or area"):
        WindowGrid(64, 64, count="about")  # type: ignore[arg-type]
