"""Pictures in single files: a folder, a list, or a ZIP archive of PNG, JPEG, TIFF or BMP."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from copy import copy
from dataclasses import replace
from fnmatch import fnmatchcase
from pathlib import Path, PurePosixPath
from threading import Lock
from typing import Final

import cv2
import numpy as np
from numpy.typing import NDArray

from nvcore.common.errors import MediaError
from nvcore.common.file_kinds import IMAGE_SUFFIXES, composed
from nvcore.common.wording import MOST_NAMED, one_line
from nvcore.pictures.archive import Archive
from nvcore.pictures.base import Picture, Pictures, RecentPictures, check_index
from nvcore.pictures.header import image_size, tiff_pages, with_first_page
from nvcore.pictures.notes import PictureNote, PictureTrait
from nvcore.pictures.series import Series, is_stray, series_of
from nvcore.pictures.stretch import STRETCH, measured

_MAX_BYTES: Final = 1 << 29
_SHOWN_FOLDERS: Final = 5
_FAR: Final = 25
"""Largest multiple of the quartiles' distance: the sun at night in kelvin is nearer, 0 is not."""


class Images(Pictures):
    """Pictures that are files of their own, or the pages of one TIFF."""

    def __init__(
        self,
        name: str,
        series: Series,
        read_bytes: Callable[[str], bytes],
        close: Callable[[], None] = lambda: None,
    ):
        """Take over files in their order, of a single TIFF its pages.

        Parameters
        ----------
        name
            Name of all of them together.
        read_bytes
            Returns the content of a file by its name in the series.
        close
            Is called by `close`.

        Raises
        ------
        MediaError
            If the first picture cannot be read.
        """
        self.name, self.numbers, self._names = name, series.numbers, series.names
        self._read_bytes, self._close = read_bytes, close
        first = PurePosixPath(series.names[0])
        is_tiff = first.suffix.lower() in (".tif", ".tiff")
        pages = tiff_pages(read_bytes(series.names[0])) if is_tiff else []
        is_single = len(pages) > 1 == len(series.names)
        self._pages = pages if is_single else []
        if is_single:
            self.numbers = None
        if others := series.passed_over:
            named = tuple(PurePosixPath(other).name for other in others[:MOST_NAMED])
            self.notes += (PictureNote(PictureTrait.PASSED_OVER, len(others), names=named),)
        if len(pages) > 1 and not is_single:
            further = PictureNote(PictureTrait.FURTHER_PAGES, len(pages) - 1, names=(first.name,))
            self.notes += (further,)
        self.n, self.is_video = len(self._pages) or len(series.names), bool(self._pages)
        self._recent, self._lock = RecentPictures(), Lock()
        self.height, self.width = self.read(0).shape[:2]

    def read(self, index: int) -> Picture:
        """See `Pictures.read`."""
        check_index(index, self)
        with self._lock:
            picture = self._recent.get(index)
            if picture is not None:
                return picture
            path = self._names[0 if self._pages else index]
            name, content = one_line(PurePosixPath(path).name), self._read_bytes(path)
            if self._pages:
                name = f"{name}, page {index + 1}"
                content = with_first_page(content, self._pages[index])
            return self._recent.put(index, decode_image(content, name))

    def file_names(self, indices: Sequence[int]) -> list[str] | None:
        """See `Pictures.file_names`."""
        if self._pages:
            return None
        return [PurePosixPath(self._names[index]).name for index in indices]

    def another(self) -> Images:
        """See `Pictures.another`."""
        other = copy(self)
        other._recent, other._lock = RecentPictures(), Lock()
        other._close = lambda: None  # the files are this one's
        return other

    def close(self) -> None:
        """See `Pictures.close`."""
        with self._lock:
            self._recent.clear()
            self._close()


def decode_image(content: bytes, name: str) -> Picture:
    """Decode a PNG, JPEG, TIFF or BMP as grey or RGB, uint8 or uint16, turned as its camera says.

    Transparency is dropped. Fractions (TIFF of temperatures) become uint16 (`_as_uint16`).

    Raises
    ------
    MediaError
        If it is none of these, too large, or damaged.
    """
    image_size(content, name)
    # what is turned by Exif comes turned in this mode alone; a TIFF always does
    is_exif = content.startswith((b"\xff\xd8\xff", b"\x89PNG"))
    mode = cv2.IMREAD_ANYDEPTH | cv2.IMREAD_ANYCOLOR if is_exif else cv2.IMREAD_UNCHANGED
    try:
        picture = cv2.imdecode(np.frombuffer(content, np.uint8), mode)
    except cv2.error:
        picture = None
    if picture is None:
        raise MediaError("the picture cannot be decoded; it is damaged or unusual", file=name)
    if picture.ndim == 3:
        picture = picture[..., 0] if picture.shape[2] < 3 else picture[..., 2::-1]
    is_negative = picture.dtype != np.uint8 and any(
        page.is_white_zero for page in tiff_pages(content, most=1)
    )  # of 8 bits, the decoder makes the positive itself
    if picture.dtype not in (np.uint8, np.uint16):
        picture = _as_uint16(picture)
    return np.ascontiguousarray(65535 - picture if is_negative else picture)


def _as_uint16(picture: NDArray[np.generic]) -> NDArray[np.uint16]:
    """Scale the values from the least to the greatest to 0..65535.

    A masked border or a single wrong pixel must not take the contrast of all others. NaN becomes
    one of the darkest values, as do values lower than the quartiles by more than `_FAR` times their
    distance. Values as far above become one of the brightest.
    """
    values = picture.astype(np.float64)
    near = values[np.isfinite(values)]
    if not len(near):
        return np.zeros(picture.shape, np.uint16)
    near = measured(near)
    for shares in ((25, 75), (5, 95), (0.5, 99.5)):  # the quartiles of a plain background are one
        lower, upper = np.percentile(near, shares)
        if upper > lower:
            reach = _FAR * (upper - lower)
            near = near[(near >= lower - reach) & (near <= upper + reach)]
            break
    low, high = float(near.min()), float(near.max())
    if not low < high:
        return np.zeros(picture.shape, np.uint16)
    dark, bright = np.percentile(near, STRETCH)  # a border of these does not weaken the contrast
    values = np.where(values > high, bright, np.where(values >= low, values, dark))
    scaled: NDArray[np.float64] = (values - low) / (high - low) * 65535
    return scaled.astype(np.uint16)


def folder_as_pictures(folder: Path, pattern: str = "") -> Images:
    """Open the pictures of a folder, or of its only subfolder with pictures. Skip hidden files.

    Parameters
    ----------
    pattern
        Pattern of the file names, as in a shell: of the folder itself. Empty: all.

    Raises
    ------
    MediaError
        If there is none, several subfolders hold some, or they are of several series.
    """
    try:
        relative = [
            path.relative_to(folder).as_posix()
            for path in (folder.iterdir() if pattern else folder.rglob("*"))
            if path.suffix.lower() in IMAGE_SUFFIXES and path.is_file()
        ]
    except OSError as error:
        raise MediaError(f"cannot be read ({error.strerror})", file=folder.name) from error
    return _of_one_folder(relative, folder.name, pattern, lambda name: file_bytes(folder / name))


def archive_as_pictures(path: Path, pattern: str = "") -> Images:
    """Open the pictures of a ZIP archive without unpacking it.

    Raises
    ------
    MediaError
        As `folder_as_pictures`, or if the archive is refused (`nvcore.pictures.archive`).
    """
    archive = Archive(path)
    try:
        pictures = [
            name for name in archive.names if PurePosixPath(name).suffix.lower() in IMAGE_SUFFIXES
        ]
        return _of_one_folder(pictures, path.name, pattern, archive.read, archive.close)
    except MediaError:
        archive.close()
        raise


def _of_one_folder(
    names: Sequence[str],
    where: str,
    pattern: str,
    read_bytes: Callable[[str], bytes],
    close: Callable[[], None] = lambda: None,
) -> Images:
    """Open those in one folder: the top one, else the only one."""
    by_folder: dict[str, list[str]] = {}
    wanted, strays = composed(pattern or "*"), list[str]()
    for name in names:
        path = PurePosixPath(name)
        is_hidden = any(part.startswith(".") for part in path.parts)
        if not is_hidden and fnmatchcase(composed(path.name), wanted):
            by_folder.setdefault(str(path.parent), []).append(name)
    if "." in by_folder:
        top = by_folder.pop(".")
        if len(by_folder) == 1 and is_stray(len(top), len(*by_folder.values())):
            strays = top  # a cover beside the folder of the pictures
        else:
            by_folder = {".": top}
    if not by_folder:
        named = f" of the name {one_line(pattern)}" if pattern not in ("", "*") else ""
        raise MediaError(f"holds no PNG, JPEG, TIFF or BMP{named}", file=where)
    if len(by_folder) > 1:
        folders = ", ".join(one_line(name) for name in sorted(by_folder)[:_SHOWN_FOLDERS])
        more = ", ..." if len(by_folder) > _SHOWN_FOLDERS else ""
        raise MediaError(
            f"holds pictures in {len(by_folder)} folders ({folders}{more}); give the folder of one "
            "recording",
            file=where,
        )
    (inner,) = by_folder.values()
    series = series_of(inner, where)
    series = replace(series, passed_over=(*strays, *series.passed_over))
    return Images(where, series, read_bytes, close)


def file_bytes(path: Path) -> bytes:
    """Return the content of a picture file.

    Raises
    ------
    MediaError
        If it cannot be read, or is larger than 512 MiB.
    """
    name = one_line(path.name)
    try:
        if path.stat().st_size > _MAX_BYTES:
            raise MediaError(f"is larger than {_MAX_BYTES >> 20} MiB; is it a picture?", file=name)
        return path.read_bytes()
    except OSError as error:
        raise MediaError(f"cannot be read ({error.strerror})", file=name) from error
