"""The size that a picture's header states, read before anything is decoded.

This is done by hand as it must accept exactly the files that OpenCV decodes. Pillow refuses TIFFs
of temperatures (float64, and float32 or int16 of several channels), warns about TIFF tags that it
does not know, and has one limit of pixels for the whole process, beyond which it gives no size.
The tests compare the sizes with files that Pillow wrote and pictures that OpenCV decodes.
"""

from __future__ import annotations

import struct
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Final

from nvcore.common.errors import MediaError

MAX_PIXELS: Final = 100_000_000
"""Largest number of pixels. No camera of these drives makes larger pictures."""
MAX_SIDE: Final = 65_500
"""Largest side, px. A JPEG for the browser cannot have a longer one."""

_BITMAP_HEADERS: Final = frozenset(struct.pack("<L", n) for n in (12, 40, 52, 56, 108, 124))
"""Lengths of the headers that bitmaps have."""

_START_OF_FRAME: Final = frozenset(range(0xC0, 0xD0)) - {0xC4, 0xC8, 0xCC}
_WITHOUT_LENGTH: Final = frozenset({0x01, *range(0xD0, 0xD9)})

_TIFF_KIND, _TIFF_WIDTH, _TIFF_HEIGHT, _TIFF_PHOTOMETRIC = 254, 256, 257, 262
_TIFF_ORIENTATION: Final = 274
_TIFF_NUMBERS: Final = {3: "H", 4: "L"}
_TIFF_STARTS: Final = (b"II*\0", b"MM\0*")


def is_image(content: bytes) -> bool:
    """Whether the first bytes are those of PNG, JPEG, TIFF or BMP."""
    return content.startswith((b"\x89PNG\r\n\x1a\n", b"\xff\xd8\xff", *_TIFF_STARTS)) or _is_bitmap(
        content
    )


def _is_bitmap(content: bytes) -> bool:
    # "BM" alone would also be text; the header that follows has one of a few lengths
    return content.startswith(b"BM") and content[14:18] in _BITMAP_HEADERS


def image_size(content: bytes, name: str) -> tuple[int, int]:
    """Return width and height of a PNG, JPEG, TIFF or BMP as it is shown, px.

    The size is that after the rotation that a camera states (Exif).

    Parameters
    ----------
    content
        The whole file.
    name
        The file's name, for errors.

    Raises
    ------
    MediaError
        If it is none of these, is cut off, or has more than `MAX_PIXELS`.
    """
    try:
        size = _size(content)
    except (struct.error, IndexError):
        size = None
    if size is None or not is_whole(content):
        if is_image(content):
            raise MediaError("the picture is damaged or cut off; copy it again", file=name)
        raise MediaError("is no PNG, JPEG, TIFF or BMP; convert it to one of them", file=name)
    width, height = size
    check_size(width, height, name)
    return width, height


def check_size(width: int, height: int, name: str) -> None:
    """Refuse an impossible size of a picture.

    Raises
    ------
    MediaError
        If there are no pixels, or more than `MAX_PIXELS`, or a side is longer than `MAX_SIDE`.
    """
    if width <= 0 or height <= 0:
        fault = "it is damaged"
    elif width * height > MAX_PIXELS:
        fault = f"at most {MAX_PIXELS // 10**6} megapixels are read: scale it down"
    elif max(width, height) > MAX_SIDE:
        fault = f"at most {MAX_SIDE:,} px a side are read"
    else:
        return
    raise MediaError(f"states a size of {width} x {height} px; {fault}", file=name)


def is_whole(content: bytes) -> bool:
    """Whether a picture is complete. Formats other than PNG and JPEG are trusted."""
    if content.startswith(b"\x89PNG"):
        # the decoder takes as much memory as a part states, before it finds that there is less
        return any(kind == b"IEND" for kind, _ in _png_parts(content))
    if content.startswith(b"\xff\xd8"):
        return b"\xff\xd9" in content[-(1 << 16) :]
    return True


def _png_parts(content: bytes) -> Iterator[tuple[bytes, slice]]:
    """Yield kind and content of the parts of a PNG, each as long as it states."""
    position = 8
    while position + 12 <= len(content):  # a step per part
        n_bytes = int.from_bytes(content[position : position + 4], "big")
        yield content[position + 4 : position + 8], slice(position + 8, position + 8 + n_bytes)
        position += 12 + n_bytes


def _size(content: bytes) -> tuple[int, int] | None:
    if content.startswith(b"\x89PNG\r\n\x1a\n"):
        return _png_size(content)
    if content.startswith(b"\xff\xd8\xff"):
        return _jpeg_size(content)
    if content.startswith(_TIFF_STARTS):
        page, _ = _tiff_page(content, struct.unpack_from(_order(content) + "L", content, 4)[0])
        return None if page is None else (page.width, page.height)
    if _is_bitmap(content):
        if content[14] == 12:  # the oldest header has short numbers
            return struct.unpack_from("<2H", content, 18)
        width, height = struct.unpack_from("<2l", content, 18)
        return width, abs(height)
    return None


def _jpeg_size(content: bytes) -> tuple[int, int] | None:
    position, is_turned = 2, False
    while position + 9 <= len(content):  # a step per segment, before the picture's data
        if content[position] != 0xFF:
            return None
        marker = content[position + 1]
        if marker == 0xFF:  # padding
            position += 1
        elif marker in _WITHOUT_LENGTH:
            position += 2
        elif marker in _START_OF_FRAME:
            height, width = struct.unpack_from(">2H", content, position + 5)
            return (height, width) if is_turned else (width, height)
        else:
            n_bytes = int.from_bytes(content[position + 2 : position + 4], "big")
            if marker == 0xE1 and content[position + 4 : position + 10] == b"Exif\0\0":
                is_turned = _lies_on_its_side(content[position + 10 : position + 2 + n_bytes])
            position += 2 + n_bytes
    return None


def _png_size(content: bytes) -> tuple[int, int] | None:
    if content[12:16] != b"IHDR":
        return None
    width, height = struct.unpack_from(">2L", content, 16)
    for kind, place in _png_parts(content):
        if kind == b"eXIf":
            return (height, width) if _lies_on_its_side(content[place]) else (width, height)
    return width, height


def _lies_on_its_side(exif: bytes) -> bool:
    """Whether the camera says that it was turned by a quarter, as the decoder obeys it."""
    try:
        start = struct.unpack_from(_order(exif) + "L", exif, 4)[0]
        return _tags(exif, start)[0].get(_TIFF_ORIENTATION, 1) >= 5
    except struct.error:
        return False


@dataclass(frozen=True)
class TiffPage:
    """Picture in a TIFF.

    Attributes
    ----------
    start
        Position of its list of tags in the file, bytes.
    width, height
        Size as it is shown, px.
    is_white_zero
        Whether 0 is white, as in the negative.
    is_extra
        Whether it is a smaller copy of another page, or a mask.
    """

    start: int
    width: int
    height: int
    is_white_zero: bool
    is_extra: bool


def tiff_pages(content: bytes, most: int | None = None) -> list[TiffPage]:
    """Return the pages of a TIFF that are pictures of the commonest size, or of the largest such.

    A file of many such pages is a recording, and pages of other sizes are previews. A file that is
    damaged or no TIFF has none.

    Parameters
    ----------
    most
        Number of pages to look at; None: all.
    """
    pages: list[TiffPage] = []
    if not content.startswith(_TIFF_STARTS):
        return pages
    seen: set[int] = set()
    n_bytes = 0
    try:
        start = struct.unpack_from(_order(content) + "L", content, 4)[0]
        # a step per page; lists of tags that overlap or go round would never end
        while start and start not in seen and n_bytes <= len(content) and len(seen) != most:
            seen.add(start)
            page, following = _tiff_page(content, start)
            n_bytes += 6 + 12 * struct.unpack_from(_order(content) + "H", content, start)[0]
            start = following
            if page is not None:
                pages.append(page)
    except struct.error:
        pass  # the pages before can be read
    pages = [page for page in pages if not page.is_extra]
    sizes = Counter((page.width, page.height) for page in pages)
    usual = max(sizes, key=lambda size: (sizes[size], size[0] * size[1]), default=None)
    return [page for page in pages if (page.width, page.height) == usual]


def with_first_page(content: bytes, page: TiffPage) -> bytes:
    """Return the TIFF with this page as its first, the one that is decoded."""
    return content[:4] + struct.pack(_order(content) + "L", page.start) + content[8:]


def _order(content: bytes) -> str:
    return "<" if content[:1] == b"I" else ">"


def _tags(content: bytes, start: int) -> tuple[dict[int, int], int]:
    """Return the values of the tags in the list at `start`, and the position of the next list."""
    order = _order(content)
    n_tags = struct.unpack_from(order + "H", content, start)[0]
    values: dict[int, int] = {}
    for number in range(n_tags):  # at most 65535 tags
        entry = start + 2 + 12 * number
        tag, kind = struct.unpack_from(order + "2H", content, entry)
        if kind in _TIFF_NUMBERS:
            values[tag] = struct.unpack_from(order + _TIFF_NUMBERS[kind], content, entry + 8)[0]
    end = start + 2 + 12 * n_tags
    return values, int.from_bytes(content[end : end + 4], "little" if order == "<" else "big")


def _tiff_page(content: bytes, start: int) -> tuple[TiffPage | None, int]:
    """Return the page with tags at `start`, None without a size, and the position of the next."""
    values, following = _tags(content, start)
    sides = [values.get(_TIFF_WIDTH), values.get(_TIFF_HEIGHT)]
    width, height = sides[::-1] if values.get(_TIFF_ORIENTATION, 1) >= 5 else sides
    if width is None or height is None:
        return None, following
    is_white_zero = values.get(_TIFF_PHOTOMETRIC) == 0
    is_extra = bool(values.get(_TIFF_KIND, 0) & 5)
    return TiffPage(start, width, height, is_white_zero, is_extra), following
