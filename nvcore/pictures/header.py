"""The size that a picture's header states, read before anything is decoded.

By hand, since what stands here must accept exactly the files that OpenCV decodes. Pillow, the
library for this, refuses TIFFs of temperatures (float64, and float32 or int16 of several
channels), warns about TIFF tags that it does not know, and has one limit of pixels for the whole
process, beyond which it does not give the size. The tests compare the sizes with what Pillow
wrote and what OpenCV decodes.
"""

from __future__ import annotations

import struct
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

_TIFF_WIDTH: Final = 256
_TIFF_HEIGHT: Final = 257
_TIFF_NUMBERS: Final = {3: "H", 4: "L"}


def is_image(content: bytes) -> bool:
    """Whether the first bytes are those of PNG, JPEG, TIFF or BMP."""
    return content.startswith(
        (b"\x89PNG\r\n\x1a\n", b"\xff\xd8\xff", b"II*\0", b"MM\0*")
    ) or _is_bitmap(content)


def _is_bitmap(content: bytes) -> bool:
    # "BM" alone would also be text; the header that follows has one of a few lengths
    return content.startswith(b"BM") and content[14:18] in _BITMAP_HEADERS


def image_size(content: bytes, name: str) -> tuple[int, int]:
    """Width and height of a PNG, JPEG, TIFF or BMP, px.

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
        return _has_whole_chunks(content)
    if content.startswith(b"\xff\xd8"):
        return b"\xff\xd9" in content[-(1 << 16) :]
    return True


def _has_whole_chunks(content: bytes) -> bool:
    """Whether the parts of a PNG, each as long as it states, end with its end mark.

    The decoder takes as much memory as a part states, before it finds that there is less.
    """
    position = 8
    while position + 12 <= len(content):  # a step per part
        if content[position + 4 : position + 8] == b"IEND":
            return True
        position += 12 + int.from_bytes(content[position : position + 4], "big")
    return False


def _size(content: bytes) -> tuple[int, int] | None:
    if content.startswith(b"\x89PNG\r\n\x1a\n"):
        return struct.unpack_from(">2L", content, 16) if content[12:16] == b"IHDR" else None
    if content.startswith(b"\xff\xd8\xff"):
        return _jpeg_size(content)
    if content.startswith((b"II*\0", b"MM\0*")):
        return _tiff_size(content, "<" if content[:1] == b"I" else ">")
    if _is_bitmap(content):
        if content[14] == 12:  # the oldest header has short numbers
            return struct.unpack_from("<2H", content, 18)
        width, height = struct.unpack_from("<2l", content, 18)
        return width, abs(height)
    return None


def _jpeg_size(content: bytes) -> tuple[int, int] | None:
    position = 2
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
            return width, height
        else:
            position += 2 + int.from_bytes(content[position + 2 : position + 4], "big")
    return None


def _tiff_size(content: bytes, order: str) -> tuple[int, int] | None:
    start = struct.unpack_from(order + "L", content, 4)[0]
    n_tags = struct.unpack_from(order + "H", content, start)[0]
    sizes: dict[int, int] = {}
    for number in range(n_tags):  # at most 65535 tags
        entry = start + 2 + 12 * number
        tag, kind = struct.unpack_from(order + "2H", content, entry)
        if tag in (_TIFF_WIDTH, _TIFF_HEIGHT):
            if kind not in _TIFF_NUMBERS:
                return None
            sizes[tag] = struct.unpack_from(order + _TIFF_NUMBERS[kind], content, entry + 8)[0]
    return (sizes[_TIFF_WIDTH], sizes[_TIFF_HEIGHT]) if len(sizes) == 2 else None
