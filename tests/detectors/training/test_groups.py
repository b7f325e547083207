"""What is held out of a training: whole groups, or the end of each recording."""

from __future__ import annotations

import numpy as np
import pytest

from nvcore.detectors.training.split import by_group, by_time
from nvcore.errors import ParameterError


def test_groups_are_held_out_as_a_whole():
    tracks = [i // 30 for i in range(300)]
    is_out = by_group(tracks, 0.2, seed=0)
    assert is_out.sum() == 60
    assert all(len(set(is_out[i : i + 30])) == 1 for i in range(0, 300, 30))
    np.testing.assert_array_equal(is_out, by_group(tracks, 0.2, seed=0))


def test_at_least_one_group_is_on_either_side():
    assert by_group(["a", "b"], 0.01, seed=0).sum() == 1
    assert by_group(["a", "b"], 0.99, seed=0).sum() == 1
    assert by_group(["a", "a"], 0.5, seed=0).sum() == 0
    assert by_group([], 0.5, seed=0).shape == (0,)


def test_the_end_of_each_recording_is_held_out():
    recording = np.array([0] * 10 + [1] * 5)
    frame = np.concatenate([np.arange(10), np.arange(100, 105)])
    is_trained, is_out = by_time(recording, frame, 0.4, gap=1)
    assert frame[is_out].tolist() == [6, 7, 8, 9, 103, 104]
    assert frame[is_trained].tolist() == [0, 1, 2, 3, 4, 100, 101]


@pytest.mark.parametrize("share", [0.0, 1.0, -1.0])
def test_all_or_nothing_cannot_be_held_out(share):
    with pytest.raises(ParameterError, match="share"):
        by_group(["a"], share, seed=0)
    with pytest.raises(ParameterError, match="share"):
        by_time(np.zeros(1, int), np.zeros(1, int), share)
    with pytest.raises(ParameterError, match="gap"):
        by_time(np.zeros(1, int), np.zeros(1, int), 0.5, gap=-1)
