"""What is known of the settings that a detector may be run with, whatever its kind."""

from __future__ import annotations

from dataclasses import fields
from typing import Final

from nvcore.dataset.provenance import About
from nvcore.detectors.registry import DETECTORS
from nvcore.detectors.settings import SettingFacts, facts_of

OF_ICF: Final[dict[str, SettingFacts]] = {
    "scales": SettingFacts(
        "Divisors of the picture's size, ascending, with blanks between; below 1 it is enlarged."
    ),
    "scales_between": SettingFacts(
        "How many scales after each computed one are made from its channels; 0: none.",
        low=0,
        high=64,
    ),
    "stride": SettingFacts("Step between two windows, px.", low=1, high=256),
    "threshold": SettingFacts("Lowest confidence of a box.", low=-1e6, high=1e6),
    "overlap": SettingFacts(
        "Of two boxes that overlap by more than this share, the less confident goes; 1: both stay.",
        low=0,
        high=1,
    ),
    "overlap_of": SettingFacts(
        "Of what the overlap is a share.",
        choices={"union": "of both boxes together", "smaller": "of the smaller box"},
    ),
    "cascade": SettingFacts(
        "What rejects a window before the last tree.",
        choices={
            "calibrated": "a confidence below what objects had there",
            "constant": "a confidence below the setting rejection",
            "hard": "too low a sum of one stage by itself",
            "none": "nothing: every window is given to every tree",
        },
    ),
    "rejection": SettingFacts("Of the constant cascade.", low=-1000, high=1000),
    "use_band": SettingFacts(
        "Whether windows must lie where the objects of the training lay, by their size."
    ),
    "region": SettingFacts(
        "Corners of a polygon in which a window's centre must lie, as shares of the picture's "
        "width and height, with blanks between; empty: anywhere."
    ),
    "proposals": SettingFacts(
        "Which windows are looked at.",
        choices={"none": "all", "red": "those with enough red pixels"},
    ),
    "red_share": SettingFacts("Least share of red pixels of a proposal.", low=0, high=1),
}
"""Settings of a trained model that may be another in a run (`IcfSettings`)."""


def run_settings(about: About) -> dict[str, SettingFacts]:
    """The settings that this detector may be run with otherwise, by name."""
    settings = DETECTORS[about.kind].settings()
    if settings is None:
        return OF_ICF
    return {spec.name: facts_of(spec) for spec in fields(settings)}
