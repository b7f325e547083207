"""The two simulated systems fail in different, physical ways."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from nvcore.sample.scene import Car, Climate, Person, Recording, Thing
from nvcore.sample.systems import THRESHOLD, detections, wandering
from nvcore.sample.truth import sightings

WALKER = Person(((0, 2.5, 150.0), (15, 2.5, 150.0)))
DRIVE = Recording("drive", "towards a walker", speed=((0, 10), (15, 10)), people=(WALKER,))


def first_frame(recording: Recording, system: str) -> int:
    table = detections(recording, sightings(recording), system=system)
    return int(table[table["score"] >= THRESHOLD]["frame"].min())


def test_far_infrared_sees_a_warm_person_earlier_than_near_infrared() -> None:
    assert first_frame(DRIVE, "FIR") < first_frame(DRIVE, "NIR")


def test_far_infrared_is_late_on_cold_clothes() -> None:
    cold = replace(DRIVE, people=(replace(WALKER, warmth=0.1),))
    assert first_frame(cold, "FIR") > first_frame(DRIVE, "FIR") + 20


def test_far_infrared_is_late_on_a_crouching_person() -> None:
    low = replace(DRIVE, people=(replace(WALKER, crouch=((0, 1), (15, 1))),))
    assert first_frame(low, "FIR") > first_frame(DRIVE, "FIR") + 20


def test_far_infrared_is_late_on_a_warm_night() -> None:
    warm = replace(DRIVE, climate=Climate(contrast=0.4))
    assert first_frame(warm, "FIR") > first_frame(DRIVE, "FIR") + 20


@pytest.mark.parametrize("change", [{"warmth": 0.1}, {"reflectance": 0.9}])
def test_near_infrared_does_not_care_for_warmth_nor_far_infrared_for_dye(
    change: dict[str, float],
) -> None:
    system = "NIR" if "warmth" in change else "FIR"
    changed = replace(DRIVE, people=(replace(WALKER, **change),))
    assert first_frame(changed, system) == first_frame(DRIVE, system)


def test_near_infrared_is_late_on_dark_clothes() -> None:
    dark = replace(DRIVE, people=(replace(WALKER, reflectance=0.05),))
    assert first_frame(dark, "NIR") > first_frame(DRIVE, "NIR") + 15


def test_near_infrared_loses_a_person_beside_dazzling_headlamps() -> None:
    waiting = Person(((0, -1.0, 25.0), (15, -1.0, 25.0)))
    calm = replace(DRIVE, speed=((0, 0), (15, 0)), people=(waiting,))
    dazzled = replace(calm, cars=(Car(-3.4, 38.0, oncoming=True, lights=True),))
    found = [
        int((detections(r, sightings(r), system="NIR")["score"] >= THRESHOLD).sum())
        for r in (calm, dazzled)
    ]
    assert found[0] > 250
    assert found[1] < 100


def test_a_hot_cabinet_alarms_far_infrared_only() -> None:
    cabinet = Thing("cabinet", 3.0, 60.0, 1.6, heat=0.9, tempt=2.0)
    empty = replace(DRIVE, people=(), things=(cabinet,))
    strong = [
        int((detections(empty, [], system=system)["score"] >= THRESHOLD).sum())
        for system in ("FIR", "NIR")
    ]
    assert strong[0] > 5
    assert strong[1] == 0


def test_wandering_noise_holds_for_some_frames() -> None:
    noise = wandering(np.random.default_rng(1), hold_s=0.5, n=20_000)
    assert np.corrcoef(noise[:-1], noise[1:])[0, 1] == pytest.approx(np.exp(-0.1), abs=0.02)
    assert noise.std() == pytest.approx(1.0, abs=0.1)
