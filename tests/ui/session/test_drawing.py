"""Pictures of frames that pages draw."""

from __future__ import annotations

import numpy as np

from ui.session.drawing import cut_out


def test_a_cut_out_lies_around_the_pedestrian_and_within_the_picture():
    picture = np.arange(100 * 200).reshape(100, 200)
    middle = cut_out(picture, np.array([95, 40, 10, 20]))
    assert middle.shape == (44, 70)
    assert middle[22, 35] == picture[50, 100]
    corner = cut_out(picture, np.array([190, 90, 10, 20]))
    assert (corner[-1, -1], corner.shape) == (picture[-1, -1], (44, 70))
    tall = cut_out(np.zeros((100, 120)), np.array([10, 0, 40, 100]))
    assert tall.shape == (100, 120)
