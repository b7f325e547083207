"""Encounters by what their failures weigh."""

from __future__ import annotations

import pytest
from builders import at, make_dataset, result_of

from nvcore.tables import weighed_encounters


def test_encounters_are_listed_by_the_larger_severity_without_distant_ones():
    truth = [
        *(at(f, 20, track=1) for f in range(4)),  # X misses the last two, at the side
        *(at(f, 50, track=2) for f in range(4)),  # Y misses all, in the middle
        *(at(f, 80, track=3) for f in range(4)),  # nobody misses
        *(at(f, 65, track=4, h=3) for f in range(4)),  # distant
    ]
    x = [box for box in truth if not (box.track == 1 and box.frame >= 2)]
    y = [box for box in truth if box.track != 2]
    table = weighed_encounters(result_of(make_dataset(truth, x, y), proximity="height"))
    assert table["track"].tolist() == [2, 1, 3]
    assert table.index.tolist() == [1, 0, 2]
    # k is 1 to four digits; the border is 50 and 20 of 50 px
    assert table["severity_s"].tolist() == pytest.approx([0.4, 0.4 * 0.2, 0], abs=1e-3)
    assert table["severity_s_y"].tolist() == pytest.approx([0.4, 0, 0], abs=1e-3)
    assert table["shown_row"].tolist() == [0, 2, 0]


def test_without_encounters_the_columns_are_there():
    table = weighed_encounters(result_of(make_dataset(n_frames=2)))
    assert len(table) == 0
    assert {"severity_s", "shown_row"} <= set(table)
