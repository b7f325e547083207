"""The Venn diagram of encounters."""

from __future__ import annotations

import re
from math import pi

import numpy as np
import pandas as pd
import pytest
from builders import at, make_dataset, result_of
from drives import at_thresholds
from figure_parts import shape, trace, words

from nvcore.dataset.schema import CATEGORY_WORDS
from nvcore.figures.style import LOOK
from nvcore.figures.venn import MIN_SIZE, MOST_MARKS, REGIONS, circles_of, overlap_area, venn_figure
from nvcore.metrics.venn import Venn
from nvcore.settings.objects import PEDESTRIAN
from nvcore.tables import weighed_encounters

NAMES = ("FIR", "NIR")


def drawn(venn: Venn, encounters: pd.DataFrame | None = None, names: tuple[str, str] = NAMES):
    return venn_figure(venn, names, theme="light", encounters=encounters, objects=PEDESTRIAN)


def area(figure: object, letter: str) -> float:
    circle = shape(figure, f"circle {letter}")
    assert circle.x1 - circle.x0 == pytest.approx(circle.y1 - circle.y0)
    return pi * ((circle.x1 - circle.x0) / 2) ** 2


def label(figure: object, name: str) -> str:
    """The text of that name, without markup."""
    texts = [part.text for part in figure.layout.annotations if part.name == name]
    return re.sub("<br>|<[^>]*>", lambda tag: " " * (tag[0] == "<br>"), texts[0]) if texts else ""


def test_the_paper_s_figure_1_has_circles_of_7_and_7_with_5_shared() -> None:
    figure = drawn(Venn(5, 2, 2, 1, 0), names=("<i>x</i>", "y"))
    x, y = shape(figure, "circle x"), shape(figure, "circle y")
    assert (area(figure, "x"), area(figure, "y")) == pytest.approx((7, 7), abs=1e-6)
    apart = (y.x0 + y.x1) / 2 - (x.x0 + x.x1) / 2
    assert overlap_area((x.x1 - x.x0) / 2, (y.x1 - y.x0) / 2, apart) == pytest.approx(5, abs=1e-6)
    assert "&lt;i&gt;x" in words(figure)  # names are text
    # where ranges give way in a narrow window, Plotly keeps them so, and labels lie on marks
    assert figure.layout.xaxis.constrain == figure.layout.yaxis.constrain == "domain"
    assert figure.layout.yaxis.scaleanchor == "x"


@pytest.mark.parametrize(("both", "x_only", "y_only"), [(22, 8, 5), (1, 200, 300), (997, 1, 2)])
def test_the_three_areas_are_the_counts(both: int, x_only: int, y_only: int) -> None:
    circles = circles_of(both, x_only, y_only)
    shared = overlap_area(circles.radius_x, circles.radius_y, circles.apart)
    assert shared == pytest.approx(both, abs=1e-6)
    assert pi * circles.radius_x**2 - shared == pytest.approx(x_only, abs=1e-6)
    assert pi * circles.radius_y**2 - shared == pytest.approx(y_only, abs=1e-6)


def test_the_overlap_of_two_circles_is_what_counting_points_gives() -> None:
    rng = np.random.default_rng(1)
    x, y = rng.uniform(-1, 1, 50_000), rng.uniform(-1, 1, 50_000)
    inside = (x**2 + y**2 <= 1) & ((x - 0.8) ** 2 + y**2 <= 0.25)
    assert overlap_area(1.0, 0.5, 0.8) == pytest.approx(4 * inside.mean(), abs=0.02)


def test_circles_apart_one_inside_the_other_and_one_on_the_other() -> None:
    circles = circles_of(0, 20, 5)
    assert circles.apart > circles.radius_x + circles.radius_y
    circles = circles_of(5, 4, 0)
    assert circles.apart + circles.radius_y == pytest.approx(circles.radius_x)
    circles = circles_of(5, 0, 0)
    assert (circles.apart, circles.radius_x) == (0, circles.radius_y)


def test_a_system_that_detects_nobody_has_no_circle() -> None:
    figure = drawn(Venn(0, 0, 7, 2, 0))
    assert [part.name for part in figure.layout.shapes] == ["all encounters", "circle y"]
    assert label(figure, "system x") == "X: FIR 0 of 9"


def test_counts_stand_in_their_regions() -> None:
    figure = drawn(Venn(50, 20, 21, 4, 6))
    assert label(figure, "both") == "50 both"
    assert label(figure, "x_only") == "20 only X"
    assert label(figure, "y_only") == "21 only Y"
    assert label(figure, "neither") == "4 neither"
    assert label(figure, "distant") == "6 too far to count"
    assert "95 encounters near enough to count; areas to scale" in words(figure)


def test_a_click_in_a_region_gives_its_category() -> None:
    venn = Venn(22, 8, 5, 3, 8)
    circles = circles_of(venn.both, venn.x_only, venn.y_only)
    places = trace(drawn(venn), "regions")
    for x, y, category in zip(places.x, places.y, places.customdata, strict=True):
        in_x = x**2 + y**2 <= circles.radius_x**2
        in_y = (x - circles.apart) ** 2 + y**2 <= circles.radius_y**2
        if category != "distant":
            assert category == {
                (True, True): "both", (True, False): "x_only", (False, True): "y_only",
                (False, False): "neither",
            }[bool(in_x), bool(in_y)]  # fmt: skip
    assert set(places.customdata) == {*REGIONS, "distant"}
    assert {*places.text} >= {"22 encounters: both", "8 encounters: distant"}
    assert "both" in trace(drawn(Venn(1, 900, 900, 0, 0)), "regions").customdata  # narrow


def test_without_encounters_that_count_the_diagram_says_so() -> None:
    shown = words(drawn(Venn(0, 0, 0, 0, 3)))
    assert "No pedestrian came near enough to count. 3 encounters stayed distant." in shown
    assert "distant" not in words(drawn(Venn(0, 0, 0, 0, 0)))


def encounters_of(venn: Venn, *, seed: int = 0) -> pd.DataFrame:
    """Made-up encounters of these counts as `weighed_encounters`, the heaviest first."""
    rng = np.random.default_rng(seed)
    kinds = [kind.value for kind in REGIONS for _ in range(venn.counts()[kind.value])]
    severity_s = rng.exponential(1, (2, len(kinds)))
    for row, spared in enumerate(("x_only", "y_only")):
        severity_s[row][[kind in (spared, "both") for kind in kinds]] = 0
    table = pd.DataFrame({"recording": "<i>", "track": range(len(kinds)), "category": kinds})
    for letter, values in zip("xy", severity_s, strict=True):
        table = table.assign(**{f"severity_s_{letter}": values, f"peak_cost_{letter}": 0.5})
    table = table.assign(severity_s=severity_s.max(axis=0), shown_row=10 + table["track"])
    return table.sort_values("severity_s", ascending=False, kind="stable")


def marks_of(figure: object) -> list[tuple[str, float, float, float, int]]:
    """Region, x, y, size (px) and frame row of each mark."""
    return [
        (kind.value, *values)
        for kind in REGIONS
        for part in figure.data
        if part.name == f"{CATEGORY_WORDS[kind]}, by severity"
        for values in zip(part.x, part.y, part.marker.size, part.customdata, strict=True)
    ]


@pytest.mark.parametrize(
    ("counts", "beside"),
    [
        ((22, 8, 5, 3), {"x_only", "y_only"}),
        ((60, 1, 1, 30), {"x_only", "y_only"}),  # these regions grow
        ((29, 54, 51, 1), {"both", "x_only", "y_only"}),  # counts give way to the marks
        ((0, 3, 0, 140), set()),
        ((0, 0, 0, 9), set()),
    ],
)
def test_every_encounter_has_a_mark_in_its_region_and_none_touches_another(
    counts: tuple[int, ...], beside: set[str]
) -> None:
    venn = Venn(*counts, 4)
    table = encounters_of(venn)
    figure = drawn(venn, table)
    assert {note.name for note in figure.layout.annotations if note.showarrow} == beside
    assert ("roughly" in words(figure)) == (counts == (60, 1, 1, 30))
    marks = marks_of(figure)
    by_row = table.set_index("shown_row")["category"]
    assert {row: kind for kind, *_, row in marks} == by_row.to_dict()
    assert len(marks) == len(table)
    x, y, size = (np.array(values) for values in [*zip(*marks, strict=True)][1:4])
    x_axis, y_axis = figure.layout.xaxis.range, figure.layout.yaxis.range
    assert x_axis[0] < x.min() < x.max() < x_axis[1]
    assert y_axis[0] < y.min() < y.max() < y_axis[1]
    # in a plot of 355 x 285 px
    scale = min(355 / (x_axis[1] - x_axis[0]), 285 / (y_axis[1] - y_axis[0]))
    for circle in figure.layout.shapes[1:]:
        radius = (circle.x1 - circle.x0) / 2
        inside = radius - np.hypot(x - (circle.x0 + circle.x1) / 2, y)
        is_own = np.array([kind in ("both", f"{circle.name[-1]}_only") for kind, *_ in marks])
        assert (np.where(is_own, inside, -inside) * scale >= size / 2).all()
    apart_px = np.hypot(x[:, None] - x, y[:, None] - y) * scale
    reach_px = (size[:, None] + size) / 2
    assert (apart_px > reach_px)[~np.eye(len(x), dtype=bool)].all()
    # no place for clicks on a region lies on a mark
    places = trace(figure, "regions")
    apart_px = np.hypot(x[:, None] - places.x, y[:, None] - places.y) * scale
    assert (apart_px.min(axis=1) > size / 2).all()
    assert set(places.customdata) >= {kind for kind, *_ in marks} | {"distant"}


def test_marks_are_larger_the_more_an_encounter_weighs_and_visible_without_weight() -> None:
    venn = Venn(3, 2, 0, 0, 0)
    table = encounters_of(venn)
    sizes = {row: size for *_, size, row in marks_of(drawn(venn, table))}
    in_order = [sizes[row] for row in table["shown_row"]]
    assert in_order == sorted(in_order, reverse=True)
    first, second = (table["severity_s"].iloc[i] for i in (0, 1))
    assert (in_order[1] / in_order[0]) ** 2 == pytest.approx(second / first)
    assert in_order[-3:] == [MIN_SIZE] * 3


def test_above_a_number_of_encounters_there_are_counts_and_weights_only() -> None:
    venn = Venn(MOST_MARKS, 1, 0, 0, 0)
    table = encounters_of(venn)
    figure = drawn(venn, table)
    assert [part.name for part in figure.data] == ["regions"]
    weight = table["severity_s_y"].sum()
    assert label(figure, "x_only") == f"1 only X Y {weight:.2f} s"
    assert label(figure, "both") == f"{MOST_MARKS} both X 0.00 s Y 0.00 s"


def test_a_mark_says_who_it_is_what_the_failure_weighs_and_where_to_look() -> None:
    truth = [at(f, 50, track=7) for f in range(10)]
    result = result_of(make_dataset(truth, truth, truth[:6]))
    mark = trace(drawn(result.venn, weighed_encounters(result)), "both, by severity")
    assert mark.text == (
        "r0, pedestrian 7: both<br>severity X 0.00 s, Y 0.40 s<br>peak cost X 0.00, Y 1.00",
    )
    assert list(mark.customdata) == [6]
    # it looks like the system that fails
    assert (mark.marker.color[0], mark.marker.symbol[0]) == (LOOK["light"].y, "diamond")


def test_the_weights_of_the_regions_add_up_to_the_severities() -> None:
    result = at_thresholds()
    figure = drawn(result.venn, weighed_encounters(result))
    labels = [note.text for note in figure.layout.annotations if note.name in set(REGIONS)]
    for letter, system in result.sides:
        texts = re.findall(rf"{letter.upper()} ([\d.]+) s", str(labels))
        total_s = system.failures["severity_s"].sum()
        assert sum(map(float, texts)) == pytest.approx(total_s, abs=0.03)
        assert len(texts) > 1
