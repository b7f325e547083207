from __future__ import annotations

import math

import numpy as np
import pytest
from builders import Box, Place, at, make_dataset, result_of

from nvcore.comparison.scoring import SystemResult
from nvcore.dataset import Dataset
from nvcore.metrics.saliency import EVENT_COLUMNS, recency_weight
from nvcore.settings.params import Params


def recency(tau: float) -> float:
    return 1 / (1 + math.exp(-(tau - 0.5) / 0.1))


def missed(
    frames: list[int], *, centre: float = 50, track: int = 1, seen: range = range(10)
) -> tuple[list[Box], list[Box]]:
    """One pedestrian, in the frames `seen`, detected in all of them but `frames`."""
    truth = [at(f, centre, track=track) for f in seen]
    return truth, [at(f, centre) for f in seen if f not in frames]


def score(
    frames: list[int], *, size: dict[str, float] | None = None, **params: object
) -> SystemResult:
    truth, x = missed(frames)
    return result_of(make_dataset(truth, x, **(size or {})), **params).x  # type: ignore[arg-type]


def test_an_event_by_hand() -> None:
    events = score([3, 4, 5]).events
    assert list(events) == list(EVENT_COLUMNS)
    (event,) = events.to_dict("records")
    assert (event["track"], event["first_row"], event["last_row"]) == (1, 3, 5)
    assert event["duration_s"] == pytest.approx(0.3)
    assert event["tau"] == pytest.approx(0.6)
    assert event["recency"] == pytest.approx(recency(0.6))
    assert event["saliency_s"] == pytest.approx(0.3 * recency(0.6))


def test_without_a_miss_there_is_no_event_and_no_saliency() -> None:
    x = score([])
    assert x.events.empty
    assert x.saliency_s == 0


def test_within_the_encounter_tau_counts_from_its_first_to_its_last_frame() -> None:
    truth, x = missed([4, 5], seen=range(4, 8))
    dataset = make_dataset(truth, x, n_frames=20)
    assert result_of(dataset).x.events["tau"].tolist() == [0.3]
    scoped = result_of(dataset, saliency_scope="encounter").x.events
    assert scoped["tau"].tolist() == [0.5]
    assert scoped["saliency_s"].tolist() == pytest.approx([0.2 * 0.5])


@pytest.mark.parametrize(("offset", "n_events"), [(2.5, 0), (2.6, 1)])
def test_a_distance_of_exactly_the_tolerance_is_no_miss(offset: float, n_events: int) -> None:
    dataset = make_dataset([at(0, 50, track=1)], [at(0, 50 + offset)])
    x = result_of(dataset).x
    assert x.distances.d_miss[0] == pytest.approx(offset)
    assert len(x.events) == n_events


def test_without_tolerance_any_distance_qualifies_but_none_does_not() -> None:
    noisy = make_dataset([at(0, 50, track=1)], [at(0, 50.25)])
    assert len(result_of(noisy, tolerance=0).x.events) == 1
    exact = make_dataset([at(0, 50, track=1)], [at(0, 50)])
    assert result_of(exact, tolerance=0).x.events.empty


def test_a_tie_goes_to_the_nearer_pedestrian() -> None:
    # 20 px x k = 1/2 and 10 px x k = 1
    truth = [at(0, 20, h=50, track=1), at(0, 90, h=1000, foot=1000, track=2)]
    x = result_of(make_dataset(truth), proximity="height", midpoint=50, spread=1e-3).x
    assert x.distances.d_miss[0] == 10
    assert x.events["track"].tolist() == [2]


def test_a_tie_of_equally_near_pedestrians_goes_to_the_smaller_track() -> None:
    truth = [at(0, 70, track=5), at(0, 30, track=3), at(0, 70, track=4)]
    assert result_of(make_dataset(truth)).x.events["track"].tolist() == [3]


def test_recency_is_half_at_its_midpoint_and_cannot_overflow() -> None:
    params = Params(recency_midpoint=0.3, recency_spread=1e-9)
    tau = np.array([0.0, 0.3, 1.0])
    assert recency_weight(tau, np.full(3, np.nan), params).tolist() == [0, 0.5, 1]
    params = Params(recency_unit="seconds", recency_midpoint_s=4, recency_spread_s=1e-9)
    rest_s = np.array([9.0, 4.0, 0.0])
    assert recency_weight(np.full(3, np.nan), rest_s, params).tolist() == [0, 0.5, 1]


def side_by_side(missed_by_x: set[int]) -> Dataset:
    """Two people 20 px apart who take turns at being the more central; 40 frames."""
    truth, x = [], []
    for f in range(40):
        sway = 6 if f % 2 else -6
        for track, centre in ((1, 40 + sway), (2, 60 + sway)):
            truth.append(at(f, centre, track=track))
            if track not in missed_by_x:
                x.append(at(f, centre))
    return make_dataset(truth, x)


def test_two_people_missed_side_by_side_cut_each_others_events_by_the_papers_rule() -> None:
    both, first = (result_of(side_by_side(missed)).x for missed in ({1, 2}, {1}))
    assert both.events["duration_s"].max() == pytest.approx(0.1)
    assert first.events["duration_s"].tolist() == pytest.approx([4.0])
    assert both.saliency_s < first.saliency_s


def test_of_each_pedestrian_a_second_miss_never_lowers_saliency() -> None:
    saliency_s = [
        result_of(side_by_side(missed), saliency_of="each", saliency_aggregate="sum").x.saliency_s
        for missed in (set(), {1}, {1, 2})
    ]
    assert saliency_s == sorted(saliency_s)
    assert saliency_s[2] == pytest.approx(2 * saliency_s[1])


def test_by_risk_an_event_weighs_its_distance_over_time() -> None:
    dataset = make_dataset(*missed([3, 4, 5], centre=25))  # half way to the edge
    (event,) = result_of(dataset, saliency_weight="risk").x.events.to_dict("records")
    assert event["duration_s"] == pytest.approx(0.3)
    assert event["weight_s"] == pytest.approx(0.5 * 0.3)
    assert event["saliency_s"] == pytest.approx(0.15 * recency(0.6))


def test_in_seconds_the_end_of_a_long_recording_counts_as_that_of_a_short_one() -> None:
    saliency_s = []
    for n_frames in (100, 1000):
        truth, x = missed([n_frames - 20], seen=range(n_frames))
        dataset = make_dataset(truth, x)
        saliency_s.append(result_of(dataset, recency_unit="seconds").x.saliency_s)
    assert saliency_s[0] == pytest.approx(saliency_s[1])
    assert saliency_s[0] == pytest.approx(0.1 / (1 + math.exp((1.9 - 7.5) / 1.5)))


def test_the_headline_is_the_mean_over_recordings() -> None:
    places = [Place(range(10)), Place(range(10))]
    truth = [at(f, 50, track=1, recording=r) for r in (0, 1) for f in range(10)]
    x = [box for box in truth if box.recording or box.frame not in (3, 4, 5)]
    result = result_of(make_dataset(truth, x, places=places))
    of_first = 0.3 * recency(0.6)
    assert result.saliency_of_recordings(result.x).tolist() == pytest.approx([of_first, 0])
    assert result.x.saliency_s == pytest.approx(of_first / 2)


def test_time_in_which_the_pedestrian_counts_is_told_apart() -> None:
    truth = [at(f, 50, h=60 if f >= 4 else 4, track=1) for f in range(10)]
    x = result_of(make_dataset(truth), proximity="height", tolerance=0).x
    assert x.events["duration_s"].tolist() == pytest.approx([1.0])
    assert x.events["relevant_s"].tolist() == pytest.approx([0.6])
