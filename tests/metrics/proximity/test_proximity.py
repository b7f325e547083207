"""Proximity weights: hand cases, blocks, the sigmoid's ends."""

from __future__ import annotations

import math

import numpy as np
import pytest
from builders import Place, at, make_dataset

from nvcore.dataset import Dataset
from nvcore.metrics import proximity
from nvcore.metrics.proximity import sigmoid, weigh_proximity
from nvcore.settings.params import Params

ONE = 1 / (1 + math.exp(-1))


def weighed(dataset: Dataset, **settings: object) -> np.ndarray:
    boxes = dataset.truth
    params = Params(**{"midpoint": 20.0, "spread": 5.0, **settings})
    return weigh_proximity(boxes, ~boxes.ignore, dataset.frame_columns, params).k


@pytest.mark.parametrize("z", [-1e308, -745.2, -1.0, 0.0, 1.0, 745.2, 1e308])
def test_the_sigmoid_cannot_overflow(z: float) -> None:
    both = sigmoid(np.array([z, -z]))
    assert 0 <= both[0] <= 1
    assert both[0] == pytest.approx(1 - both[1])


def test_the_argument_of_the_sigmoid_is_not_changed() -> None:
    z = np.array([1.0, 2.0])
    sigmoid(z)
    assert z.tolist() == [1.0, 2.0]


def test_weights_by_height_horizon_distance_and_none() -> None:
    truth = [at(0, 20, h=25, foot=60, distance_m=28.0), at(0, 20, h=20, foot=75)]
    dataset = make_dataset(truth, horizon=40)
    assert weighed(dataset) == pytest.approx([ONE, 0.5])
    assert weighed(dataset, proximity="horizon") == pytest.approx([0.5, 1 / (1 + math.exp(-3))])
    assert weighed(dataset, proximity="distance") == pytest.approx([ONE, 0.5])
    assert weighed(dataset, proximity="none").tolist() == [1, 1]


def test_the_default_sigmoid_follows_each_recordings_height() -> None:
    places = [Place(range(2), height=h) for h in (100, 100, 200)]
    dataset = make_dataset(
        [at(f, 20, h=20, recording=r) for r in range(3) for f in range(2)], places=places
    )
    k = weighed(dataset, midpoint=None, spread=None)
    assert k[:4] == pytest.approx([1 / (1 + math.exp(-5))] * 4)
    assert k[4:] == pytest.approx([0.5] * 2)


def test_weights_do_not_depend_on_the_size_of_the_blocks(monkeypatch) -> None:
    places = [Place(range(7), height=h) for h in (100, 200, 200, 100)]
    boxes = [
        at(f, 20, h=5 + 7 * f + r, recording=r)
        for r in range(4)
        for f in range(7)
        for _ in range((f + r) % 3)
    ]
    dataset = make_dataset(boxes, places=places)
    whole = weighed(dataset, midpoint=None, spread=None)
    monkeypatch.setattr(proximity, "BLOCK", 2)
    assert weighed(dataset, midpoint=None, spread=None).tolist() == whole.tolist()
