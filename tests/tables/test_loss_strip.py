"""All recordings as strips of time."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pytest
from builders import Place, at, make_dataset, result_of

from nvcore.tables.loss_strip import loss_strip


def test_each_bin_has_the_largest_loss_of_either_system_and_its_frame():
    """Two recordings of 8 and 4 frames at 10 fps, in four bins of two frames."""
    truth = [at(i, 50, track=1) for i in range(8)]
    truth += [at(i, 50, track=1, recording=1) for i in range(4)]
    x = [box for box in truth if (box.recording, box.frame) not in [(0, 3), (1, 0)]]
    y = [box for box in truth if (box.recording, box.frame) not in [(0, 6), (0, 7), (1, 1)]]
    result = result_of(make_dataset(truth, x, y, places=[Place(range(8)), Place(range(4))]))
    strip = loss_strip(result, n_bins=4)
    assert strip.bin_s == pytest.approx(0.2)
    assert strip.recording.tolist() == [0, 1]
    # Y loses 2 of 8 frames, 0.9 each; in the other either system one of 4
    assert strip.lost_s_per_min == pytest.approx([60 * 0.9 / 4, 60 * 0.9 / 4])
    assert strip.loss[0] == pytest.approx([0, 0.9, 0, 0.9])
    assert strip.row[0].tolist() == [0, 3, 4, 6]
    assert strip.loss[1, :2] == pytest.approx([0.9, 0])
    assert np.isnan(strip.loss[1, 2:]).all()
    assert strip.row[1].tolist() == [8, 10, -1, -1]


def test_the_recording_in_which_most_is_lost_comes_first_and_those_left_out_are_counted():
    places = [Place(range(2)), Place([]), Place(range(2)), Place(range(2))]
    truth = [
        at(i, centre, recording=r) for r, centre in ((0, 10), (2, 40), (3, 30)) for i in (0, 1)
    ]
    result = result_of(make_dataset(truth, [], truth, places=places))
    strip = loss_strip(result, most=2)
    assert strip.recording.tolist() == [2, 3]
    assert strip.n_recordings == 3


def test_a_single_bad_frame_of_hours_is_found():
    n = 50_000
    truth = [at(i, 50) for i in (7, 31_234)]
    result = result_of(make_dataset(truth, [], truth[:1], n_frames=n))
    strip = loss_strip(result, n_bins=100)
    (bad,) = np.nonzero(strip.loss[0] > 0.5)
    assert strip.row[0, bad].tolist() == [7, 31_234]


def test_a_frame_of_a_sampled_recording_lasts_until_the_next():
    places = [Place([0, 10, 20]), Place(range(30))]
    truth = [at(0, 50)]
    strip = loss_strip(result_of(make_dataset(truth, [], truth, places=places)), n_bins=6)
    assert strip.loss[0] == pytest.approx([0.9, 0.9, 0, 0, 0, 0])
    assert strip.row[0].tolist() == [0, 0, 1, 1, 2, 2]


@pytest.mark.parametrize(("fps", "listed", "bin_s"), [(20.0, range(30), 0.05), (1, [0, 9, 18], 9)])
def test_no_bin_is_shorter_than_a_frame(fps: float, listed: Sequence[int], bin_s: float):
    truth = [at(listed[1], 50)]
    dataset = make_dataset(truth, [], truth, places=[Place(listed, fps=fps)])
    strip = loss_strip(result_of(dataset))
    assert strip.bin_s == pytest.approx(bin_s)
    assert strip.row[0].tolist() == [*range(len(listed))]
    assert strip.loss[0, :3] == pytest.approx([0, 0.9, 0])


def test_without_frames_there_is_no_strip():
    strip = loss_strip(result_of(make_dataset(places=[Place([])])))
    assert strip.loss.shape[0] == strip.n_recordings == 0
