"""What matched boxes were taken for: counted by hand, by place alone, empty where nothing is."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from builders import Box, make_dataset, result_of
from limits import LABELS, limits_read, sign

from nvcore.comparison.compare import Result
from nvcore.figures.maps import classes_plot
from nvcore.tables.classes import classes_table, has_classes, names_classes, read_share


def counted(result: Result) -> list[tuple[object, ...]]:
    table = classes_table(result).astype(object)
    return [tuple(row) for row in table.where(table.notna(), None).itertuples(index=False)]


def test_matches_are_counted_by_both_classes() -> None:
    # the sixth sign has no class, the seventh is a false alarm, Y names nothing
    assert counted(limits_read()) == [
        ("x", "30", "30", 2),
        ("x", "30", "50", 1),
        ("x", "50", "50", 1),
        ("x", "50", None, 1),
    ]


def test_a_stricter_matching_leaves_the_table_as_it_is() -> None:
    strict = limits_read(match_class="same")
    assert counted(strict) == counted(limits_read())
    # of the six signs three are read right, and that without a class is matched by any
    assert strict.x.matches.is_matched.sum() == 4
    assert strict.x.matches.is_false_alarm.sum() == 3


def test_detections_below_the_threshold_read_nothing() -> None:
    assert counted(limits_read(threshold_x=0.95)) == []


def test_the_share_read_right_has_wilsons_interval() -> None:
    share = read_share(classes_table(limits_read()), "x")
    assert (share.n_right, share.n, share.share) == (3, 5, 0.6)
    # Wilson: (p + z^2/2n +- z sqrt(p(1-p)/n + z^2/4n^2)) / (1 + z^2/n), z = 1.95996
    assert (share.low, share.high) == pytest.approx((0.2307, 0.8824), abs=1e-4)


def test_without_matches_the_share_is_undefined() -> None:
    share = read_share(classes_table(limits_read()), "y")
    assert share.n == 0
    assert np.isnan([share.share, share.low, share.high]).all()


def test_there_are_classes_where_the_truth_has_several_and_a_system_names_one() -> None:
    result = limits_read()
    assert has_classes(result)
    assert names_classes(result, result.x)
    assert not names_classes(result, result.y)
    assert not has_classes(result_of(make_dataset([Box(0, 0, 0, 9, 9)], [Box(0, 0, 0, 9, 9)])))
    of_one = make_dataset([sign(0, "30")], [sign(0, "50")], labels=LABELS)
    assert not has_classes(result_of(of_one))
    unnamed = make_dataset([sign(0, "30"), sign(1, "50")], [sign(0, "")], labels=LABELS)
    assert not has_classes(result_of(unnamed))
    ignored = make_dataset(
        [sign(0, "30"), sign(1, "50", ignore=True)], [sign(0, "30")], labels=LABELS
    )
    assert not has_classes(result_of(ignored))


def test_the_matrix_has_a_row_for_each_class_and_shares_of_it() -> None:
    figure = classes_plot(classes_table(limits_read()), "x", "Ray", theme="light")
    (cells,) = figure.data
    np.testing.assert_allclose(
        np.array(cells.z, float), [[2 / 3, 1 / 3, np.nan], [np.nan, 0.5, 0.5]]
    )
    assert [list(row) for row in cells.text] == [["2", "1", ""], ["", "1", "1"]]
    assert list(figure.layout.xaxis.ticktext) == ["30", "50", "no class"]
    assert list(figure.layout.yaxis.ticktext) == ["30", "50"]
    assert "3 of 5 matches right" in figure.layout.title.text


def test_nothing_read_is_said_so() -> None:
    figure = classes_plot(classes_table(limits_read()), "y", "Yon", theme="dark")
    assert "No match has a class" in str(figure)


def test_names_of_classes_are_text_and_nothing_else() -> None:
    result = limits_read()
    hostile = replace(result.dataset, labels=("<b>30</b>", "50"))
    table = classes_table(replace(result, dataset=hostile))
    assert "<b>" not in str(classes_plot(table, "x", "<b>", theme="light").layout.yaxis)
