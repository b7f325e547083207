from __future__ import annotations

import numpy as np
import pytest
from builders import Place, at, make_dataset, result_of
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.stats import binomtest

from nvcore.comparison.compare import Result
from nvcore.dataset.schema import Category
from nvcore.metrics.venn import Venn, categorise, measure_exclusivity

COUNT = st.integers(0, 30)
VENNS = st.builds(Venn, COUNT, COUNT, COUNT, COUNT, COUNT)
FIGURE_1 = "+++++xxyy-"
FIGURE_2 = "+++++xxx--"


def drive(signs: str, *, extra: str = "") -> Result:
    """One recording per encounter, with the figures' signs: + both, x, y only, - neither."""
    places = [Place(range(4)) for _ in signs + extra]
    truth, x, y = [], [], []
    for number, sign in enumerate(signs + extra):
        height = 4 if sign == "." else 50  # "." a distant one
        for frame in range(4):
            truth.append(at(frame, 50, track=1, h=height, recording=number))
            if sign in "+x":
                x.append(at(frame, 50, recording=number))
            if sign in "+y":
                y.append(at(frame, 50, recording=number))
    return result_of(make_dataset(truth, x, y, places=places), proximity="height")


def test_figure_1_of_the_paper_from_encounters() -> None:
    result = drive(FIGURE_1)
    assert result.venn == Venn(both=5, x_only=2, y_only=2, neither=1, distant=0)
    assert result.x.encounters["is_detected"].sum() == 7
    assert result.y.encounters["is_detected"].sum() == 7
    assert result.venn.dominant is None


def test_figure_2_of_the_paper_from_encounters() -> None:
    result = drive(FIGURE_2)
    assert result.venn == Venn(both=5, x_only=3, y_only=0, neither=2, distant=0)
    assert result.venn.dominant == "x"


def test_distant_encounters_are_counted_apart() -> None:
    venn = drive(FIGURE_1, extra="..").venn
    assert venn.distant == 2
    assert venn.n_near == 10
    assert sum(venn.counts().values()) == 12


def test_distance_goes_before_detection() -> None:
    category = categorise(np.array([True]), np.array([True]), np.array([True]))
    assert category.tolist() == [Category.DISTANT.value]


@pytest.mark.parametrize(
    ("x_only", "y_only", "dominant"), [(1, 0, "x"), (0, 1, "y"), (0, 0, None), (3, 1, None)]
)
def test_a_system_dominates_that_detects_all_of_the_other_and_more(
    x_only: int, y_only: int, dominant: str | None
) -> None:
    assert Venn(5, x_only, y_only, 2, 0).dominant == dominant


@given(VENNS)
@settings(deadline=None, derandomize=True)
def test_mcnemar_is_scipys_exact_binomial_test(venn: Venn) -> None:
    discordant = venn.x_only + venn.y_only
    expected = binomtest(venn.x_only, discordant).pvalue if discordant else 1
    assert measure_exclusivity(venn).mcnemar_p == pytest.approx(expected)


@given(VENNS)
@settings(deadline=None, derandomize=True)
def test_phi_is_the_correlation_of_the_misses(venn: Venn) -> None:
    counts = [venn.both, venn.x_only, venn.y_only, venn.neither]
    missed_x = np.repeat([0, 0, 1, 1], counts)
    missed_y = np.repeat([0, 1, 0, 1], counts)
    phi = measure_exclusivity(venn).phi
    if len(set(missed_x)) < 2 or len(set(missed_y)) < 2:
        assert np.isnan(phi)
    else:
        assert phi == pytest.approx(np.corrcoef(missed_x, missed_y)[0, 1])


def test_the_counts_and_the_jaccard_index_of_figure_1() -> None:
    exclusivity = drive(FIGURE_1).exclusivity
    assert (exclusivity.missed_by_x, exclusivity.missed_by_y) == (3, 3)
    assert exclusivity.missed_by_both == 1
    assert exclusivity.jaccard == 1 / 5
    assert exclusivity.phi == pytest.approx(1 / 21)  # (5 * 1 - 2 * 2) / (3 * 7)
    assert exclusivity.mcnemar_p == 1


def test_misses_that_are_all_shared_are_not_exclusive() -> None:
    exclusivity = measure_exclusivity(Venn(3, 0, 0, 4, 0))
    assert exclusivity.jaccard == exclusivity.phi == exclusivity.mcnemar_p == 1


def test_without_any_miss_jaccard_and_phi_are_undefined() -> None:
    exclusivity = measure_exclusivity(Venn(3, 0, 0, 0, 2))
    assert np.isnan([exclusivity.jaccard, exclusivity.phi]).all()
    assert exclusivity.mcnemar_p == 1


def test_very_many_encounters_do_not_overflow_phi() -> None:
    n = 10**7
    assert measure_exclusivity(Venn(n, 0, 0, n, 0)).phi == pytest.approx(1)


def test_boxes_are_counted_by_who_matched_them_and_ignored_ones_not() -> None:
    truth = [at(0, c, track=c) for c in (10, 30, 50, 70)] + [at(0, 90, ignore=True)]
    result = result_of(
        make_dataset(truth, [at(0, 10), at(0, 30), at(0, 90)], [at(0, 10), at(0, 50)])
    )
    boxes = result.boxes
    assert (boxes.both, boxes.x_only, boxes.y_only, boxes.neither) == (1, 1, 1, 1)
