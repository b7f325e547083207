"""Which settings a stability map tries, and which of them count as plausible."""

from __future__ import annotations

import numpy as np
import pytest
from builders import Place, at, make_dataset, result_of

from nvcore.comparison.compare import compare
from nvcore.evidence.stability.axes import Axis, axes_of
from nvcore.settings.params import Params
from nvcore.settings.params.presets import PRESETS


def midpoint_axis(heights: list[float], **params: object) -> Axis:
    truth = [at(0, 10 + i, h=h, distance_m=h) for i, h in enumerate(heights)]
    result = compare(make_dataset(truth, [], [], height=480.0, horizon=60.0), Params(**params))
    return axes_of(result, "alpha-midpoint", n_points=5)[1]


def test_midpoints_are_plausible_from_the_rural_to_the_urban_preset() -> None:
    axis = midpoint_axis([10, 400])
    assert axis.plausible == (pytest.approx(0.06 * 480), pytest.approx(0.15 * 480))
    assert (axis.values[0], axis.values[-1]) == (pytest.approx(9.6), pytest.approx(120))
    assert axis.present == (48, 48)
    assert (axis.name, axis.unit) == ("midpoint", "px")
    assert axis.is_plausible(np.array(axis.present)).all()
    assert axis.reason.startswith("6 to 15 % of the picture's height, from the preset")
    for beyond in (20.0, 80.0):
        assert not midpoint_axis([50], midpoint=beyond).is_plausible(beyond)


def test_of_pictures_of_different_height_every_default_and_every_preset_is_plausible() -> None:
    places = [Place([0], height=480), Place([0], height=576), Place([0], height=120)]
    result = compare(make_dataset([at(0, 50, h=90)], places=places), Params())
    axis = axes_of(result, "alpha-midpoint", n_points=5)[1]
    assert axis.plausible == (pytest.approx(0.06 * 120), pytest.approx(0.15 * 576))
    assert axis.is_plausible(np.array(axis.present)).all()
    assert "6 % of the lowest picture's height to 15 % of the tallest's" in axis.reason
    assert axis.is_plausible(0.1 * np.array([120, 480, 576])).all()
    assert axis.is_plausible([preset.midpoint_share * 576 for preset in PRESETS]).all()


@pytest.mark.parametrize("share", [0.06, 0.15])
def test_a_preset_is_plausible_however_its_midpoint_is_rounded(share: float) -> None:
    result = compare(make_dataset([], height=370.0), Params(midpoint=round(share * 370, 6)))
    axis = axes_of(result, "alpha-midpoint", n_points=5)[1]
    assert axis.is_plausible(np.array(axis.present)).all()


def test_by_distance_the_midpoint_is_in_metres() -> None:
    axis = midpoint_axis([5, 30, 90], proximity="distance", midpoint_m=130.0)
    assert (axis.name, axis.unit, axis.plausible) == ("midpoint_m", "m", (22, 56))
    assert (axis.values[0], axis.values[-1]) == (10, 130)  # out to the analysed one


def test_thresholds_are_plausible_from_1_to_a_hundredth_false_alarm_per_frame() -> None:
    # 200 frames; 250 false alarms of scores 0.001 ... 0.250: 200 pass 0.051, 2 pass 0.249
    alarms = [at(i % 200, 50, score=(i + 1) / 1000) for i in range(250)]
    data = make_dataset([], alarms, [at(0, 50, score=0.1), at(1, 50, score=0.3)], n_frames=200)
    axis_x, axis_y = axes_of(result_of(data), "thresholds", n_points=11)
    step = 0.25 / 199  # the curve has 200 points
    assert axis_x.plausible == (pytest.approx(0.051, abs=step), pytest.approx(0.249, abs=step))
    assert axis_x.present == (0.001, 0.001)  # without a threshold: the lowest score
    assert axis_x.values[0] == 0.001
    # Y: one false alarm in 200 frames is fewer than a hundredth at the higher score
    assert axis_y.plausible == (0.1, 0.3)
    assert "no range of them" in axis_y.reason


def test_an_infinite_threshold_lies_just_above_the_highest_score() -> None:
    data = make_dataset([], [at(0, 50, score=0.1), at(1, 50, score=0.3)], [at(0, 50)])
    above, below = (
        axes_of(result_of(data, threshold_x=limit), "thresholds", n_points=5)[0]
        for limit in (np.inf, -np.inf)
    )
    assert above.present[0] == np.nextafter(0.3, 1)
    assert below.present[0] == 0.1


def test_weights_are_what_lies_nearest_within_the_plausible_range() -> None:
    values = np.array([0.0, 0.4, 0.6, 1.0])
    axis = Axis("alpha", "alpha", "", values, (0.5, 1.0), "", (0.6, 0.6), "Alpha")
    assert axis.weights.tolist() == pytest.approx([0, 0, 0.6, 0.4])  # 0.5 .. 0.8 .. 1
    assert axis.distance(values).tolist() == pytest.approx([1.2, 0.4, 0, 0.8])
    assert axis.present_index == 2


def test_another_choice_is_a_whole_range_away() -> None:
    result = result_of(make_dataset([at(0, 50)], [], []), match="lateral")
    axis = axes_of(result, "matching", n_points=5)[1]
    assert [axis.setting_at(i) for i in range(2)] == ["iou", "lateral"]
    assert axis.distance(axis.values).tolist() == [1, 0]
    assert axis.weights.tolist() == [0.5, 0.5]
    assert axis.text(1.0) == "matching by sideways position"


@pytest.mark.parametrize("n_points", [3, 4, 7, 41])
def test_the_analysed_value_and_the_ends_of_the_plausible_range_are_points(n_points: int) -> None:
    data = make_dataset([at(0, 50)], [at(0, 50, score=0.2), at(0, 5, score=0.9)], [at(0, 50)])
    params = Params(alpha=0.123, midpoint=9.3, iou=0.51, edge_weight=0.77, threshold_x=0.333)
    result = compare(data, params)
    for plane in ("alpha-midpoint", "matching", "edge-weight-alpha", "thresholds", "pairing-alpha"):
        for axis in axes_of(result, plane, n_points=n_points):
            assert axis.setting_at(axis.values[axis.present_index]) == getattr(params, axis.name)
            assert set(axis.plausible) <= set(axis.values)
            assert np.all(np.diff(axis.values) > 0)
            assert not axis.values.flags.writeable
            outside = ~axis.is_plausible(axis.values)
            assert axis.weights[outside].sum() == 0
            assert (axis.weights[~outside] > 0).all()


def test_without_a_value_the_traffic_context_is_that_of_the_recordings() -> None:
    places = [Place(range(1), context=0.25), Place(range(1), context=0.75)]
    result = result_of(make_dataset([at(0, 50)], places=places))
    axis = axes_of(result, "edge-weight", n_points=5)[0]
    assert axis.present == (0.25, 0.75)
    assert axis.present_index is None
    given = axes_of(result_of(result.dataset, edge_weight=0.25), "edge-weight", n_points=5)[0]
    assert given.values[given.present_index] == 0.25


def test_the_rules_of_saliency_are_two_choices_and_pairing_is_one() -> None:
    result = result_of(make_dataset([at(0, 50)]), saliency_of="each", pairing="matched")
    weight, whose = axes_of(result, "saliency-rule", n_points=5)
    assert (weight.labels, whose.labels) == (("time", "risk"), ("most_salient", "each"))
    assert (weight.present_index, whose.present_index) == (0, 1)
    assert whose.text(1.0) == "events of each missed pedestrian"
    alpha, pairing = axes_of(result, "pairing-alpha", n_points=5)
    assert (alpha.name, pairing.name, pairing.present_index) == ("alpha", "pairing", 1)
    assert pairing.text(1.0) == "distances to its own match (strict)"
