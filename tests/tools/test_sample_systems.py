"""The two simulated systems fail in different, physical ways."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tools.sample.camera import N_FRAMES
from tools.sample.scene import Car, Climate, Person, Recording, Thing
from tools.sample.systems import RANGING, THRESHOLD, detections, ranged, wandering
from tools.sample.truth import sightings

WALKER = Person(((0, 2.5, 150.0), (15, 2.5, 150.0)))
DRIVE = Recording("drive", "towards a walker", speed=((0, 10), (15, 10)), people=(WALKER,))


def first_frame(recording: Recording, system: str) -> int:
    table = detections(recording, sightings(recording), system=system)
    return int(table[table["score"] >= THRESHOLD]["frame"].min())


def walking(**changes: object) -> Recording:
    return replace(DRIVE, people=(replace(WALKER, **changes),))


def test_far_infrared_sees_a_warm_person_earlier_than_near_infrared() -> None:
    assert first_frame(DRIVE, "FIR") < first_frame(DRIVE, "NIR")


@pytest.mark.parametrize(
    ("system", "changed", "n_frames"),
    [
        ("FIR", walking(warmth=0.1), 20),
        ("FIR", walking(crouch=((0, 1), (15, 1))), 20),
        ("FIR", replace(DRIVE, climate=Climate(contrast=0.4)), 20),
        ("NIR", walking(reflectance=0.05), 15),
    ],
    ids=["cold clothes", "crouching", "warm night", "dark clothes"],
)
def test_a_system_is_late_on_what_it_sees_badly(
    system: str, changed: Recording, n_frames: int
) -> None:
    assert first_frame(changed, system) > first_frame(DRIVE, system) + n_frames


def test_near_infrared_does_not_care_for_warmth_nor_far_infrared_for_dye() -> None:
    assert first_frame(walking(warmth=0.1), "NIR") == first_frame(DRIVE, "NIR")
    assert first_frame(walking(reflectance=0.9), "FIR") == first_frame(DRIVE, "FIR")


def detected(recording: Recording, system: str) -> int:
    table = detections(recording, sightings(recording), system=system)
    return int((table["score"] >= THRESHOLD).sum())


def test_near_infrared_loses_a_person_beside_dazzling_headlamps() -> None:
    waiting = Person(((0, -1.0, 25.0), (15, -1.0, 25.0)))
    calm = replace(DRIVE, speed=((0, 0), (15, 0)), people=(waiting,))
    dazzled = replace(calm, cars=(Car(-3.4, 38.0, oncoming=True, lights=True),))
    assert detected(calm, "NIR") > 250
    assert detected(dazzled, "NIR") < 100


def test_a_hot_cabinet_alarms_far_infrared_only() -> None:
    cabinet = Thing("cabinet", 3.0, 60.0, 1.6, heat=0.9, tempt=2.0)
    empty = replace(DRIVE, people=(), things=(cabinet,))
    assert detected(empty, "FIR") > 5
    assert detected(empty, "NIR") == 0


def relative_errors(system: str, metres: float, n: int = 60) -> np.ndarray:
    """Logarithm of reported over true distance, of walkers who keep their distance."""
    away = np.full(N_FRAMES, metres)
    return np.array(
        [np.log(ranged(np.random.default_rng(seed), away, system) / metres) for seed in range(n)]
    )


@pytest.mark.parametrize("system", ["FIR", "NIR"])
@pytest.mark.parametrize("metres", [10.0, 60.0])
def test_distances_are_off_by_a_share_that_grows_with_them_and_by_nothing_on_average(
    system: str, metres: float
) -> None:
    errors = relative_errors(system, metres)
    at_zero, per_metre = RANGING[system]
    spread = at_zero + per_metre * metres
    assert errors.std() == pytest.approx(spread, rel=0.1)
    assert abs(errors.mean()) < 0.1 * spread


def test_an_error_of_distance_wanders_and_is_larger_in_the_far_infrared() -> None:
    errors = relative_errors("FIR", 40.0)
    assert np.corrcoef(errors[:, 1:].ravel(), errors[:, :-1].ravel())[0, 1] > 0.5
    assert errors.std() > 2 * relative_errors("NIR", 40.0).std()


def test_detections_report_the_distance_of_what_they_are_of() -> None:
    visible = sightings(DRIVE)
    for system in ("FIR", "NIR"):
        table = detections(DRIVE, visible, system=system)
        table = table[table["score"] >= THRESHOLD]
        true_m = visible[0].distance_m[table["frame"]]
        assert np.abs(np.log(table["distance_m"] / true_m)).median() < 0.1


def test_wandering_noise_holds_for_some_frames() -> None:
    noise = wandering(np.random.default_rng(1), hold_s=0.5, n=20_000)
    assert np.corrcoef(noise[:-1], noise[1:])[0, 1] == pytest.approx(np.exp(-0.1), abs=0.02)
    assert noise.std() == pytest.approx(1.0, abs=0.1)
