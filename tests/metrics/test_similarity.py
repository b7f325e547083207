from __future__ import annotations

import numpy as np
import pytest
from builders import at, make_dataset, result_of

from nvcore.common.errors import ParameterError
from nvcore.common.findings import Remedy, Step
from nvcore.comparison.scoring import SystemResult
from nvcore.metrics.similarity import find_low_intervals, runs_of, smooth, summarise_similarity


def score_sets(
    G: list[float], S: list[float], *, width: float = 100, **params: object
) -> SystemResult:
    """One frame with pedestrians at G and detections of X at S, k = 1."""
    truth = [at(0, c, track=i) for i, c in enumerate(G)]
    dataset = make_dataset(truth, [at(0, c) for c in S], n_frames=1, width=width)
    return result_of(dataset, **params).x


def test_figure_7_of_the_paper_gives_7_and_2() -> None:
    x = score_sets([12, 17], [10])
    assert x.distances.d_miss[0] == 7
    assert x.distances.d_false[0] == 2
    assert x.similarity[0] == pytest.approx(1 - (0.9 * 7 + 0.1 * 2) / 50)


@pytest.mark.parametrize("alpha", [2 / 3, 0.8, 0.9, 1.0])
def test_the_papers_worst_case_reaches_1_minus_alpha(alpha: float) -> None:
    x = score_sets([10], [], width=20, alpha=alpha)
    assert x.distances.d_miss[0] == 10
    assert x.similarity[0] == pytest.approx(1 - alpha)


def test_a_miss_at_the_edge_costs_nothing_in_town_and_all_in_the_country() -> None:
    assert score_sets([0], []).distances.d_miss[0] == 0
    assert score_sets([0], [], edge_weight=1.0).distances.d_miss[0] == 50
    assert score_sets([0], [], edge_weight=0.4).distances.d_miss[0] == pytest.approx(20)


def test_a_detection_of_somebody_ignored_costs_nothing() -> None:
    x = result_of(make_dataset([at(0, 50, w=30, ignore=True)], [at(0, 50, w=30)])).x
    assert x.distances.d_false[0] == 0
    assert x.similarity[0] == 1


@pytest.mark.parametrize(("alpha", "width"), [(0.2, 768), (0.7, 640), (0.9, 1920)])
def test_rounding_never_takes_similarity_below_0(alpha: float, width: float) -> None:
    x = score_sets([0], [width], width=width, alpha=alpha, edge_weight=1.0)
    assert 0 <= x.similarity[0] < 1e-12


def test_proximity_by_horizon_without_a_horizon_says_what_to_give() -> None:
    with pytest.raises(ParameterError, match="for all recordings or for each") as raised:
        result_of(make_dataset(n_frames=1), proximity="horizon")
    assert raised.value.steps == (Step(Remedy.OPTION, "", "horizon"),)


def test_boxes_without_a_distance_are_weighed_by_height_and_counted() -> None:
    truth = [at(0, 50, h=10, track=1), at(0, 30, track=2, distance_m=35.0)]
    x = [at(0, 50, h=10), at(0, 60, h=10)]
    result = result_of(make_dataset(truth, x), proximity="distance")
    assert result.k_truth.k.tolist() == [0.5, 0.5]
    assert result.k_truth.n_without_distance == 1
    assert result.x.weights.n_without_distance == 2
    assert result_of(make_dataset(truth), proximity="height").k_truth.n_without_distance == 0


def test_boxes_that_do_not_count_need_no_distance() -> None:
    truth = [at(0, 50, track=1, distance_m=35.0), at(0, 80, w=30, ignore=True)]
    x = [at(0, 50, score=0.2, distance_m=35.0), at(0, 30, score=0.1), at(0, 80, score=0.9)]
    result = result_of(make_dataset(truth, x), proximity="distance", threshold_x=0.2)
    assert result.k_truth.n_without_distance == 0
    assert result.x.weights.n_without_distance == 0


@pytest.mark.parametrize("fps", [7, 10, 25, 29.97, 30])
def test_a_frame_exactly_half_a_window_away_counts_at_any_rate(fps: float) -> None:
    frames = make_dataset(n_frames=7, fps=fps).frame_columns
    mean = smooth(np.array([1.0, 0, 0, 0, 0, 0, 1]), frames, window=6 / fps)
    assert mean[3] == pytest.approx(2 / 7)


def test_a_window_that_rounds_to_just_below_whole_frames_keeps_its_ends() -> None:
    # 18.08 s at 12.5 Hz are 113 frames to either side, 112.99999999999999 as a product
    frames = make_dataset(n_frames=227, fps=12.5).frame_columns
    values = np.zeros(227)
    values[[0, -1]] = 1
    assert smooth(values, frames, window=18.08)[113] == pytest.approx(2 / 227)


def test_no_frames_have_no_moving_mean_and_no_interval() -> None:
    frames = make_dataset().frame_columns
    assert smooth(np.empty(0), frames, window=1).size == 0
    assert find_low_intervals(np.empty(0), frames).empty


def test_runs_end_where_the_key_or_the_recording_changes() -> None:
    key, recording = np.array([-1, 4, 4, 5, 5, 5, -1, 5]), np.array([0, 0, 0, 0, 1, 1, 1, 1])
    first, last = runs_of(key, recording)
    assert first.tolist() == [1, 3, 4, 7]
    assert last.tolist() == [2, 3, 5, 7]


def test_low_intervals_by_hand() -> None:
    frames = make_dataset(n_frames=7, fps=10).frame_columns
    table = find_low_intervals(np.array([0.85, 0.9, 0.8, 0.5, 0.7, 1, 0.85]), frames, low=0.9)
    assert table["first_row"].tolist() == [0, 2, 6]
    assert table["last_row"].tolist() == [0, 4, 6]
    assert table["duration_s"].tolist() == pytest.approx([0.1, 0.3, 0.1])
    assert table["depth_s"].tolist() == pytest.approx([0.005, 0.07, 0.005])
    assert table["min_similarity"].tolist() == [0.85, 0.5, 0.85]
    assert table["worst_row"].tolist() == [0, 3, 6]


def test_the_first_of_equally_bad_frames_is_the_worst() -> None:
    frames = make_dataset(n_frames=4).frame_columns
    assert find_low_intervals(np.array([0.5, 0.4, 0.4, 0.5]), frames)["worst_row"].tolist() == [1]


def test_aggregates_by_hand() -> None:
    summary = summarise_similarity(np.array([0.5, 0.9, 1.0, 0.8, 0.7]), low=0.9)
    assert summary.mean == pytest.approx(0.78)
    assert summary.minimum == 0.5
    assert summary.share_low == 0.6
    # rank 0.05 * 4 = 0.2 between 0.5 and 0.7
    assert summary.percentile_5 == pytest.approx(0.54)


def test_aggregates_of_no_frame_are_undefined() -> None:
    summary = summarise_similarity(np.empty(0))
    assert np.isnan([summary.mean, summary.minimum, summary.percentile_5, summary.share_low]).all()


def test_strict_pairing_measures_to_the_match_and_to_the_border_without_one() -> None:
    truth = [at(0, 30, track=1), at(0, 60, track=2)]
    x = [at(0, 31), at(0, 55)]  # the second overlaps nobody
    nearest, strict = (
        result_of(make_dataset(truth, x), pairing=pairing, iou=0.1).x.distances
        for pairing in ("nearest", "matched")
    )
    assert (nearest.d_miss[0], nearest.d_false[0]) == (5, 5)
    assert (strict.d_miss[0], strict.d_false[0]) == (40, 45)


def test_only_by_the_nearest_box_can_a_false_alarm_raise_similarity() -> None:
    truth = [at(0, 50, track=1)]
    for pairing, is_raised in (("nearest", True), ("matched", False)):
        without, beside = (
            float(result_of(make_dataset(truth, x), pairing=pairing).x.similarity[0])
            for x in ([], [at(0, 55)])
        )
        assert (beside > without) is is_raised
