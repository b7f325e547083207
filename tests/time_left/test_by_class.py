"""Time left by class: urgent encounters counted, with evidence or the reason why there is none."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest
from approach import ALL, LATE, NEVER, met

from nvcore.comparison.compare import Result, compare
from nvcore.dataset.schema import ATTRIBUTE_DTYPES
from nvcore.evidence.subgroups import class_groups
from nvcore.report.section import Fold, Table
from nvcore.subjects.time_left.by_class import OfClass, time_left_by_class
from nvcore.subjects.time_left.section import SECTIONS


def with_children(result: Result, *recordings: int) -> Result:
    """The pedestrians of these recordings are children, as the truth says."""
    dataset = result.dataset
    boxes = dataset.boxes.assign(line=np.arange(1, len(dataset.boxes) + 1, dtype=np.int32))
    recording = dataset.frames["recording"].to_numpy()[boxes["frame_index"].to_numpy()]
    is_child = (boxes["source"] == 0).to_numpy() & np.isin(recording, recordings)
    lines = [(0, line, "a child") for line in boxes["line"][is_child]]
    attributes = pd.DataFrame(lines, columns=list(ATTRIBUTE_DTYPES))
    dataset = replace(
        dataset, boxes=boxes, attributes=attributes.astype({"attributes": "category"})
    )
    return compare(dataset, result.params)


def of_children(result: Result) -> OfClass:
    (row,) = [row for row in time_left_by_class(result) if row.name == "a child"]
    return row


def test_urgent_encounters_of_a_class_are_counted_alone():
    result = with_children(met((ALL, ALL), (ALL, LATE), (NEVER, ALL), (ALL, NEVER)), 1, 2, 3)
    row = of_children(result)
    assert (row.n_urgent, row.in_time_x, row.in_time_y) == (3, 2, 1)
    assert (row.share.x, row.share.y) == pytest.approx((2 / 3, 1 / 3))
    # X never confirms one of three: 50 km/h; Y confirms one late, at 15 km/h as rounded, one never
    assert row.impact.x == pytest.approx(50 / 3)
    assert 50 / 3 < row.impact.y < 2 * 50 / 3


def test_the_report_has_the_table_by_class_and_says_why_there_is_no_interval():
    result = with_children(met((ALL, ALL), (ALL, LATE), (NEVER, ALL), (ALL, NEVER)), 1, 2, 3)
    (fold,) = [
        block
        for block in SECTIONS[0].make(result).worded(result.objects).blocks
        if isinstance(block, Fold) and block.title == "By class of pedestrian"
    ]
    (by_class,) = fold.blocks
    assert isinstance(by_class, Table)
    assert "Impact: mean impact speed" in by_class.note
    (row,) = [row for row in by_class.rows if row[0].startswith("a child")]
    assert row == ("a child, 3 urgent", "2", "1", "+33.3 pp", "–", "16.7", "27.1", "-10.5", "–")
    assert by_class.marks[by_class.rows.index(row)] == "a"
    assert by_class.note.startswith("a: Too few blocks for an interval: 3")


def test_too_few_recordings_have_no_interval_and_the_reason():
    share = of_children(with_children(met(*[(ALL, LATE)] * 4), 0, 1)).share
    assert share.difference == 1
    assert np.isnan([share.low, share.high]).all()
    assert "interval" in share.note or "recordings only" in share.note


def test_eight_recordings_have_one():
    sides = [(ALL, LATE)] * 7 + [(ALL, ALL)] * 3
    share = of_children(with_children(met(*sides), *range(1, 9))).share
    assert (share.n, share.unit) == (8, "recordings")
    assert share.low < share.difference == 0.75 < share.high


def test_distant_encounters_are_in_a_group_only_where_they_count():
    result = with_children(met((ALL, ALL), (ALL, ALL)), 0, 1)
    everyone = np.ones(2, dtype=bool)
    names = [group.group for group in class_groups(result, everyone)]
    assert "a child" in names
    first = {group.group: group for group in class_groups(result, np.array([True, False]))}
    assert first["a child"].is_member.tolist() == [True, False]
    assert first["a child"].recordings.tolist() == [True, False]
    assert class_groups(result, ~everyone) == ()
