"""What the viewer sends to the browser, and which of its answers count."""

from __future__ import annotations

import base64

import numpy as np
import pytest
from builders import at, make_dataset

from nvcore.common.palette import STYLES, Scheme
from nvcore.dataset.schema import DetectionState
from nvcore.metrics.cost_map import map_cost
from nvcore.settings.objects import PEDESTRIAN
from nvcore.settings.params import Params
from ui.session import packed_comparison
from ui.widgets.viewer import FOLDER, colours_of, settled_row
from ui.widgets.viewer.packing import (
    MOST_BUCKETS,
    decimate_minima,
    find_runs,
    find_spans,
    pack,
    pack_cost,
    pack_frames,
    pack_times,
)


def unpack(text: str, dtype: str) -> list[float]:
    return np.frombuffer(base64.b64decode(text), f"<{dtype}").tolist()


def frames_of(starts: np.ndarray, firsts: np.ndarray, steps: np.ndarray, n: int) -> list[int]:
    """What the browser makes of the runs."""
    stops = [*starts[1:], n]
    return [
        int(first + step * (row - start))
        for start, stop, first, step in zip(starts, stops, firsts, steps, strict=True)
        for row in range(start, stop)
    ]


def test_numbers_are_packed_little_endian():
    assert base64.b64decode(pack([1, 256], "i4")) == b"\1\0\0\0\0\1\0\0"


def test_regular_frames_are_one_run_and_none_are_none():
    starts, firsts, steps = find_runs(np.array([9, 29, 49, 69]))
    assert (starts.tolist(), firsts.tolist(), steps.tolist()) == ([0], [9], [20])
    assert unpack(pack_frames(np.array([], dtype=np.int64))["starts"], "i4") == []


def test_the_cost_of_a_miss_is_sent_as_weight_by_row_and_border_by_column():
    dataset = make_dataset([at(0, 50)], horizon=25.0)
    settings = Params(proximity="horizon", midpoint=25.0, spread=1e-3)
    cost = map_cost(dataset.truth, dataset.frame_columns, settings, 0, n_rows=4, n_columns=2)
    sent = pack_cost(cost)
    k = unpack(sent["k"], "f4")
    assert np.isnan(k[0])
    assert k[1:] == [0, 1, 1]  # feet in rows 37.5, 62.5 and 87.5; half at row 50
    assert unpack(sent["border"], "f4") == [0.5, 0.5]
    assert sent["text"] == PEDESTRIAN.say(cost.text) == "depth of the feet below the horizon"


@pytest.mark.parametrize(
    "frames", [[5], [1, 2], [0, 1, 2, 10, 11, 12], [1, 5, 6, 100, 200, 300, 301], [3, 9, 27]]
)
def test_runs_give_back_the_frame_numbers(frames):
    runs = find_runs(np.array(frames))
    assert frames_of(*runs, len(frames)) == frames


def test_spans_hold_the_rows_of_a_mask():
    mask = np.array([True, True, False, True, False, False, True])
    assert find_spans(mask).tolist() == [[0, 2], [3, 4], [6, 7]]
    assert find_spans(np.zeros(3, dtype=bool)).tolist() == []


def test_times_are_one_offset_where_they_follow_from_the_frame_number():
    frames = np.array([100, 101, 140])
    assert pack_times(frames / 20 - 5, frames, 20.0) == {"offset": pytest.approx(-5)}
    irregular = np.array([0.0, 0.05, 0.2])
    sent = pack_times(irregular, np.array([0, 1, 2]), 20.0)
    assert unpack(sent["every_row"], "f8") == irregular.tolist()
    assert "every_row" in pack_times(np.array([0.0, 1.0]), np.array([0, 1]), float("nan"))


def test_a_short_trace_is_sent_as_it_is():
    trace, bucket_rows = decimate_minima(np.array([0.5, np.nan, 0.25]), 3)
    assert bucket_rows == 1
    np.testing.assert_array_equal(trace, np.array([0.5, np.nan, 0.25], dtype=np.float32))


def test_a_long_trace_keeps_every_dip():
    similarity = np.ones(MOST_BUCKETS * 3 + 1)
    similarity[4000] = 0.25
    trace, bucket_rows = decimate_minima(similarity, len(similarity))
    assert len(trace) <= MOST_BUCKETS
    assert trace[4000 // bucket_rows] == 0.25
    assert np.count_nonzero(trace < 1) == 1


def test_a_bucket_is_undefined_only_where_all_its_rows_are():
    similarity = np.full(MOST_BUCKETS * 2, np.nan)
    similarity[1] = 0.5
    trace, _ = decimate_minima(similarity, len(similarity))
    assert trace[0] == 0.5
    assert np.isnan(trace[1:]).all()


@pytest.mark.parametrize(
    ("settled", "row"),
    [
        ({"recording": 2, "row": 7, "nonce": 3}, 7),
        (None, 1),
        ({"recording": 1, "row": 7, "nonce": 3}, 1),
        ({"recording": 2, "row": 7, "nonce": 2}, 1),  # before the seek
        ({"recording": 2, "row": 10, "nonce": 3}, 1),
        ({"recording": 2, "row": -1, "nonce": 3}, 1),
        ({"recording": 2, "row": "7", "nonce": 3}, 1),
        ("7", 1),
    ],
)
def test_a_settled_row_counts_else_the_wish_stands(settled, row):
    assert settled_row(settled, recording=2, n_rows=10, seek=(1, 3)) == row
    assert settled_row(None, recording=0, n_rows=10, seek=(99, 0)) == 9  # beyond the end


def test_the_script_reads_the_states_that_the_library_packs():
    script = (FOLDER / "data" / "boxes.js").read_text(encoding="utf-8").replace(" }", ", }")
    for name in ("ignore", "matched_x", "matched_y", "relevant", "salient_x", "salient_y"):
        assert f" {name}: {getattr(packed_comparison, f'BIT_{name.upper()}')}," in script
    for name in ("matched", "false_alarm", "absorbed"):
        assert f" {name}: {DetectionState[name.upper()].value}," in script


def test_the_viewer_gets_colours_and_lines_by_system():
    sent = colours_of(Scheme("light", 1, 0))
    assert (sent["picture"]["x"], sent["picture"]["dash"]["x"]) == (STYLES[1].dark, [6, 4])
    assert (sent["chrome"]["y"], sent["chrome"]["line-y"]) == (STYLES[0].light, "solid")
