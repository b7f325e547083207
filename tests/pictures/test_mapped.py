"""Pictures of another camera, cut to what the recording shows."""

from __future__ import annotations

import numpy as np

from nvcore.pictures.mapped import MappedPictures


class OnePicture:
    def __init__(self, picture: np.ndarray):
        self.picture = picture

    def read(self, index: int) -> np.ndarray:
        assert index == 3
        return self.picture


def test_what_lies_at_a_share_of_the_recording_lies_there_in_the_picture():
    picture = np.zeros((40, 60, 3), np.uint8)
    picture[10 + 2 * 4, 6 + 2 * 5] = 200  # (5, 4) of the recording
    read = MappedPictures(OnePicture(picture), (2.0, 2.0, 6.0, 10.0), (20.0, 12.0)).read(3)
    assert read.shape == (24, 40, 3)
    assert np.argwhere(read[..., 0]).tolist() == [[8, 10]]


def test_what_the_other_camera_does_not_show_is_black():
    picture = np.full((8, 8), 100, np.uint8)
    read = MappedPictures(OnePicture(picture), (1.0, 1.0, -4.0, 0.0), (12.0, 8.0)).read(3)
    assert read[:, :4].max() == 0
    assert read[:, 4:].min() == 100


def test_a_camera_that_sees_only_a_small_part_of_the_recording_does_not_make_a_huge_picture():
    picture = np.full((60, 80, 3), 100, np.uint8)  # columns 400 to 401 of the recording
    read = MappedPictures(OnePicture(picture), (60.0, 60.0, -24_000.0, 0.0), (640.0, 8.0)).read(3)
    assert read.shape == (51, 4096, 3)
    columns = np.flatnonzero(read[2, :, 0] > 50)
    assert abs(columns.min() / 4096 - 400 / 640) < 1e-3
    assert 4096 * 80 / 38_400 - 2 < len(columns) < 4096 * 80 / 38_400 + 2
