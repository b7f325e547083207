"""Features of pedestrians in single pictures, such as those of a study.

    image,pedestrian,x,y,w,h,fixation_x,fixation_y
    park.jpg,1,612,388,31,74,480,270

Fixation columns or cells may be missing. A fixed point is assumed in that case.
"""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping
from dataclasses import asdict, dataclass
from difflib import get_close_matches
from pathlib import Path
from typing import Final

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from nvcore.common.errors import FormatError
from nvcore.common.progress import Progress, no_progress
from nvcore.common.wording import did_you_mean, listed
from nvcore.inputs.readers.parse.table import TextTable
from nvcore.notes import Note, phrase
from nvcore.pictures import Picture, is_below, stretch
from nvcore.pictures.images import decode_image, file_bytes
from nvcore.pictures.run import PictureRun
from nvcore.pictures.stretch import STRETCH
from nvcore.settings import objects
from nvcore.subjects.driver.features import FEATURE_KEYS, features_of
from nvcore.subjects.driver.features.feature_record import record_bytes
from nvcore.subjects.driver.inputs.study_tables import (
    BOX,
    LARGEST,
    PEDESTRIAN,
    picture_boxes,
    read_picture_boxes,
)
from nvcore.subjects.driver.settings import DriverViewSettings

FIXATION_COLUMNS: Final = ("fixation_x", "fixation_y")
_ALIKE: Final = 0.8
"""Minimum similarity (`difflib`) for treating a column name as a misspelling."""
IMAGE_FEATURE_COLUMNS: Final = (*PEDESTRIAN, *BOX, *FEATURE_KEYS)


@dataclass(frozen=True, eq=False, repr=False)
class ImageFeatures:
    """Features of pedestrians in single pictures. ``print`` shows the counts.

    Attributes
    ----------
    table
        `IMAGE_FEATURE_COLUMNS`, rows as in the file of the boxes.
    n_assumed
        Number of pedestrians whose fixation is assumed.
    sizes
        Distinct widths and heights of the pictures, px, ascending.
    """

    table: pd.DataFrame
    n_images: int
    n_assumed: int
    settings: DriverViewSettings
    sizes: tuple[tuple[int, int], ...]

    def __repr__(self) -> str:
        return f"<ImageFeatures of {phrase(self._counts, objects.PEDESTRIAN)}>"

    def __str__(self) -> str:
        notes = [self._counts]
        if self.n_assumed:
            at, n = self.settings.fixation, self.n_assumed
            n_of = n if n < len(self.table) else None
            notes.append(Note("driver.fixation_assumed", n=n_of, x=at.x, y=at.y))
        if (n := len(self.sizes)) > 1:
            least, *_, most = self.sizes
            notes.append(Note("driver.picture_sizes", n=n, least=least, most=most))
        return "\n".join(phrase(note, objects.PEDESTRIAN) for note in notes)

    @property
    def picture_px(self) -> tuple[int, int] | None:
        """Width and height of all pictures, or None if they differ."""
        return self.sizes[0] if len(self.sizes) == 1 else None

    def record(self, contents: Mapping[str, bytes]) -> bytes:
        """Serialize settings, counts and the hashes of these files as JSON."""
        values = asdict(self.settings)
        return record_bytes(
            contents,
            settings={name: values[name] for name in ("features", "fixation")},
            n_assumed=self.n_assumed,
            picture_px=self.picture_px,
        )

    @property
    def _counts(self) -> Note:
        return Note("driver.images", n_boxes=len(self.table), n=self.n_images)


def image_features(
    folder: Path,
    boxes: Path,
    settings: DriverViewSettings | None = None,
    *,
    n_threads: int | None = None,
    progress: Progress = no_progress,
) -> ImageFeatures:
    """Compute features of the pedestrians listed in a file, in the pictures of a folder.

    Parameters and errors as for `nvcore.image_features`.
    """
    settings = settings or DriverViewSettings()
    table = read_picture_boxes(boxes)
    pedestrians = picture_boxes(table)
    box = pedestrians[[*BOX]].to_numpy(np.float64)
    fixation = _fixations(table)
    row_of, names = pd.factorize(pedestrians["image"], sort=True)
    rows = [np.flatnonzero(row_of == number) for number in range(len(names))]
    features = np.full((len(table), len(FEATURE_KEYS)), np.nan)

    def look(number: int, picture: Picture) -> tuple[int, int]:
        if picture.dtype != np.uint8:
            picture = stretch(picture, *STRETCH)
        own = rows[number]
        height, width = picture.shape[:2]
        x, y, w, h = box[own].T
        is_outside = (x >= width) | (y >= height) | (x + w <= 0) | (y + h <= 0)
        if is_outside.any():
            text = f"the box lies outside the picture of {width} x {height} px"
            raise table.fault(int(own[np.argmax(is_outside)]), text)
        assumed = np.array(settings.fixation.in_picture(width, height))
        points = np.where(np.isnan(fixation[own]), assumed, fixation[own])
        features[own] = features_of(picture, box[own], points, settings.features)
        return width, height

    run = PictureRun(len(names), progress, n_threads=n_threads)
    sizes = {*run.map(look, _read(table, folder, list(names), rows), folder.name)}
    described = pedestrians.assign(**dict(zip(FEATURE_KEYS, features.T, strict=True)))
    n_assumed = int(np.count_nonzero(np.isnan(fixation[:, 0])))
    return ImageFeatures(described, len(names), n_assumed, settings, tuple(sorted(sizes)))


def _fixations(table: TextTable) -> NDArray[np.float64]:
    """Return the fixation of each pedestrian, px, shape (n, 2), NaN if unknown."""
    lost = [name for name in FIXATION_COLUMNS if name not in table]
    if lost:
        present = [name for name in FIXATION_COLUMNS if name in table]
        others = [name for name in table.fields if name not in (*IMAGE_FEATURE_COLUMNS, *present)]
        misspelt = [name for name in others if get_close_matches(name, lost, n=1, cutoff=_ALIKE)]
        if not present and not misspelt:
            return np.full((len(table), 2), np.nan)
        remedy = "give both, or neither"
        if misspelt:
            remedy = did_you_mean(misspelt[0], lost, remedy)
        found = listed([*present, *misspelt])
        raise FormatError(
            f"expected both {listed(FIXATION_COLUMNS)}, found {found}; {remedy}",
            file=table.name,
            line=1,
        )
    columns = [
        table.numbers(name, low=-LARGEST, high=LARGEST, may_be_empty=True)
        for name in FIXATION_COLUMNS
    ]
    points = np.stack(columns, axis=1)
    is_half = np.isnan(points).sum(axis=1) == 1
    if is_half.any():
        row = int(np.argmax(is_half))
        raise table.fault(row, "expected both fixation_x and fixation_y, or neither")
    return points


def _read(
    table: TextTable, folder: Path, names: list[str], rows: list[NDArray[np.int64]]
) -> Iterator[tuple[int, Picture]]:
    for number, name in enumerate(names):
        path, row = folder / name, int(rows[number][0])
        if not is_below(path, folder):
            raise table.fault(row, f"image: {name!r} lies outside the folder of the pictures")
        if not os.path.isfile(path):  # noqa: PTH113 - Path.is_file raises if a name is too long
            raise table.fault(row, f"image: there is no {name!r} in {folder.name}")
        yield number, decode_image(file_bytes(path), name)
