"""Pictures of a study, each with one pedestrian: their coarse versions, and practice pictures."""

from __future__ import annotations

import hashlib
import os
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Final

import numpy as np

from nvcore.common.errors import InputError, MediaError
from nvcore.common.file_kinds import IMAGE_SUFFIXES
from nvcore.common.wording import one_line
from nvcore.inputs.readers.parse.table import TextTable
from nvcore.pictures.base import Picture
from nvcore.pictures.header import image_size
from nvcore.pictures.images import decode_image
from nvcore.pictures.stretch import stretch
from nvcore.subjects.driver.inputs.study_tables import picture_boxes, read_picture_boxes

BOXES_FILE: Final = "boxes.csv"
MOST_PICTURES: Final = 500
MOST_BYTES: Final = 64 << 20
"""Largest size of one file."""
COARSE_COLUMNS: Final = 48
"""Width of a coarse picture, px."""
MARGIN: Final = 0.1
"""Share of its box by which a pedestrian is enlarged at each side."""
PRACTICE_SIZE: Final = (1280, 720)
FIGURES: Final = ((300.0, 330.0, 60.0, 170.0), (890.0, 350.0, 50.0, 140.0))
"""Box of the figure in each practice picture: x, y, w, h, px."""


@dataclass(frozen=True)
class StudyPicture:
    """A picture of a study: file name, box of its pedestrian and size, px.

    The `sha256` of its file makes sure that all participants see the same picture.
    """

    image: str
    pedestrian: str
    x: float
    y: float
    w: float
    h: float
    width: int
    height: int
    sha256: str


def read_pictures(folder: Path) -> tuple[StudyPicture, ...]:
    """Read the pictures listed in ``boxes.csv`` of a folder, in its order.

    Raises
    ------
    InputError
        If there is no such table (``image,pedestrian,x,y,w,h``, further columns are ignored), a
        file is missing or not a picture, a box lies outside its picture, or a picture has two
        pedestrians, so that a touch would be ambiguous.
    """
    table = read_picture_boxes(folder / BOXES_FILE)
    table.unique(("image",), "{image} is there a second time; a study shows one pedestrian each")
    if not 0 < len(table) <= MOST_PICTURES:
        raise InputError(f"a study has 1 to {MOST_PICTURES} pictures", file=BOXES_FILE)
    table = TextTable(BOXES_FILE, table.fields, table.lines, table.has_decimal_comma)
    boxes = picture_boxes(table)
    pictures = []
    for row, (image, pedestrian, x, y, w, h) in enumerate(boxes.itertuples(index=False, name=None)):
        try:
            content = _content(folder, image)
            width, height = image_size(content, one_line(image))
        except InputError as error:
            raise table.fault(row, str(error)) from error
        if x >= width or y >= height or x + w <= 0 or y + h <= 0:
            raise table.fault(row, f"the box lies outside the picture ({width} x {height} px)")
        digest = hashlib.sha256(content).hexdigest()
        pictures.append(StudyPicture(image, pedestrian, x, y, w, h, width, height, digest))
    return tuple(pictures)


def load_picture(folder: Path, picture: StudyPicture) -> Picture:
    """Return a picture of a study, uint8, grey (height, width) or RGB (height, width, 3).

    Raises
    ------
    InputError
        If the file is missing, or has changed since the study began.
    """
    content = _content(folder, picture.image)
    if hashlib.sha256(content).hexdigest() != picture.sha256:
        raise InputError(
            "the picture has changed since the study began; put the old one back, or begin "
            "another study",
            file=one_line(picture.image),
        )
    return stretch(decode_image(content, one_line(picture.image)))


def _content(folder: Path, image: str) -> bytes:
    """Return the content of a file that lies directly in the folder after resolving links."""
    name = one_line(image)
    place = Path(os.path.realpath(folder / image.replace("\0", "")))
    is_there = place.parent == Path(os.path.realpath(folder)) and place.is_file()
    if not is_there or Path(image).suffix.lower() not in IMAGE_SUFFIXES:
        raise InputError("there is no such picture in the folder", file=name)
    try:
        with place.open("rb") as stream:
            content = stream.read(MOST_BYTES + 1)
    except OSError as error:
        raise InputError(f"cannot be opened ({error.strerror})", file=name) from error
    if len(content) > MOST_BYTES:
        raise MediaError(f"a picture has {MOST_BYTES >> 20} MiB at most", file=name)
    return content


def coarse(
    picture: Picture, box: Sequence[float], *, n_columns: int = COARSE_COLUMNS
) -> np.ndarray:
    """Return a picture of the same scene in which the pedestrian cannot be seen.

    The pedestrian's place (the box, and a tenth more at each side) is filled in from the pixels to
    its left and right. Then the picture is averaged over squares. The paper says only that the
    resolution is low, so the method is our choice.

    Parameters
    ----------
    picture
        uint8, (height, width) or (height, width, 3).
    box
        x, y, w, h of the pedestrian, px.
    n_columns
        Width of the result, px. A narrower picture keeps its width.

    Returns
    -------
    uint8, (about height * n_columns / width, n_columns), with the same channels.
    """
    height, width = picture.shape[:2]
    x, y, w, h = box
    left, right = (round(edge) for edge in (x - MARGIN * w, x + (1 + MARGIN) * w))
    top, bottom = (round(edge) for edge in (y - MARGIN * h, y + (1 + MARGIN) * h))
    left, right = max(left, 0), min(max(right, left + 1), width)
    rows = slice(max(top, 0), min(max(bottom, top + 1), height))
    values = picture.astype(np.float64)
    before = values[rows, left - 1 if left > 0 else min(right, width - 1)]
    after = values[rows, right if right < width else max(left - 1, 0)]
    share = (np.arange(right - left) + 0.5) / (right - left)
    share = share.reshape(1, -1, *[1] * (picture.ndim - 2))
    values[rows, left:right] = before[:, None] * (1 - share) + after[:, None] * share
    n_columns = min(n_columns, width)
    n_rows = max(1, round(height * n_columns / width))
    for axis, (n, size) in enumerate(((n_rows, height), (n_columns, width))):
        starts = np.arange(n) * size // n
        shape = [-1 if i == axis else 1 for i in range(values.ndim)]
        lengths = np.diff(starts, append=size).reshape(shape)
        values = np.add.reduceat(values, starts, axis=axis) / lengths
    averaged: np.ndarray = np.rint(values).astype(np.uint8)
    return averaged


def practice_picture(index: int) -> np.ndarray:
    """Draw a road at dusk, uint8, (720, 1280, 3), RGB, with a figure at ``FIGURES[index]``."""
    width, height = PRACTICE_SIZE
    x, y = np.meshgrid(np.arange(width) + 0.5, np.arange(height) + 0.5)
    horizon = 0.45 * height
    light = np.where(y < horizon, 95 - 40 * y / horizon, 38 + 22 * (y - horizon) / horizon)
    half = 30 + 1.1 * (y - horizon)
    is_road = (y > horizon) & (np.abs(x - width / 2) < half)
    light = np.where(is_road, light + 14, light)
    is_line = (
        is_road & (np.abs(x - width / 2) < 0.02 * half) & (np.sqrt(np.abs(y - horizon)) % 4 < 2)
    )
    light = np.where(is_line, 150, light)
    light = np.where(_is_figure(x, y, FIGURES[index]), 120, light)
    noise = np.random.default_rng(index).normal(0, 3, light.shape)
    tint = np.array([0.95, 1.0, 1.12])
    picture: np.ndarray = np.clip((light + noise)[..., None] * tint, 0, 255).astype(np.uint8)
    return picture


def _is_figure(x: np.ndarray, y: np.ndarray, box: tuple[float, ...]) -> np.ndarray:
    """Return a mask of the pixels of head, trunk and legs within the box."""
    left, top, w, h = box
    across, down = (x - left - w / 2) / w, (y - top) / h
    head = (across / 0.22) ** 2 + ((down - 0.08) / 0.08) ** 2 < 1
    trunk = (across / 0.5) ** 2 + ((down - 0.38) / 0.24) ** 2 < 1
    legs = (down > 0.5) & (down < 1) & (np.abs(np.abs(across) - 0.18) < 0.14)
    figure: np.ndarray = head | trunk | legs
    return figure
