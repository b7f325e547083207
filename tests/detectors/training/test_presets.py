"""Settings of a training as users write them."""

from __future__ import annotations

from typing import Any, get_args

import pytest

from nvcore.common.errors import ParameterError
from nvcore.settings.objects import PEDESTRIAN, SPEED_SIGN
from nvcore.subjects.detectors.base import DetectorError
from nvcore.subjects.detectors.calls.arguments import Preset
from nvcore.subjects.detectors.icf import AS_IN_REPORT, PEDESTRIANS, SIGNS
from nvcore.subjects.detectors.training.run import PRESETS, preset_for, preset_settings


def test_the_command_line_knows_them_all():
    assert tuple(PRESETS) == get_args(Preset)


def test_the_preset_follows_the_objects():
    assert [preset_for(objects) for objects in (None, PEDESTRIAN, SPEED_SIGN)] == [
        "pedestrians",
        "pedestrians",
        "signs",
    ]
    assert [preset_settings(name, {}) for name in PRESETS] == [PEDESTRIANS, SIGNS, AS_IN_REPORT]


def test_texts_are_read_as_the_setting_s_type():
    given = {"scales": "1, 1.5", "channels": "grey magnitude", "blur": "no", "patience": "30"}
    settings = preset_settings("pedestrians", {**given, "stride": "6", "overlap": 1})
    assert settings.scales == (1.0, 1.5)
    assert settings.channels == ("grey", "magnitude")
    assert (settings.blur, settings.patience, settings.stride) == (False, 30, 6)
    assert preset_settings("as-in-report", {"patience": "150"}).patience == 150
    assert preset_settings("as-in-report", {"patience": "none"}).patience is None
    assert preset_settings("pedestrians", {"trees_per_round": [4, 8]}).trees_per_round == (4, 8)
    assert preset_settings("pedestrians", {"trees_per_round": 8}).trees_per_round == (8,)


@pytest.mark.parametrize(
    ("preset", "given", "words"),
    [
        ("pedestrian", {}, "did you mean 'pedestrians'"),
        ("signs", {"strid": "4"}, "did you mean 'stride'"),
        ("signs", {"stride": "4.5"}, "stride: expected a whole number"),
        ("signs", {"patience": "long"}, "patience: expected a whole number or none"),
        ("signs", {"scales": "2 1"}, "scales: expected 1 to 64 of them, ascending"),
        ("signs", {"stride": "1e999"}, "stride: expected"),
        ("signs", {"features": "99999999"}, "features: expected 1 to 200000"),
        ("signs", {"channels": "infrared"}, "channels: expected some of"),
    ],
)
def test_what_is_not_possible_is_said(preset: str, given: dict[str, Any], words: str):
    with pytest.raises((DetectorError, ParameterError), match=words):
        preset_settings(preset, given)
