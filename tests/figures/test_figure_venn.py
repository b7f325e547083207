"""The Venn diagram of encounters."""

from __future__ import annotations

from collections import Counter
from math import pi

import numpy as np
import pytest
from figure_parts import shape, trace, words

from nvcore.figures.venn import overlap_area, place_circles, venn_figure
from nvcore.metrics.venn import Venn

NAMES = ("FIR", "NIR")


def area(figure: object, letter: str) -> float:
    circle = shape(figure, f"circle {letter}")
    assert circle.x1 - circle.x0 == pytest.approx(circle.y1 - circle.y0)
    return pi * ((circle.x1 - circle.x0) / 2) ** 2


def label(figure: object, name: str) -> str:
    found = [one.text for one in figure.layout.annotations if one.name == name]
    return found[0] if found else ""


def test_the_paper_s_figure_1_has_circles_of_7_and_7_with_5_shared() -> None:
    figure = venn_figure(Venn(5, 2, 2, 1, 0), NAMES, theme="light")
    x, y = shape(figure, "circle x"), shape(figure, "circle y")
    assert (area(figure, "x"), area(figure, "y")) == pytest.approx((7, 7), abs=1e-6)
    apart = (y.x0 + y.x1) / 2 - (x.x0 + x.x1) / 2
    assert overlap_area((x.x1 - x.x0) / 2, (y.x1 - y.x0) / 2, apart) == pytest.approx(5, abs=1e-6)


@pytest.mark.parametrize(
    ("both", "x_only", "y_only"), [(22, 8, 5), (1, 200, 300), (997, 1, 2), (1, 1, 1000), (40, 2, 1)]
)
def test_the_three_areas_are_the_counts(both: int, x_only: int, y_only: int) -> None:
    circles = place_circles(Venn(both, x_only, y_only, 0, 0))
    shared = overlap_area(circles.radius_x, circles.radius_y, circles.apart)
    assert shared == pytest.approx(both, abs=1e-6)
    assert pi * circles.radius_x**2 - shared == pytest.approx(x_only, abs=1e-6)
    assert pi * circles.radius_y**2 - shared == pytest.approx(y_only, abs=1e-6)


def test_the_overlap_of_two_circles_is_what_counting_points_gives() -> None:
    rng = np.random.default_rng(1)
    x, y = rng.uniform(-1, 1, 200_000), rng.uniform(-1, 1, 200_000)
    inside = (x**2 + y**2 <= 1) & ((x - 0.8) ** 2 + y**2 <= 0.25)
    assert overlap_area(1.0, 0.5, 0.8) == pytest.approx(4 * inside.mean(), abs=0.02)


def test_circles_apart_one_inside_the_other_and_one_on_the_other() -> None:
    circles = place_circles(Venn(0, 20, 5, 1, 0))
    assert circles.apart > circles.radius_x + circles.radius_y
    circles = place_circles(Venn(5, 4, 0, 0, 0))
    assert circles.apart + circles.radius_y == pytest.approx(circles.radius_x)
    circles = place_circles(Venn(5, 0, 0, 0, 0))
    assert (circles.apart, circles.radius_x) == (0, circles.radius_y)


def test_a_system_that_detects_nobody_has_no_circle() -> None:
    figure = venn_figure(Venn(0, 0, 7, 2, 0), NAMES, theme="dark")
    assert [one.name for one in figure.layout.shapes] == ["all encounters", "circle y"]
    assert "X: FIR</b> 0 of 9" in words(figure)


def test_counts_stand_in_their_regions() -> None:
    figure = venn_figure(Venn(50, 20, 21, 4, 6), NAMES, theme="light")
    assert "50" in label(figure, "both")
    assert "20" in label(figure, "x_only")
    assert "21" in label(figure, "y_only")
    assert "4</b> neither" in label(figure, "neither")
    assert "6 distant, not counted" in label(figure, "distant")
    assert "95 encounters" in words(figure)


def test_a_click_in_a_region_gives_its_category() -> None:
    venn = Venn(22, 8, 5, 3, 8)
    circles = place_circles(venn)
    places = trace(venn_figure(venn, NAMES, theme="light"), "regions")
    for x, y, category in zip(places.x, places.y, places.customdata, strict=True):
        in_x = x**2 + y**2 <= circles.radius_x**2
        in_y = (x - circles.apart) ** 2 + y**2 <= circles.radius_y**2
        if category != "distant":
            assert category == {
                (True, True): "both", (True, False): "x_only", (False, True): "y_only",
                (False, False): "neither",
            }[bool(in_x), bool(in_y)]  # fmt: skip
    assert set(Counter(places.customdata)) == {"both", "x_only", "y_only", "neither", "distant"}
    narrow = trace(venn_figure(Venn(1, 900, 900, 0, 0), NAMES, theme="light"), "regions")
    assert "both" in narrow.customdata


def test_names_in_the_diagram_are_text() -> None:
    figure = venn_figure(Venn(5, 2, 2, 1, 0), ("<i>x</i>", "y"), theme="light")
    assert "&lt;i&gt;x" in words(figure)


def test_without_encounters_that_count_the_diagram_says_so() -> None:
    shown = words(venn_figure(Venn(0, 0, 0, 0, 3), NAMES, theme="light"))
    assert "No pedestrian came near enough to count. 3 encounters stayed distant." in shown
    assert "distant" not in words(venn_figure(Venn(0, 0, 0, 0, 0), NAMES, theme="light"))
