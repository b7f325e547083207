"""Settings: possible values only, and the same again from JSON."""

from __future__ import annotations

import json
from dataclasses import fields, replace
from typing import get_args, get_type_hints

import pytest

from nvcore.common.errors import ParameterError
from nvcore.subjects.detectors.icf import AS_IN_REPORT, PEDESTRIANS, SIGNS, IcfSettings
from nvcore.subjects.detectors.settings import facts_of


@pytest.mark.parametrize("settings", [IcfSettings(), AS_IN_REPORT, SIGNS, PEDESTRIANS])
def test_settings_come_back_from_json(settings):
    assert IcfSettings.from_json(json.loads(json.dumps(settings.as_json()))) == settings


def test_the_preset_is_what_the_report_says():
    report = AS_IN_REPORT
    assert report.channels == ("luv", "magnitude", "orientations")
    assert (report.window_width, report.window_height, report.stride) == (64, 64, 6)
    assert report.scales == (1.0, 1.1, 1.2, 1.3, 1.4, 1.5, 1.6, 1.7)
    assert (report.blur, report.clahe_clip, report.least_area) == (True, 4.0, 25)
    assert report.trees_per_round == (125, 250, 500, 1000)
    assert report.negatives_per_round == 0
    assert (report.cascade, report.rejection, report.overlap) == ("constant", -1.0, 0.5)


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"channels": ()}, "channels: expected some of"),
        ({"channels": ("lab",)}, "channels: expected some of"),
        ({"channels": ("luv", "luv")}, "each once"),
        ({"channels": "luv"}, "some of grey, rgb"),
        ({"cascade": "soft"}, "constant, calibrated, hard, none"),
        ({"blur": 1}, "blur"),
        ({"stride": 0}, "stride: expected 1 to 256, got 0"),
        ({"stride": 2.5}, "whole number"),
        ({"stride": True}, "stride: expected a whole number"),
        ({"stride": (6,)}, r"stride: expected a whole number, found \(6,"),
        ({"features": float("nan")}, "features: expected a whole number"),
        ({"object_width": (52.0,)}, r"object_width: expected a number, found \(52"),
        ({"overlap": 10**400}, "overlap: expected a number, found 1000"),
        ({"negatives": 10**400}, "negatives: expected 1 to 1e"),
        ({"kept_share": float("inf")}, "kept_share: expected 0.5 to 1, got inf"),
        ({"magnitude": ("sum",)}, "magnitude: expected one of euclidean, sum"),
        ({"patience": "3"}, "patience: expected a whole number"),
        ({"scales": ((1.0,),)}, "scales: expected a list of numbers"),
        ({"object_width": 65.0}, "must fit into the window"),
        ({"least_area": 5000}, "fits into the window"),
        ({"scales": (1.2, 1.1)}, "ascending"),
        ({"scales": ()}, "scales"),
        ({"scales": (0.0,)}, "scales: expected 0.05 to 50"),
        ({"trees_per_round": ()}, "rounds"),
        ({"patience": 0}, "patience"),
        ({"region": (0.0, 0.0, 1.0, 1.0)}, "three corners"),
        ({"region": (0.0, 0.0, 1.0, 1.0, 2.0, 0.0)}, "region: expected 0 to 1"),
    ],
)
def test_an_impossible_value_is_refused(changes, words):
    with pytest.raises(ParameterError, match=words):
        IcfSettings(**changes)


def test_every_setting_has_a_meaning_and_its_choices_are_those_of_its_type():
    kinds = get_type_hints(IcfSettings)
    for spec in fields(IcfSettings):
        facts = facts_of(spec)
        assert facts.meaning.endswith(".")
        if facts.choices:
            assert tuple(facts.choices) == get_args(kinds[spec.name])


def test_missing_and_unknown_settings_are_named():
    values = {**SIGNS.as_json(), "colour": 1}
    del values["stride"]
    with pytest.raises(ParameterError, match="colour, stride"):
        IcfSettings.from_json(values)


def test_settings_are_told_in_plain_values():
    words = replace(SIGNS, region=(0.0, 0.5, 1.0, 0.5, 1.0, 1.0)).in_words()
    assert words["region"] == "0 0.5 1 0.5 1 1"
    assert words["channels"] == "luv magnitude orientations"
    assert all(isinstance(v, bool | int | float | str | None) for v in words.values())


def test_what_made_a_model_cannot_be_changed_for_a_run(model):
    assert model.run_with(stride=2).settings.stride == 2
    with pytest.raises(ParameterError, match="channels: fixed by the training"):
        model.run_with(channels=("grey",))
