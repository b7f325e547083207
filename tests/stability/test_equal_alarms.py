"""Thresholds with equally many false alarms, and who is better there."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from builders import at, make_dataset, result_of

from nvcore.comparison.compare import Result, compare
from nvcore.evidence.stability.map import N_RATES, equal_alarm_thresholds, map_stability
from nvcore.evidence.stability.notes import describe_stability
from nvcore.evidence.stability.scores import Criterion
from nvcore.settings.params import Params

N_FRAMES = 100


def scored(*, shift: float = 0.0, seed: int = 1, **params: float) -> Result:
    """100 frames with one pedestrian each; X and Y match half, with 60 false alarms each.

    Y's scores are X's way of scoring less `shift`: at the same threshold Y has fewer of anything.
    """
    rng = np.random.default_rng(seed)
    truth = [at(f, 50, track=f // 10) for f in range(N_FRAMES)]
    systems = []
    for less in (0.0, shift):
        hits = rng.choice(N_FRAMES, 50, replace=False)
        alarms = rng.choice(N_FRAMES, 60, replace=False)
        boxes = [
            at(int(frame), centre, score=float(score))
            for frames, centre in ((hits, 50), (alarms, 10))
            for frame, score in zip(frames, rng.random(len(frames)), strict=True)
        ]
        systems.append([box._replace(score=box.score - less) for box in boxes])
    return result_of(make_dataset(truth, *systems, n_frames=N_FRAMES), **params)


def alarms_at(result: Result, x: float, y: float) -> tuple[int, int]:
    there = compare(result.dataset, replace(result.params, threshold_x=x, threshold_y=y))
    return tuple(int(s.matches.is_false_alarm.sum()) for s in (there.x, there.y))  # type: ignore[return-value]


def test_both_systems_have_the_same_false_alarms_at_each_pair() -> None:
    result = scored(shift=3.0)
    pairs = equal_alarm_thresholds(result)
    assert 0 < len(pairs) <= N_RATES
    for rate, x, y in pairs.iloc[::6].itertuples(index=False):
        n_x, n_y = alarms_at(result, x, y)
        assert n_x == n_y == int(rate * N_FRAMES + 1e-6)
    assert pairs["alarms_per_frame"].max() <= 0.6  # neither has more than 60 in 100 frames


@pytest.mark.parametrize("criterion", ["similarity", "encounters", "saliency"])
def test_the_difference_along_the_line_is_the_comparison_there(criterion: Criterion) -> None:
    result = scored(threshold_x=0.5)
    line = map_stability(result, "thresholds", criterion, n_points=5).equal_alarms
    assert line is not None
    for i in range(0, len(line.difference), 9):
        params = replace(
            result.params, threshold_x=line.threshold_x[i], threshold_y=line.threshold_y[i]
        )
        there = compare(result.dataset, params)
        expected = {
            "similarity": there.x.summary.mean - there.y.summary.mean,
            "encounters": there.venn.x_only - there.venn.y_only,
            "saliency": there.y.saliency_s - there.x.saliency_s,
        }[criterion]
        assert line.difference[i] == pytest.approx(expected, abs=1e-12)


def test_a_system_that_scores_the_same_otherwise_is_even_along_the_line() -> None:
    # the same boxes, Y's scores 0.4 lower: most pairs of thresholds favour one, no fair pair does
    rng = np.random.default_rng(0)
    truth = [at(f, 50) for f in range(N_FRAMES)]
    x = [at(f, c, score=float(s)) for c in (50, 10) for f, s in enumerate(rng.random(N_FRAMES))]
    y = [box._replace(score=box.score - 0.4) for box in x]
    stability = map_stability(result_of(make_dataset(truth, x, y)), "thresholds", "similarity")
    assert stability.equal_alarms is not None
    assert stability.equal_alarms.share("even") == 1
    assert (stability.winner != "even").mean() > 0.8
    text = " ".join(describe_stability(stability))
    assert "per frame), X and Y have the same mean similarity in all of the threshold pairs" in text
    assert "including all pairs of a strict and a lax threshold" in text


def test_systems_that_never_have_as_many_false_alarms_have_no_line() -> None:
    # X: 2 or none in 100 frames, of one score; Y: 5 or none
    truth = [at(f, 50) for f in range(N_FRAMES)]
    x, y = (
        [at(0, 50, score=0.9), *(at(f, 10, score=0.5) for f in range(n))] for n in (2, 5)
    )  # fmt: skip
    result = result_of(make_dataset(truth, x, y, n_frames=N_FRAMES))
    assert equal_alarm_thresholds(result).empty
    stability = map_stability(result, "thresholds", "similarity", n_points=5)
    assert (
        "No confidence thresholds give X and Y equal false alarms. As analysed, X has 0.02 and Y"
        in (" ".join(describe_stability(stability)))
    )
    assert stability.equal_alarms is not None
    assert np.isnan(stability.equal_alarms.share("x"))


def test_without_scores_of_both_there_is_no_line() -> None:
    data = make_dataset([at(0, 50)], [at(0, 50, score=0.5), at(0, 9, score=0.2)], [at(0, 50)])
    result = compare(data, Params(proximity="none"))
    assert equal_alarm_thresholds(result).empty
    assert map_stability(result, "thresholds", "similarity").equal_alarms is None
    assert map_stability(result, "alpha-midpoint", "similarity").equal_alarms is None
