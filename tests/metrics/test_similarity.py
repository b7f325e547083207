from __future__ import annotations

import math

import numpy as np
import pytest
from builders import Box, Place, at, make_dataset, result_of
from scenes import draw_scene

from nvcore.comparison import Result, SystemResult, compare
from nvcore.errors import ParameterError
from nvcore.metrics.similarity import (
    find_low_intervals,
    runs_of,
    salient_detection,
    smooth,
    summarise_similarity,
)
from nvcore.params import Params


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


def test_a_false_alarm_straight_ahead_alone_reaches_alpha() -> None:
    x = score_sets([], [10], width=20, alpha=0.2)
    assert x.distances.d_false[0] == 10
    assert x.similarity[0] == pytest.approx(0.2)


@pytest.mark.parametrize("alpha", [0.0, 0.4, 0.6, 1.0])
def test_a_pedestrian_and_a_detection_at_the_thirds_reach_one_third(alpha: float) -> None:
    x = score_sets([40], [80], width=120, alpha=alpha)
    assert x.similarity[0] == pytest.approx(1 / 3)


def test_a_frame_with_neither_pedestrians_nor_detections_has_similarity_1() -> None:
    assert score_sets([], []).similarity.tolist() == [1]


def test_a_perfect_system_has_similarity_1() -> None:
    assert score_sets([12, 17, 93], [17, 12, 93]).similarity.tolist() == [1]


def test_vertical_position_does_not_matter_laterally_and_does_on_the_ground() -> None:
    dataset = make_dataset([at(0, 50, foot=90, track=1)], [at(0, 53, foot=94)])
    assert result_of(dataset).x.distances.d_miss[0] == 3
    assert result_of(dataset, distance="ground").x.distances.d_miss[0] == 5


def test_a_miss_at_the_edge_costs_nothing_in_town_and_all_in_the_country() -> None:
    assert score_sets([0], []).distances.d_miss[0] == 0
    assert score_sets([0], [], edge_weight=1.0).distances.d_miss[0] == 50
    assert score_sets([0], [], edge_weight=0.4).distances.d_miss[0] == pytest.approx(20)


@pytest.mark.parametrize(("alpha", "width"), [(0.2, 768), (0.7, 640), (0.9, 1920)])
def test_rounding_never_takes_similarity_below_0(alpha: float, width: float) -> None:
    x = score_sets([0], [width], width=width, alpha=alpha, edge_weight=1.0)
    assert 0 <= x.similarity[0] < 1e-12


def test_a_box_half_out_of_the_picture_stands_at_its_edge() -> None:
    x = score_sets([-7], [4])
    assert x.distances.d_false[0] == 4
    assert x.distances.d_miss[0] == 0


def salient_of_x(result: Result, row: int) -> int:
    return salient_detection(
        result.dataset.system("x"), result.x.weights.k, result.x.matches.is_counted,
        result.x.nearest, result.dataset.frame_columns, row,
        edge_weight=result.params.edge_weight,
    )  # fmt: skip


@pytest.mark.parametrize("number", [40, 42, 44])
@pytest.mark.parametrize("edge_weight", [0.0, 0.4])
def test_the_salient_detection_is_the_one_at_which_the_distance_stands(
    number: int, edge_weight: float
) -> None:
    result = compare(draw_scene(number).dataset(), Params(edge_weight=edge_weight))
    boxes, frames = result.dataset.system("x"), result.dataset.frame_columns
    for row in range(len(frames)):
        at = salient_of_x(result, row)
        width = frames.width[frames.recording[row]]
        here = slice(boxes.offsets[row], boxes.offsets[row + 1])
        if at < 0:
            assert not result.x.matches.is_counted[here].any()
            continue
        centre = np.clip(boxes.x[at] + boxes.w[at] / 2, 0, width)
        border = edge_weight * width / 2 + (1 - edge_weight) * min(centre, width - centre)
        reach = min(border, result.x.nearest.detections[at])
        assert here.start <= at < here.stop
        assert result.x.weights.k[at] * reach == pytest.approx(result.x.distances.d_false[row])
    assert result.x.matches.is_counted.any()


def test_a_detection_beyond_the_edge_can_be_the_salient_one() -> None:
    # half rural: 25 px at the edge, against 20 px from the pedestrian
    data = make_dataset([at(0, 60, track=1)], [at(0, 40), at(0, 120)])
    result = result_of(data, edge_weight=0.5)
    assert result.dataset.system("x").x[salient_of_x(result, 0)] == 119
    assert result.x.distances.d_false[0] == 25


def test_every_recording_is_measured_against_its_own_width() -> None:
    places = [Place([0], width=100), Place([0], width=200)]
    truth = [at(0, 50, track=1), at(0, 50, track=1, recording=1)]
    result = result_of(make_dataset(truth, places=places), alpha=1.0)
    assert result.x.similarity.tolist() == [0, 0.5]


def test_the_default_midpoint_is_a_tenth_of_the_height() -> None:
    result = result_of(make_dataset([at(0, 50, h=48, track=1)], height=480), proximity="height")
    assert result.k_truth.k.tolist() == [0.5]
    taller = result_of(make_dataset([at(0, 50, h=57.6, track=1)], height=480), proximity="height")
    assert taller.k_truth.k[0] == pytest.approx(1 / (1 + math.exp(-1)))


def test_each_recording_has_its_own_default_midpoint() -> None:
    places = [Place([0], height=100), Place([0], height=500)]
    truth = [at(0, 50, h=50, track=1, recording=i) for i in (0, 1)]
    k = result_of(make_dataset(truth, places=places), proximity="height").k_truth.k
    assert k[0] > 0.99
    assert k[1] == 0.5


def test_given_midpoint_and_spread_replace_the_defaults() -> None:
    dataset = make_dataset([at(0, 50, h=30, track=1)])
    result = result_of(dataset, proximity="height", midpoint=40, spread=5)
    assert result.k_truth.k[0] == pytest.approx(1 / (1 + math.exp(2)))


def test_proximity_by_horizon_measures_the_depth_of_the_foot_point() -> None:
    dataset = make_dataset([at(0, 50, foot=60, track=1)], horizon=45)
    assert result_of(dataset, proximity="horizon", midpoint=15).k_truth.k.tolist() == [0.5]
    assert result_of(dataset, proximity="horizon", midpoint=15, horizon=40).k_truth.k[0] > 0.5


def test_proximity_by_horizon_without_a_horizon_says_what_to_give() -> None:
    with pytest.raises(ParameterError, match="give --horizon, or horizon for every recording"):
        result_of(make_dataset(n_frames=1), proximity="horizon")


def test_proximity_by_distance_is_half_at_its_midpoint_and_falls_with_distance() -> None:
    truth = [at(0, 50, track=1, distance_m=35.0), at(0, 30, track=2, distance_m=42.0)]
    k = result_of(make_dataset(truth), proximity="distance").k_truth.k
    assert k[0] == 0.5
    assert k[1] == pytest.approx(1 / (1 + math.e))


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


def test_the_sigmoid_cannot_overflow_however_small_the_spread() -> None:
    truth = [at(0, 50, h=1, track=1), at(0, 30, h=99, track=2)]
    result = result_of(make_dataset(truth), proximity="height", midpoint=50, spread=1e-6)
    assert result.k_truth.k == pytest.approx([0, 1], abs=1e-300)


def test_each_box_is_weighed_by_itself_in_whichever_set_it_stands() -> None:
    dataset = make_dataset([at(0, 50, h=30, track=1)], [at(0, 40, h=10)])
    x = result_of(dataset, proximity="height", midpoint=10, spread=5).x
    assert x.distances.d_miss[0] == pytest.approx(10 / (1 + math.exp(-4)))
    assert x.distances.d_false[0] == 5


def test_an_absorbed_detection_does_not_shorten_a_distance() -> None:
    truth = [at(0, 50, track=1), at(0, 70, w=20, ignore=True)]
    x = result_of(make_dataset(truth, [at(0, 70)])).x
    assert x.distances.d_miss.tolist() == [50]
    assert x.distances.d_false.tolist() == [0]


def test_a_detection_below_the_threshold_does_not_count() -> None:
    dataset = make_dataset([at(0, 50, track=1)], [at(0, 50, score=0.3)])
    assert result_of(dataset, threshold_x=0.3).x.distances.d_miss.tolist() == [0]
    assert result_of(dataset, threshold_x=0.31).x.distances.d_miss.tolist() == [50]


def test_the_moving_mean_takes_frames_up_to_half_a_window_away() -> None:
    frames = make_dataset(n_frames=5, fps=10).frame_columns
    values = np.array([1.0, 0, 0, 0.6, 0.3])
    assert smooth(values, frames, window=0.2).tolist() == pytest.approx(
        [0.5, 1 / 3, 0.2, 0.3, 0.45]
    )


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


def test_the_moving_mean_does_not_cross_recordings() -> None:
    frames = make_dataset(places=[Place([0, 1]), Place([2, 3])]).frame_columns
    mean = smooth(np.array([1.0, 0.5, 0, 0.2]), frames, window=100)
    assert mean.tolist() == pytest.approx([0.75, 0.75, 0.1, 0.1])


def test_the_moving_mean_goes_by_time_not_by_listed_frames() -> None:
    frames = make_dataset(frames=[0, 1, 20, 21], fps=20).frame_columns
    mean = smooth(np.array([1.0, 0.5, 0, 0.2]), frames, window=1)
    assert mean.tolist() == pytest.approx([0.75, 0.75, 0.1, 0.1])


def test_each_recording_has_the_window_of_its_own_frame_rate() -> None:
    frames = make_dataset(places=[Place([0, 1, 2], fps=1), Place([0, 1, 2], fps=10)]).frame_columns
    mean = smooth(np.array([1.0, 0, 0, 1, 0, 0]), frames, window=0.2)
    assert mean.tolist() == pytest.approx([1, 0, 0, 0.5, 1 / 3, 0])


def test_without_a_window_the_moving_mean_is_the_value() -> None:
    frames = make_dataset(n_frames=3).frame_columns
    assert smooth(np.array([0.25, 0.5, 1]), frames, window=0).tolist() == [0.25, 0.5, 1]


def test_no_frames_have_no_moving_mean_and_no_interval() -> None:
    frames = make_dataset().frame_columns
    assert smooth(np.empty(0), frames, window=1).size == 0
    assert find_low_intervals(np.empty(0), frames).empty


def test_runs_end_where_the_key_or_the_recording_changes() -> None:
    key, recording = np.array([-1, 4, 4, 5, 5, 5, -1, 5]), np.array([0, 0, 0, 0, 1, 1, 1, 1])
    first, last = runs_of(key, recording)
    assert first.tolist() == [1, 3, 4, 7]
    assert last.tolist() == [2, 3, 5, 7]


def test_a_low_interval_by_hand() -> None:
    frames = make_dataset(n_frames=6, fps=10).frame_columns
    table = find_low_intervals(np.array([0.9, 0.8, 0.5, 0.7, 1, 0.85]), frames, low=0.9)
    assert table["first_row"].tolist() == [1, 5]
    assert table["last_row"].tolist() == [3, 5]
    assert table["duration_s"].tolist() == pytest.approx([0.3, 0.1])
    assert table["severity_s"].tolist() == pytest.approx([0.07, 0.005])
    assert table["min_similarity"].tolist() == [0.5, 0.85]
    assert table["worst_row"].tolist() == [2, 5]


def test_severity_weighs_each_frame_by_its_time_step() -> None:
    frames = make_dataset(frames=[0, 1, 5, 6], fps=10).frame_columns
    table = find_low_intervals(np.array([1, 0.5, 0.8, 1]), frames, low=0.9)
    assert table["severity_s"].tolist() == pytest.approx([0.4 * 0.4 + 0.1 * 0.1])
    assert table["duration_s"].tolist() == pytest.approx([0.5])


def test_a_low_interval_ends_with_its_recording() -> None:
    frames = make_dataset(places=[Place([0, 1], fps=10), Place([0, 1], fps=5)]).frame_columns
    table = find_low_intervals(np.array([1, 0.4, 0.5, 1]), frames, low=0.9)
    assert table["recording"].tolist() == [0, 1]
    assert table["duration_s"].tolist() == pytest.approx([0.1, 0.2])
    assert table["worst_row"].tolist() == [1, 2]


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


def test_a_recording_of_one_frame_is_its_own_moving_mean() -> None:
    x = result_of(make_dataset([Box(5, 49, 0, 2, 9, 1)], frames=[5])).x
    assert x.similarity_window.tolist() == x.similarity.tolist() == pytest.approx([0.1])
    assert x.intervals["duration_s"].tolist() == [0.1]
