"""Parameters, what they refuse, and named settings for usual traffic."""

from __future__ import annotations

import dataclasses
import math
import typing
from dataclasses import asdict

import pytest
from hypothesis import given
from hypothesis import strategies as st
from other_params import OTHER

from nvcore.common.errors import ParameterError
from nvcore.settings.objects import PEDESTRIAN, SPEED_SIGN
from nvcore.settings.params import SETTINGS, Params, params_from, settings_for
from nvcore.settings.params.presets import PRESETS, presets_for
from nvcore.settings.stages import EVENTS, MATCH, SALIENCY, Setting

NUMBERS = [name for name, setting in SETTINGS.items() if setting.words is None]
CHOICES = [name for name, setting in SETTINGS.items() if setting.words is not None]
BESIDE = {"confirm_n": {"confirm_m": 100}, "confirm_m": {"confirm_n": 1}}
"""What the ends of a range need beside them."""
BOUNDED = [name for name in NUMBERS if math.isfinite(SETTINGS[name].high)]


@pytest.mark.parametrize("setting", SETTINGS.values(), ids=list(SETTINGS))
def test_every_setting_is_explained_in_whole_sentences(setting: Setting) -> None:
    assert setting.label
    assert setting.meaning.endswith((".", "?"))


@pytest.mark.parametrize("name", CHOICES)
def test_the_choices_are_those_of_the_type(name: str) -> None:
    kind = typing.get_type_hints(Params)[name]
    assert tuple(SETTINGS[name].words or ()) == typing.get_args(kind)


@pytest.mark.parametrize("name", [name for name in SETTINGS if SETTINGS[name].height_share])
def test_a_share_of_the_height_is_the_one_that_is_explained(name: str) -> None:
    share = SETTINGS[name].height_share
    assert share is not None
    assert f"{100 * share:g} % of the image height" in SETTINGS[name].meaning


def test_a_stage_depends_on_its_own_settings_and_those_of_all_before() -> None:
    assert settings_for(MATCH) == ("match", "iou", "lateral_tolerance", "match_class")
    assert set(settings_for(SALIENCY)) == set(settings_for(EVENTS)) | {"saliency_aggregate"}
    assert {"distance", "edge_weight", "iou", "midpoint"} < set(settings_for(SALIENCY))
    assert {"alpha", "coverage"}.isdisjoint(settings_for(SALIENCY))


@given(st.sets(st.sampled_from(sorted(OTHER))))
def test_settings_for_a_stage_are_kept_and_all_others_are_the_defaults(names: set[str]) -> None:
    params = Params(**{name: OTHER[name] for name in names})
    for stage in {setting.stage for setting in SETTINGS.values()}:
        own = {name: OTHER[name] for name in names if name in settings_for(stage)}
        assert params.only_for(stage) == Params(**own)
        assert params.only_for(stage).values_for(stage) == params.values_for(stage)


@pytest.mark.parametrize("name", BOUNDED)
def test_both_ends_of_a_range_belong_to_it_unless_stated(name: str) -> None:
    low, high, beside = SETTINGS[name].low, SETTINGS[name].high, BESIDE.get(name, {})
    assert getattr(Params(**{name: high, **beside}), name) == high
    if SETTINGS[name].is_above_low:
        with pytest.raises(ParameterError, match=f"{name}: expected more than {low:g}"):
            Params(**{name: low})
    else:
        assert getattr(Params(**{name: low, **beside}), name) == low


@pytest.mark.parametrize("name", BOUNDED)
def test_a_value_outside_its_range_is_refused_with_the_range(name: str) -> None:
    low, high = SETTINGS[name].low, SETTINGS[name].high
    for value in (low - 0.001, high + 0.001):
        with pytest.raises(ParameterError, match=f"^{name}: expected .* to {high:g}, got"):
            Params(**{name: value})


@pytest.mark.parametrize("name", NUMBERS)
@pytest.mark.parametrize("value", [True, "0.5", math.nan, [0.5]])
def test_what_is_no_number_is_refused(name: str, value: object) -> None:
    with pytest.raises(ParameterError, match=f"{name}: expected a number, got"):
        Params(**{name: value})


@pytest.mark.parametrize("name", CHOICES)
def test_an_unknown_choice_is_refused_with_the_choices(name: str) -> None:
    with pytest.raises(ParameterError, match=f"{name}: expected one of .*, got 'sideways'"):
        Params(**{name: "sideways"})


@pytest.mark.parametrize("name", SETTINGS)
def test_none_is_allowed_where_it_is_the_default(name: str) -> None:
    if SETTINGS[name].default is None:
        assert getattr(Params(**{name: None}), name) is None
    else:
        with pytest.raises(ParameterError, match=f"{name}: expected"):
            Params(**{name: None})


def test_a_threshold_may_be_any_number_because_scores_have_any_scale() -> None:
    assert Params(threshold_x=-0.85, threshold_y=8e6).threshold_y == 8e6


def test_more_frames_than_are_looked_at_can_never_confirm() -> None:
    assert Params(confirm_n=4, confirm_m=4).confirm_n == 4
    with pytest.raises(ParameterError, match=r"confirm_n: expected at most confirm_m, which is 4"):
        Params(confirm_n=5, confirm_m=4)


def test_settings_that_another_choice_leaves_without_effect_are_named() -> None:
    assert Params().without_effect == ()
    assert Params(missing_distance="borrow").without_effect == ("missing_distance",)
    assert Params(missing_distance="borrow", proximity="distance").without_effect == ()
    assert Params(midpoint=40, proximity="distance").without_effect == ("midpoint",)


def test_given_leaves_out_what_is_none() -> None:
    given = Params(alpha=0.8, midpoint=60).given()
    assert given["alpha"] == 0.8
    assert given["midpoint"] == 60
    assert {"spread", "horizon", "threshold_x", "threshold_y"}.isdisjoint(given)


def test_given_makes_the_same_params_again() -> None:
    params = Params(alpha=0.8, distance="ground", threshold_x=0.5)
    assert params_from(params.given()) == params


def test_an_unknown_name_is_refused_with_the_known_ones() -> None:
    with pytest.raises(
        ParameterError, match=r"no parameter 'beta'; the parameters are alert_corridor, "
    ):
        params_from({"beta": 1})


def test_params_cannot_be_changed() -> None:
    with pytest.raises(dataclasses.FrozenInstanceError):
        Params().alpha = 0.5  # type: ignore[misc]


@pytest.mark.parametrize("preset", PRESETS, ids=lambda preset: preset.name)
@pytest.mark.parametrize("height", [None, 480.0])
def test_a_preset_makes_valid_parameters(preset, height):
    values = preset.values(height)
    assert asdict(Params(**values)).items() >= values.items()


def test_the_first_preset_is_the_default():
    assert PRESETS[0].name == "Default"
    assert Params(**PRESETS[0].values(480.0)) == Params()


def test_rural_counts_misses_at_the_edge_and_far_off():
    values = PRESETS[2].values(500.0)
    assert (values["edge_weight"], values["midpoint"]) == (1.0, 30.0)


def test_without_a_height_the_sigmoid_is_that_of_each_recording():
    assert PRESETS[2].values(None)["midpoint"] is None


def test_the_presets_for_towns_and_rural_roads_set_the_context_for_all_recordings():
    presets = presets_for(PEDESTRIAN)
    assert [preset.values(480.0)["edge_weight"] for preset in presets] == [None, 0.0, 1.0]
    assert all(preset.values(480.0)["coverage"] == Params().coverage for preset in presets)


def test_speed_signs_have_a_preset_of_their_own():
    (own,) = set(presets_for(SPEED_SIGN)) - set(presets_for(PEDESTRIAN))
    values = own.values(480.0)
    # seen in one of five frames, from 20 px on in a picture 480 px high
    assert (values["coverage"], values["midpoint"], values["spread"]) == (0.2, 20.0, 4.0)


def test_a_setting_is_used_only_with_possible_values_of_another():
    for setting in SETTINGS.values():
        if setting.used_with is not None:
            name, values = setting.used_with
            assert set(values) < set(SETTINGS[name].words or ())


@pytest.mark.parametrize(
    ("name", "results"),
    [
        ("alpha", "similarity, low similarity"),
        ("low", "low similarity"),
        ("edge_weight", "similarity, low similarity, severity, saliency"),
        ("lag_s", "encounters"),
        ("saliency_aggregate", "saliency"),
        (
            "threshold_x",
            "matches and false alarms, similarity, low similarity, encounters, severity, saliency, "
            "time left, alerts",
        ),
    ],
)
def test_a_setting_says_which_results_it_acts_on(name: str, results: str) -> None:
    assert SETTINGS[name].acts_on == results


def test_a_setting_moves_what_comes_after_it() -> None:
    assert SETTINGS["threshold_x"].moves([MATCH])
    assert not SETTINGS["edge_weight"].moves([MATCH])
    assert SETTINGS["edge_weight"].moves([MATCH, SALIENCY])
    assert not SETTINGS["alpha"].moves([])
