from __future__ import annotations

from collections.abc import Iterable

import numpy as np
import pytest
from builders import NAN, Box, Place, at, make_dataset, result_of

from nvcore.comparison.compare import Result


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
    assert walk("+" * 20) == {
        "n_relevant": 20, "matched": 20, "peak_k": 1, "coverage": 1, "is_detected": True,
        "lag_s": 0, "gap_s": 0, "tail_s": 0, "miss_class": "none",
    }  # fmt: skip


def test_an_encounter_without_a_relevant_frame_is_distant() -> None:
    row = walk("+++", h=[9, 9, 9], proximity="height")  # the midpoint is 10 px
    assert (row["miss_class"], row["n_relevant"], row["is_detected"]) == (None, 0, False)
    assert np.isnan(row["coverage"])  # type: ignore[call-overload]
    assert row["peak_k"] == pytest.approx(1 / (1 + np.exp(0.5)))


MISS, HIT = "-" * 11, "+" * 12  # at 20 Hz: 0.55 s and 0.6 s


@pytest.mark.parametrize(
    ("hits", "kind", "lag_s", "gap_s", "tail_s"),
    [
        ("-----", "never", NAN, NAN, NAN),
        (MISS + HIT + MISS + HIT + MISS, "late", 0.55, 0.55, 0.55),
        (HIT + MISS + HIT + MISS, "dropout", 0, 0.55, 0.55),
        (HIT + MISS, "lost_early", 0, 0, 0.55),
        ("-+-+-" * 2, "brief", 0.05, 0.1, 0.05),
        ("+-+-", "none", 0, 0.05, 0.05),
        ("+------+-------" + HIT, "none", 0, 0.35, 0),  # the longest gap, not their sum
    ],
)
def test_the_first_class_that_holds_names_the_encounter(
    hits: str, kind: str, lag_s: float, gap_s: float, tail_s: float
) -> None:
    row = walk(hits)
    figures = [row[name] for name in ("coverage", "lag_s", "gap_s", "tail_s")]
    expected = [hits.count("+") / len(hits), lag_s, gap_s, tail_s]
    assert figures == pytest.approx(expected, nan_ok=True)
    assert row["miss_class"] == kind
    assert row["is_detected"] == (expected[0] >= 0.5)


def test_at_least_one_frame_must_be_matched_whatever_the_coverage() -> None:
    assert not walk("---", coverage=0)["is_detected"]
    assert walk("-+-", coverage=0)["is_detected"]


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


@pytest.mark.parametrize("heights", [[2], [50], [2, 50], []])
def test_the_table_has_the_same_dtypes_whatever_the_classes(heights: list[float]) -> None:
    truth = [at(0, 50, h=h, track=i) for i, h in enumerate(heights)]
    table = result_of(make_dataset(truth, n_frames=1), proximity="height").x.encounters
    assert table.dtypes.astype(str).tolist() == [
        "int64", "int64", "float64", "float64", "bool", "float64", "float64", "float64", "object",
    ]  # fmt: skip


def test_ignored_boxes_belong_to_no_encounter() -> None:
    truth = [at(0, 50, track=1), at(1, 50, track=1, ignore=True), at(1, 80, track=2, ignore=True)]
    encounters = result_of(make_dataset(truth)).encounters
    assert encounters.track.tolist() == [1]
    assert encounters.n_frames.tolist() == [1]
    assert encounters.last_row.tolist() == [0]
    assert encounters.encounter_of.tolist() == [0, -1, -1]


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


@pytest.mark.parametrize(("n", "h"), [(1, 20), (3, 20), (7, 7)])  # 7 / 10: spread by rounding
def test_without_spread_there_is_no_z_score(n: int, h: float) -> None:
    truth = [Box(0, 10 * i, 10, 10, h, track=i) for i in range(n)]
    assert np.isnan(result_of(make_dataset(truth)).encounters.aspect_z).all()


@pytest.mark.parametrize(
    "ids",
    [[2**62, -5, 2**31 - 1, 3], [1, 2**32 + 1]],  # the last two are equal in their lower 32 bits
)
def test_tracks_may_be_huge_numbers_or_negative(ids: list[int]) -> None:
    result = result_of(make_dataset([at(0, 20 * i, track=t) for i, t in enumerate(ids)]))
    assert result.encounters.track.tolist() == sorted(ids)
    assert set(result.encounters.recording) == {0}


def test_a_pedestrian_beyond_the_left_edge_is_at_the_edge() -> None:
    encounters = result_of(make_dataset([Box(0, -35, 0, 40, 40, 1)])).encounters
    assert encounters.lateral_position.tolist() == [-1]
    assert encounters.lateral_offset.tolist() == [1]


def test_a_track_given_twice_in_a_frame_is_one_frame_of_the_encounter() -> None:
    truth = [at(0, 50, track=1), at(0, 20, track=1), at(1, 50, track=1)]
    result = result_of(make_dataset(truth, [at(0, 20)]))
    assert result.encounters.n_frames.tolist() == [2]
    assert result.x.encounters[["n_relevant", "matched"]].to_numpy().tolist() == [[2, 1]]


def lead(first_x: int | None, first_y: int | None) -> float:
    truth = [at(f, 50, track=1) for f in range(20)]
    x, y = ([at(f, 50) for f in range(20 if n is None else n, 20)] for n in (first_x, first_y))
    result: Result = result_of(make_dataset(truth, x, y, fps=10))
    return float(result.lead_time_s[0])


def test_the_lead_of_x_is_the_lag_of_y_less_that_of_x() -> None:
    assert lead(2, 7) == pytest.approx(0.5)
    assert lead(7, 2) == pytest.approx(-0.5)
    assert np.isnan([lead(None, 2), lead(2, None), lead(None, None)]).all()
