"""How fast pedestrians come nearer by their distances, beside the speed that time left takes."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from builders import Box, Place, make_dataset

from nvcore.auditing import audit
from nvcore.auditing.closing import audit_closing_speed, closing_speeds
from nvcore.dataset import Dataset
from nvcore.settings.objects import objects_from
from nvcore.settings.params import Params

M_PER_FRAME = 10 / 36
"""At ten frames a second, 10 km/h."""


def nearing(*speeds_kmh: float, n: int = 10, recording: int = 0, step: int = 1) -> list[Box]:
    """A pedestrian for each speed, side by side, from 60 m on."""
    return [
        Box(
            *(step * frame, 100 * track, 200, 30, 80, track),
            distance_m=60 - frame * speed / 10 * M_PER_FRAME,
            recording=recording,
        )
        for track, speed in enumerate(speeds_kmh)
        for frame in range(n)
    ]


def dataset(*parts: list[Box], step: int = 1) -> Dataset:
    places = [Place(range(0, 20, step), 640, 480)] * len(parts)
    return make_dataset([box for part in parts for box in part], places=places)


def test_the_speed_is_the_median_of_those_who_come_nearer():
    made = dataset(nearing(4, 3, 20, -5, 0), nearing(50, 60, 52, recording=1))
    np.testing.assert_allclose(closing_speeds(made), [4, 52])


@pytest.mark.parametrize(
    "made",
    [
        dataset(nearing(4, 4, -4)),
        dataset(nearing(4, 4, 4, n=4)),
        dataset([box._replace(distance_m=np.nan) for box in nearing(4, 4, 4)]),
        dataset([box._replace(track=-1) for box in nearing(4, 4, 4)]),
        dataset(nearing(4, 4, 4, step=2), step=2),
        dataset([]),
    ],
    ids=["two of them", "few frames", "no distances", "linked", "sampled", "nobody"],
)
def test_where_little_is_known_there_is_no_speed(made: Dataset):
    assert np.isnan(closing_speeds(made)).all()
    assert audit_closing_speed(made, Params()) == []


def test_both_speeds_are_named_with_their_recordings():
    made = dataset(nearing(4, 4, 4), nearing(50, 50, 50, recording=1))
    (finding,) = audit_closing_speed(made, Params())
    assert (finding.severity.value, finding.code, finding.count) == ("note", "closing-speed", 1)
    assert "In 1 recording pedestrians come nearer" in finding.message
    assert finding.message.endswith("distances): r0 at 4 km/h (50 km/h assumed).")
    assert finding in audit(made)


def test_speeds_are_told_in_the_words_of_the_objects():
    made = dataset(nearing(4, 4, 4))
    of_animals = replace(made, settings=replace(made.settings, objects=objects_from("animal")))
    (message,) = (
        finding.message for finding in audit(of_animals) if finding.code == "closing-speed"
    )
    assert "In 1 recording animals come nearer" in message


@pytest.mark.parametrize(("speed_kmh", "n"), [(7.9, 0), (8.1, 1), (2.1, 0), (1.9, 1)])
def test_twice_or_half_the_assumed_speed_is_far_apart(speed_kmh: float, n: int):
    made = dataset(nearing(4, 4, 4))
    assert len(audit_closing_speed(made, Params(speed_kmh=speed_kmh))) == n


def test_a_stated_speed_goes_before_the_assumed_one():
    made = dataset(nearing(4, 4, 4), nearing(50, 50, 50, recording=1))
    stated = replace(made, recordings=made.recordings.assign(speed_kmh=[5.0, 110.0]))
    (finding,) = audit_closing_speed(stated, Params())
    assert finding.message.endswith("distances): r1 at 50 km/h (110 km/h stated).")
