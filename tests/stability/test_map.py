"""Stability maps: a verdict turns where it must, and nothing is computed twice or in vain."""

from __future__ import annotations

from concurrent.futures import CancelledError, ThreadPoolExecutor
from typing import Any, get_args

import numpy as np
import pytest
from builders import Box, Place, at, make_dataset, result_of
from scenes import draw_scene

from nvcore.common.errors import InputError, ParameterError
from nvcore.comparison import compare as comparison
from nvcore.comparison.compare import Result, compare
from nvcore.comparison.scoring import system
from nvcore.evidence.stability import scores
from nvcore.evidence.stability.axes import Plane
from nvcore.evidence.stability.map import map_stability
from nvcore.evidence.stability.scores import Criterion
from nvcore.settings.params import Params

CRITERIA: tuple[Criterion, ...] = get_args(Criterion)


def turning() -> Result:
    """X - Y = 0.5 - 1.5 alpha.

    The pedestrian stands in the middle (50 of 100 px). X sees nobody: M = 1 - alpha. Y sees them
    and somebody at 25 px: M = 1 - (1 - alpha) * 25 / 50.
    """
    return result_of(make_dataset([at(0, 50)], [], [at(0, 50, score=0.9), at(0, 25, score=0.4)]))


def test_the_verdict_turns_where_the_means_cross() -> None:
    stability = map_stability(turning(), "alpha-midpoint", "similarity")
    assert [axis.name for axis in stability.axes] == ["alpha"]  # without proximity: no midpoint
    assert stability.difference == pytest.approx(0.5 - 1.5 * np.linspace(0, 1, 41))
    assert (stability.verdict, stability.share_held) == ("y", 1.0)
    (interval,) = stability.intervals
    assert (interval.low, interval.high) == (pytest.approx(0.35), 1.0)
    assert interval.flips_below == pytest.approx(1 / 3)
    assert interval.below == "x"
    assert np.isnan(interval.flips_above)
    overturn = stability.overturn
    assert overturn is not None
    assert overturn.settings == {"alpha": pytest.approx(1 / 3)}
    assert (overturn.winner, overturn.difference) == ("x", 0)
    assert overturn.distance == pytest.approx((0.9 - 1 / 3) / 0.5)  # plausible: 0.5 to 1
    assert not overturn.is_plausible


def tied() -> Result:
    """With alpha 1 even up to edge weight 0.5, then Y is better.

    X does not see a pedestrian at 10 px: D = 10 + 40 * edge weight. Y's box lies 30 px off, so D
    is the same, but 30 at most.
    """
    data = make_dataset([at(0, 10)], [], [at(0, 40)])
    return result_of(data, alpha=1.0)


def test_a_tie_holds_as_long_as_nobody_is_better() -> None:
    stability = map_stability(tied(), "edge-weight", "similarity")
    assert stability.winner.tolist() == ["even"] * 21 + ["y"] * 20
    assert stability.verdict == "even"
    # 0 stands for half a step, 0.5 for one: 20.5 of 40 steps
    assert stability.share_held == pytest.approx(20.5 / 40)
    assert stability.overturn == stability.end
    assert stability.overturn is not None
    assert stability.overturn.settings == {"edge_weight": pytest.approx(0.525)}
    assert stability.overturn.winner == "y"


def test_a_system_that_is_always_better_is_never_overturned() -> None:
    result = result_of(make_dataset([at(0, 50)], [at(0, 50)], []))
    stability = map_stability(result, "edge-weight", "similarity")
    assert set(stability.winner) == {"x"}
    assert (stability.share_held, stability.overturn, stability.end) == (1.0, None, None)


def test_a_tie_ends_a_verdict_without_overturning_it() -> None:
    # false alarms only, and Y has none: even at alpha 0
    result = result_of(make_dataset([at(0, 50)], [at(0, 50)], []))
    stability = map_stability(result, "alpha-midpoint", "similarity")
    assert stability.winner.tolist() == ["even"] + ["x"] * 40
    assert stability.overturn is None
    assert stability.end is not None
    assert (stability.end.settings, stability.end.winner) == ({"alpha": 0.0}, "even")


def pedestrians(scores: list[float]) -> list[Box]:
    """One box for each score, each in a frame of its own."""
    return [at(i, 50, score=score, track=i) for i, score in enumerate(scores)]


def test_encounters_by_threshold_are_counted_as_by_hand() -> None:
    # X keeps 4, 3, 2, 1 pedestrians at 0.2, 0.4, 0.6, 0.8; Y 4, 4, 4, 1
    x, y = [0.2, 0.4, 0.6, 0.8], [0.6, 0.6, 0.6, 0.8]
    alarms = [at(4, 50, score=0.2), at(4, 50, score=0.8)]
    data = make_dataset(
        pedestrians(x), [*pedestrians(x), *alarms], [*pedestrians(y), *alarms], n_frames=5
    )
    stability = map_stability(result_of(data), "thresholds", "encounters", n_points=4)
    for axis in stability.axes:
        assert axis.values.tolist() == [0.2, 0.4, 0.6, 0.8]  # the very scores, not a bit more
    n_x, n_y = np.array([4, 3, 2, 1]), np.array([4, 4, 4, 1])
    assert stability.difference.tolist() == (n_x[:, None] - n_y[None, :]).tolist()
    assert (stability.verdict, stability.present_indices) == ("even", [0, 0])


def test_a_system_without_scores_has_no_threshold_to_move() -> None:
    data = make_dataset([at(0, 50)], [at(0, 50, score=0.5), at(0, 20, score=0.7)], [at(0, 50)])
    stability = map_stability(result_of(data), "thresholds", "similarity", n_points=3)
    assert [axis.name for axis in stability.axes] == ["threshold_x"]
    with pytest.raises(InputError, match="neither system has scores that differ"):
        map_stability(result_of(make_dataset([at(0, 50)], [at(0, 50)], [])), "thresholds")


def test_the_share_is_that_of_random_plausible_settings() -> None:
    result = compare(draw_scene(44).dataset(), Params(midpoint=40.0))
    stability = map_stability(result, "alpha-midpoint", "similarity", n_points=9)
    rng = np.random.default_rng(1)
    drawn = [rng.uniform(*axis.plausible, 50_000) for axis in stability.axes]
    at_cell = tuple(
        np.abs(axis.values[:, None] - values).argmin(axis=0)
        for axis, values in zip(stability.axes, drawn, strict=True)
    )
    share = float((stability.winner[at_cell] == stability.verdict).mean())
    assert 0 < share < 1
    assert stability.share_held == pytest.approx(share, abs=0.01)


def test_recordings_of_different_height_have_no_single_midpoint() -> None:
    truth = [at(0, 50, recording=0), at(0, 50, recording=1)]
    places = [Place([0], height=100), Place([0], height=300)]
    data = make_dataset(truth, [truth[0]], [], places=places)
    stability = map_stability(compare(data, Params()), "alpha-midpoint", "similarity", n_points=11)
    assert stability.axes[1].present == (10, 30)
    assert stability.present_indices is None
    assert stability.intervals == ()
    assert stability.axes[1].distance(np.array([9.0, 10, 20, 30, 40])) == pytest.approx(
        [1 / 39, 0, 0, 0, 10 / 39]  # plausible: 6 to 45 px
    )
    assert stability.verdict == "x"  # from the comparison itself


@pytest.mark.parametrize("criterion", CRITERIA)
def test_without_frames_nothing_is_defined(criterion: Criterion) -> None:
    stability = map_stability(
        result_of(make_dataset(n_frames=0)), "edge-weight", criterion, n_points=3
    )
    assert np.isnan(stability.difference).all()
    assert set(stability.winner) == {"undefined"} == {stability.verdict}
    assert np.isnan(stability.share_held)
    assert stability.overturn is None
    assert stability.intervals == ()


def test_only_what_a_setting_changes_is_repeated(monkeypatch: pytest.MonkeyPatch) -> None:
    calls: list[str] = []
    for module, name in (
        (scores, "match_system"), (system, "match_system"), (system, "nearest_of"),
        (comparison, "weigh_proximity"), (system, "weigh_proximity"), (system, "measure_sets"),
    ):  # fmt: skip
        original = getattr(module, name)
        monkeypatch.setattr(
            module, name,
            lambda *a, _f=original, _n=name, **k: calls.append(_n) or _f(*a, **k),
        )  # fmt: skip
    truth = [at(i, 50, h=float(10 + i), track=i) for i in range(4)]
    x, y = ([box._replace(score=0.1 * box.frame + s) for box in truth] for s in (0.1, 0.5))
    result = compare(make_dataset(truth, x, y), Params(threshold_x=0.2))

    def counts(plane: Plane, criterion: Criterion) -> dict[str, int]:
        calls.clear()
        map_stability(result, plane, criterion, n_points=4)
        return {name: calls.count(name) for name in set(calls)}

    # 4 midpoints and the analysed one, for the truth once, for each system once
    assert counts("alpha-midpoint", "similarity") == {"weigh_proximity": 15, "measure_sets": 10}
    assert counts("alpha-midpoint", "encounters") == {"weigh_proximity": 5}
    assert counts("edge-weight-alpha", "similarity") == {"measure_sets": 8}
    assert counts("matching", "similarity") == {}  # no ignore region: the sets stay
    assert counts("matching", "encounters") == {"match_system": 2 * (4 + 1)}
    n_calls = counts("thresholds", "encounters")
    assert n_calls == {"match_system": 1}  # X is cut by its threshold; Y is matched in full already


def test_threads_give_the_same_map() -> None:
    result = compare(draw_scene(44).dataset(), Params())
    alone = map_stability(result, "thresholds", "saliency", n_points=9)
    with ThreadPoolExecutor(3) as pool:
        together = map_stability(result, "thresholds", "saliency", n_points=9, executor=pool)
    assert np.array_equal(alone.difference, together.difference, equal_nan=True)


def test_progress_goes_from_nothing_to_all() -> None:
    shares: list[float] = []
    map_stability(tied(), "edge-weight", n_points=7, progress=lambda share, _: shares.append(share))
    assert shares == [0, *(i / 7 for i in range(8))]


def test_a_cancelled_map_stops_between_steps(monkeypatch: pytest.MonkeyPatch) -> None:
    from nvcore.evidence.stability.map import score_setting as original

    started = []

    def score(*arguments: Any) -> Any:
        started.append(arguments[2])
        return original(*arguments)

    def progress(share: float, _what: str) -> None:
        if share > 0.04:  # two of 41 steps
            raise CancelledError

    monkeypatch.setattr("nvcore.evidence.stability.map.score_setting", score)
    with pytest.raises(CancelledError):
        map_stability(tied(), "edge-weight", progress=progress)
    assert len(started) == 2


def test_a_map_cancelled_beforehand_does_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    started: list[object] = []
    monkeypatch.setattr("nvcore.evidence.stability.map.match_fully", started.append)

    def progress(share: float, _what: str) -> None:
        assert share == 0
        raise CancelledError

    with pytest.raises(CancelledError):
        map_stability(tied(), "edge-weight", progress=progress)
    assert not started


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ({"plane": "alpha"}, "plane: expected one of alpha-midpoint"),
        ({"plane": "matching", "criterion": "f1"}, "criterion: expected one of similarity"),
        ({"plane": "edge-weight", "n_points": 2}, "n_points: expected at least 3, got 2"),
    ],
)
def test_a_map_that_does_not_exist_is_refused(arguments: dict[str, Any], words: str) -> None:
    with pytest.raises(ParameterError, match=words):
        map_stability(tied(), **arguments)
