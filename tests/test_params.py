from __future__ import annotations

import dataclasses
import math

import pytest

from nvcore.errors import ParameterError
from nvcore.params import Params, params_from

FIELDS = dataclasses.fields(Params)
NUMBERS = [spec.name for spec in FIELDS if spec.metadata["choices"] is None]
CHOICES = [spec.name for spec in FIELDS if spec.metadata["choices"] is not None]
BOUNDED = [spec for spec in FIELDS if spec.name in NUMBERS and math.isfinite(spec.metadata["high"])]


def test_the_defaults_are_those_of_the_specification() -> None:
    assert dataclasses.asdict(Params()) == {
        "alpha": 0.9, "distance": "lateral", "edge_weight": 0.0, "proximity": "height",
        "midpoint": None, "spread": None, "midpoint_m": 35.0, "spread_m": 7.0, "horizon": None,
        "threshold_x": None, "threshold_y": None, "match": "iou", "iou": 0.5,
        "lateral_tolerance": 0.02, "coverage": 0.5, "lag_s": 0.5, "gap_s": 0.5, "low": 0.9,
        "window": 1.0, "tolerance": 0.05, "recency_midpoint": 0.5, "recency_spread": 0.1,
        "saliency_aggregate": "max", "saliency_scope": "recording",
    }  # fmt: skip


@pytest.mark.parametrize("spec", FIELDS, ids=lambda spec: spec.name)
def test_every_setting_has_a_help_text_of_whole_sentences(spec: dataclasses.Field[object]) -> None:
    assert spec.metadata["help"].endswith((".", "?"))


@pytest.mark.parametrize("spec", BOUNDED, ids=lambda spec: spec.name)
def test_both_ends_of_a_range_belong_to_it_unless_stated(spec: dataclasses.Field[object]) -> None:
    low, high = spec.metadata["low"], spec.metadata["high"]
    assert getattr(Params(**{spec.name: high}), spec.name) == high
    if spec.metadata["above_low"]:
        with pytest.raises(ParameterError, match=f"{spec.name}: expected more than {low:g}"):
            Params(**{spec.name: low})
    else:
        assert getattr(Params(**{spec.name: low}), spec.name) == low


@pytest.mark.parametrize("spec", BOUNDED, ids=lambda spec: spec.name)
def test_a_value_outside_its_range_is_refused_with_the_range(
    spec: dataclasses.Field[object],
) -> None:
    low, high = spec.metadata["low"], spec.metadata["high"]
    for value in (low - 0.001, high + 0.001):
        with pytest.raises(ParameterError, match=f"^{spec.name}: expected .* to {high:g}, got"):
            Params(**{spec.name: value})


@pytest.mark.parametrize("name", NUMBERS)
@pytest.mark.parametrize("value", [True, "0.5", math.nan, [0.5]])
def test_what_is_no_number_is_refused(name: str, value: object) -> None:
    with pytest.raises(ParameterError, match=f"{name}: expected a number, got"):
        Params(**{name: value})


@pytest.mark.parametrize("name", CHOICES)
def test_an_unknown_choice_is_refused_with_the_choices(name: str) -> None:
    with pytest.raises(ParameterError, match=f"{name}: expected one of .*, got 'sideways'"):
        Params(**{name: "sideways"})


@pytest.mark.parametrize("spec", FIELDS, ids=lambda spec: spec.name)
def test_none_is_allowed_where_it_is_the_default(spec: dataclasses.Field[object]) -> None:
    if spec.default is None:
        assert getattr(Params(**{spec.name: None}), spec.name) is None
    else:
        with pytest.raises(ParameterError, match=f"{spec.name}: expected"):
            Params(**{spec.name: None})


def test_a_threshold_may_be_any_number_because_scores_have_any_scale() -> None:
    assert Params(threshold_x=-0.85, threshold_y=8e6).threshold_y == 8e6


def test_given_leaves_out_what_is_none() -> None:
    given = Params(alpha=0.8, midpoint=60).given()
    assert given["alpha"] == 0.8
    assert given["midpoint"] == 60
    assert {"spread", "horizon", "threshold_x", "threshold_y"}.isdisjoint(given)


def test_given_makes_the_same_params_again() -> None:
    params = Params(alpha=0.8, distance="ground", threshold_x=0.5)
    assert params_from(params.given()) == params


def test_an_unknown_name_is_refused_with_the_known_ones() -> None:
    with pytest.raises(ParameterError, match=r"no parameter 'beta'; the parameters are alpha, "):
        params_from({"beta": 1})


def test_params_cannot_be_changed() -> None:
    with pytest.raises(dataclasses.FrozenInstanceError):
        Params().alpha = 0.5  # type: ignore[misc]
