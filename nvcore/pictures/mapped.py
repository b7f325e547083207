"""Pictures of another camera, cut to the area that the recording's own pictures show."""

from __future__ import annotations

from typing import Final

import cv2
import numpy as np

from nvcore.pictures.base import Picture, PictureReader

LONGEST_SIDE_PX: Final = 4096
"""Limit for cut pictures, which are huge where the other camera sees but a small part."""


class MappedPictures:
    """Pictures of another camera in which boxes keep their relative place in the recording.

    Areas that the other camera does not show are black. The resolution is that of the other camera,
    but no side is longer than `LONGEST_SIDE_PX`.
    """

    def __init__(
        self,
        pictures: PictureReader,
        to_picture: tuple[float, float, float, float],
        size: tuple[float, float],
    ) -> None:
        """Take the pictures.

        Parameters
        ----------
        to_picture
            (sx, sy, dx, dy): the point (x, y) of the recording, px, is (sx x + dx, sy y + dy) in
            the pictures.
        size
            Width and height of the recording, px.
        """
        across, down, right, lower = to_picture
        width, height = across * size[0], down * size[1]
        shrink = min(1.0, LONGEST_SIDE_PX / max(width, height))
        self._pictures = pictures
        self._move = shrink * np.array([[1, 0, -right], [0, 1, -lower]], np.float64)
        self._size = max(1, round(shrink * width)), max(1, round(shrink * height))

    def read(self, index: int) -> Picture:
        """Return the picture of that index, cut, as `Pictures.read` does."""
        picture = self._pictures.read(index)
        return np.asarray(cv2.warpAffine(picture, self._move, self._size))
