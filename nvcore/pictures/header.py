"""The size that a picture's header states, read before anything is decoded.

By hand, since what stands here must accept exactly the files that OpenCV decodes. Pillow, the
library for this, refuses TIFFs of temperatures (float64, and float32 or int16 of several
channels), warns about TIFF tags that it does not know, and has one limit of pixels for the whole
process, beyond which it does not give the size. The tests compare the sizes with what Pillow
wrote and what OpenCV decodes.
"""

from __future__ import annotations

import struct
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Final

from nvcore.errors import MediaError

MAX_PIXELS: Final = 100_000_000
"""Pictures of more pixels are refused: no camera of these drives makes them."""
MAX_SIDE: Final = 65_500
"""Wider or taller ones cannot be sent to a browser as JPEG, px."""

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
    """Width and height of a PNG, JPEG, TIFF or BMP as it is shown, px.

    A camera that was turned says so in the file (Exif).

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
        raise MediaError(f"states a size of {width} x {height} px; it is damaged", file=name)
    if width * height > MAX_PIXELS:
        raise MediaError(
            f"states a size of {width} x {height} px; at most {MAX_PIXELS // 10**6} megapixels "
            "are read: scale it down",
            file=name,
        )
    if max(width, height) > MAX_SIDE:
        raise MediaError(
            f"states a size of {width} x {height} px; at most {MAX_SIDE:,} px a side are read",
            file=name,
        )


def is_whole(content: bytes) -> bool:
    """Whether a PNG or JPEG is complete; other formats are trusted."""
    if content.startswith(b"\x89PNG"):
        # The decoder takes as much memory as a part states, before it finds that there is less.
        return any(kind == b"IEND" for kind, _ in _png_parts(content))
    if content.startswith(b"\xff\xd8"):
        return b"\xff\xd9" in content[-(1 << 16) :]
    return True


def _png_parts(content: bytes) -> Iterator[tuple[bytes, slice]]:
    """Kind and content of the parts of a PNG, each as long as it states."""
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
    """One of the pictures in a TIFF.

    Attributes
    ----------
    start
        Where its list of tags lies in the file, bytes.
    width, height
        Its size as it is shown, px.
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
    """The pages of a TIFF that are pictures of the commonest size; empty: it is none, or damaged.

    A file of many such pages is a recording; pages of other sizes are previews. Of sizes that are
    equally common, the largest.

    Parameters
    ----------
    most
        Pages to look at; None: all.
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
    """The TIFF with this page as its first, the one that is decoded."""
    return content[:4] + struct.pack(_order(content) + "L", page.start) + content[8:]


def _order(content: bytes) -> str:
    return "<" if content[:1] == b"I" else ">"


def _tags(content: bytes, start: int) -> tuple[dict[int, int], int]:
    """Values of the tags in the list that lies there, and where the next list lies."""
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
    """The page whose tags lie there, None without a size, and where those of the next one lie."""
    values, following = _tags(content, start)
    if _TIFF_WIDTH not in values or _TIFF_HEIGHT not in values:
        return None, following
    width, height = values[_TIFF_WIDTH], values[_TIFF_HEIGHT]
    is_turned = values.get(_TIFF_ORIENTATION, 1) >= 5
    page = TiffPage(
        start,
        height if is_turned else width,
        width if is_turned else height,
        is_white_zero=values.get(_TIFF_PHOTOMETRIC) == 0,
        is_extra=bool(values.get(_TIFF_KIND, 0) & 5),
    )
    return page, following
