from __future__ import annotations

from collections.abc import Iterable

import numpy as np
import pytest
from builders import NAN, Box, Place, at, make_dataset, result_of

from nvcore.comparison import Result
from nvcore.schema import DetectionState


def walk(
    hits: str,
    *,
    fps: float = 20,
    every: int = 1,
    h: Iterable[float] | None = None,
    **params: object,
) -> dict[str, object]:
    """How X did in an encounter whose n-th listed frame it matches where `hits` has a "+"."""
    heights = [50.0] * len(hits) if h is None else list(h)
    frames = [every * i for i in range(len(hits))]
    truth = [at(f, 50, h=height, track=1) for f, height in zip(frames, heights, strict=True)]
    x = [box._replace(track=-1) for box, hit in zip(truth, hits, strict=True) if hit == "+"]
    result = result_of(make_dataset(truth, x, frames=frames, fps=fps), **params)
    (row,) = result.x.encounters.to_dict("records")
    return row


def test_an_encounter_matched_throughout_is_detected_without_a_miss() -> None:
    row = walk("+" * 20)
    assert row == {
        "n_relevant": 20, "matched": 20, "peak_k": 1, "coverage": 1, "is_detected": True,
        "lag_s": 0, "gap_s": 0, "tail_s": 0, "miss_class": "none",
    }  # fmt: skip


def test_never_matched_is_never() -> None:
    row = walk("-----")
    assert row["miss_class"] == "never"
    assert not row["is_detected"]
    assert row["coverage"] == 0
    assert np.isnan([row["lag_s"], row["gap_s"], row["tail_s"]]).all()


@pytest.mark.parametrize(
    ("fps", "last_in_time"), [(20, 10), (30, 15), (7, 3), (25, 12), (10, 5), (8, 4), (29.97, 14)]
)
def test_a_lag_of_up_to_half_a_second_is_not_late(fps: float, last_in_time: int) -> None:
    in_time = walk("-" * last_in_time + "+" * 60, fps=fps)
    assert in_time["lag_s"] == pytest.approx(last_in_time / fps)
    assert in_time["miss_class"] == "none"
    late = walk("-" * (last_in_time + 1) + "+" * 60, fps=fps)
    assert late["miss_class"] == "late"
    assert late["is_detected"]


@pytest.mark.parametrize("fps", [7, 10, 20, 25, 29.97, 30])
@pytest.mark.parametrize("n", [1, 3, 7, 11, 13])
def test_a_figure_of_exactly_its_limit_does_not_exceed_it(fps: float, n: int) -> None:
    limit = n / fps
    hit, miss = "+" * 30, "-" * n
    assert walk(miss + hit, fps=fps, lag_s=limit)["miss_class"] == "none"
    assert walk(hit + miss + hit, fps=fps, gap_s=limit)["miss_class"] == "none"
    assert walk(hit + miss, fps=fps, gap_s=limit)["miss_class"] == "none"
    less = limit * (1 - 1e-9)
    assert walk(miss + hit, fps=fps, lag_s=less)["miss_class"] == "late"
    assert walk(hit + miss + hit, fps=fps, gap_s=less)["miss_class"] == "dropout"
    assert walk(hit + miss, fps=fps, gap_s=less)["miss_class"] == "lost_early"


def test_a_gap_between_two_matches_of_more_than_half_a_second_is_a_dropout() -> None:
    assert walk("+" * 9 + "-" * 10 + "+" * 9)["miss_class"] == "none"
    row = walk("+" * 9 + "-" * 11 + "+" * 9)
    assert row["miss_class"] == "dropout"
    assert row["gap_s"] == pytest.approx(0.55)
    assert row["tail_s"] == 0


def test_the_longest_gap_counts_not_their_sum() -> None:
    row = walk("+------+-------+++++++++++++")
    assert row["gap_s"] == pytest.approx(0.35)
    assert row["miss_class"] == "none"


def test_a_tail_of_more_than_half_a_second_is_lost_early() -> None:
    assert walk("+" * 20 + "-" * 10)["miss_class"] == "none"
    row = walk("+" * 20 + "-" * 11)
    assert row["miss_class"] == "lost_early"
    assert row["tail_s"] == pytest.approx(0.55)
    assert row["gap_s"] == 0


def test_brief_is_too_little_coverage_without_any_other_failure() -> None:
    row = walk("-+-+-" * 2)
    assert row["coverage"] == 0.4
    assert row["miss_class"] == "brief"
    assert not row["is_detected"]


def test_coverage_of_exactly_the_limit_is_detected() -> None:
    assert walk("+-+-")["is_detected"]
    assert walk("+-+-")["miss_class"] == "none"
    assert not walk("+-+-", coverage=0.51)["is_detected"]
    assert walk("+-" + "+-" * 2 + "----", coverage=0.3)["is_detected"]


def test_at_least_one_frame_must_be_matched_whatever_the_coverage() -> None:
    assert not walk("---", coverage=0)["is_detected"]
    assert walk("-+-", coverage=0)["is_detected"]


def test_the_first_class_that_holds_names_the_encounter() -> None:
    wait, hit = "-" * 11, "+"
    assert walk(wait + hit + wait + hit + wait)["miss_class"] == "late"
    assert walk(hit + wait + hit + wait)["miss_class"] == "dropout"
    assert walk(hit + wait)["miss_class"] == "lost_early"


def test_gaps_and_tails_go_by_time_steps_in_sampled_recordings() -> None:
    row = walk("+-+-", fps=20, every=4)
    assert row["gap_s"] == pytest.approx(0.2)
    assert row["tail_s"] == pytest.approx(0.2)
    assert walk("-+++", fps=20, every=4)["lag_s"] == pytest.approx(0.2)


def test_only_relevant_frames_count() -> None:
    heights = [9, 10, 11, 9, 11]  # the midpoint is 10 px
    row = walk("+-+-+", h=heights, proximity="height")
    assert (row["n_relevant"], row["matched"]) == (3, 2)
    assert row["lag_s"] == 0.05
    assert row["gap_s"] == 0  # the unmatched frame between is too far to count


def test_an_encounter_without_a_relevant_frame_is_distant() -> None:
    row = walk("+++", h=[9, 9, 9], proximity="height")
    assert row["miss_class"] is None
    assert row["n_relevant"] == 0
    assert not row["is_detected"]
    assert np.isnan(row["coverage"])  # type: ignore[call-overload]
    assert row["peak_k"] == pytest.approx(1 / (1 + np.exp(0.5)))


def test_the_peak_weight_is_that_of_the_nearest_frame() -> None:
    row = walk("+++", h=[10, 14, 8], proximity="height")
    assert row["peak_k"] == pytest.approx(1 / (1 + np.exp(-2)))


@pytest.mark.parametrize("heights", [[2], [50], [2, 50], []])
def test_the_table_has_the_same_dtypes_whatever_the_classes(heights: list[float]) -> None:
    truth = [at(0, 50, h=h, track=i) for i, h in enumerate(heights)]
    table = result_of(make_dataset(truth, n_frames=1), proximity="height").x.encounters
    assert table.dtypes.astype(str).tolist() == [
        "int64", "int64", "float64", "float64", "bool", "float64", "float64", "float64", "object",
    ]  # fmt: skip


def test_an_encounter_is_one_track_of_one_recording() -> None:
    truth = [at(0, 50, track=1, recording=r) for r in (0, 1)] + [at(0, 80, track=2)]
    result = result_of(make_dataset(truth, places=[Place([0]), Place([0])]))
    assert result.encounters.recording.tolist() == [0, 0, 1]
    assert result.encounters.track.tolist() == [1, 2, 1]


def test_ignored_boxes_belong_to_no_encounter() -> None:
    truth = [at(0, 50, track=1), at(1, 50, track=1, ignore=True), at(1, 80, track=2, ignore=True)]
    encounters = result_of(make_dataset(truth)).encounters
    assert encounters.track.tolist() == [1]
    assert encounters.n_frames.tolist() == [1]
    assert encounters.last_row.tolist() == [0]
    assert encounters.encounter_of.tolist() == [0, -1, -1]


def test_an_ignored_frame_is_not_relevant() -> None:
    truth = [at(f, 50, track=1, ignore=f == 1) for f in range(3)]
    result = result_of(make_dataset(truth, [at(0, 50), at(2, 50)]))
    assert result.x.encounters["coverage"].tolist() == [1]


def test_the_encounters_own_figures_by_hand() -> None:
    truth = [
        Box(0, 20, 0, 10, 20, 1, occlusion=0), Box(2, 70, 0, 10, 30, 1, occlusion=2),
        Box(3, 45, 0, 10, 40, 1), Box(0, 95, 0, 40, 40, 8),
    ]  # fmt: skip
    encounters = result_of(make_dataset(truth)).encounters
    assert encounters.first_row.tolist() == [0, 0]
    assert encounters.last_row.tolist() == [3, 0]
    assert encounters.n_frames.tolist() == [3, 1]
    assert encounters.lateral_offset.tolist() == pytest.approx([1 / 3, 1])
    assert encounters.lateral_position.tolist() == pytest.approx([0, 1])
    assert encounters.peak_height.tolist() == [40, 40]
    assert encounters.aspect_ratio.tolist() == [3, 1]
    assert encounters.aspect_z.tolist() == [1, -1]
    assert encounters.occluded_share.tolist() == pytest.approx([0.5, NAN], nan_ok=True)


def test_the_z_score_is_taken_over_all_encounters_of_the_comparison() -> None:
    truth = [Box(0, 10 * i, 0, 2, 2 * a, i, recording=i % 2) for i, a in enumerate([1, 2, 6])]
    places = [Place([0]), Place([0])]
    encounters = result_of(make_dataset(truth, places=places)).encounters
    aspect = encounters.aspect_ratio
    assert sorted(aspect) == [1, 2, 6]
    assert encounters.aspect_z == pytest.approx((aspect - 3) / np.std([1, 2, 6]))


@pytest.mark.parametrize("n", [1, 3])
def test_without_spread_there_is_no_z_score(n: int) -> None:
    truth = [Box(0, 20 * i, 0, 10, 20, i) for i in range(n)]
    assert np.isnan(result_of(make_dataset(truth)).encounters.aspect_z).all()


def test_equal_aspect_ratios_have_no_z_scores_whatever_their_rounding() -> None:
    truth = [Box(0, 10 * i, 10, 10, 7, track=i) for i in range(7)]
    assert np.isnan(result_of(make_dataset(truth)).encounters.aspect_z).all()


def test_tracks_may_be_huge_numbers_or_negative() -> None:
    ids = [2**62, -5, 2**31 - 1, 3]
    result = result_of(make_dataset([at(0, 20 * i, track=t) for i, t in enumerate(ids)]))
    assert result.encounters.track.tolist() == sorted(ids)


def test_huge_track_ids_beside_small_ones_stay_apart_in_their_recording() -> None:
    ids = [1, 2**32 + 1]  # equal in their lower 32 bits
    result = result_of(make_dataset([at(0, 20 * i, track=t) for i, t in enumerate(ids)]))
    assert result.encounters.track.tolist() == ids
    assert result.encounters.recording.tolist() == [0, 0]


def test_a_pedestrian_beyond_the_left_edge_is_at_the_edge() -> None:
    encounters = result_of(make_dataset([Box(0, -35, 0, 40, 40, 1)])).encounters
    assert encounters.lateral_position.tolist() == [-1]
    assert encounters.lateral_offset.tolist() == [1]


def test_a_track_given_twice_in_a_frame_is_one_frame_of_the_encounter() -> None:
    truth = [at(0, 50, track=1), at(0, 20, track=1), at(1, 50, track=1)]
    result = result_of(make_dataset(truth, [at(0, 20)]))
    assert result.encounters.n_frames.tolist() == [2]
    assert result.x.encounters[["n_relevant", "matched"]].to_numpy().tolist() == [[2, 1]]


def test_a_dataset_without_truth_has_no_encounters() -> None:
    result = result_of(make_dataset(x=[at(0, 50)]))
    assert len(result.encounters) == len(result.x.encounters) == 0
    assert set(result.venn.counts().values()) == {0}


def lead(first_x: int | None, first_y: int | None) -> float:
    truth = [at(f, 50, track=1) for f in range(20)]
    x, y = ([at(f, 50) for f in range(20 if n is None else n, 20)] for n in (first_x, first_y))
    result: Result = result_of(make_dataset(truth, x, y, fps=10))
    return float(result.lead_time_s[0])


def test_the_lead_of_x_is_the_lag_of_y_less_that_of_x() -> None:
    assert lead(2, 7) == pytest.approx(0.5)
    assert lead(7, 2) == pytest.approx(-0.5)


def test_there_is_no_lead_unless_both_match() -> None:
    assert np.isnan([lead(None, 2), lead(2, None), lead(None, None)]).all()


def test_matching_in_a_frame_that_is_not_relevant_does_not_detect() -> None:
    truth = [at(0, 50, h=9, track=1), at(1, 50, h=30, track=1)]
    result = result_of(make_dataset(truth, [at(0, 50, h=9)]), proximity="height")
    assert result.x.matches.state.tolist() == [DetectionState.MATCHED]
    assert result.x.encounters["miss_class"].tolist() == ["never"]
