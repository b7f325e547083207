"""Named settings for usual traffic."""

from __future__ import annotations

from dataclasses import asdict

import pytest

from nvcore.params import Params
from nvcore.params.presets import PRESETS


@pytest.mark.parametrize("preset", PRESETS, ids=lambda preset: preset.name)
@pytest.mark.parametrize("height", [None, 480.0])
def test_a_preset_makes_valid_parameters(preset, height):
    values = preset.values(height)
    assert asdict(Params(**values)).items() >= values.items()


def test_the_paper_is_the_default():
    assert Params(**PRESETS[0].values(480.0)) == Params()


def test_rural_counts_misses_at_the_edge_and_far_off():
    values = PRESETS[2].values(500.0)
    assert (values["edge_weight"], values["midpoint"]) == (1.0, 30.0)


def test_without_a_height_the_sigmoid_is_that_of_each_recording():
    assert PRESETS[2].values(None)["midpoint"] is None
