"""The kind of a file: a binary one from its first bytes, a picture from its name."""

from __future__ import annotations

from typing import Final

IMAGE_SUFFIXES: Final = frozenset({".png", ".jpg", ".jpeg", ".tif", ".tiff", ".bmp"})
"""Endings by which pictures are picked from a folder or an archive."""

_MAGIC: Final[tuple[tuple[int, bytes, str], ...]] = (
    (0, b"\x89PNG", "a PNG picture"),
    (0, b"\xff\xd8\xff", "a JPEG picture"),
    (0, b"GIF8", "a GIF picture"),
    (0, b"II*\x00", "a TIFF picture"),
    (0, b"MM\x00*", "a TIFF picture"),
    (8, b"WEBP", "a WebP picture"),
    (8, b"AVI ", "an AVI video"),
    (4, b"ftyp", "an MP4 video"),
    (0, b"\x1aE\xdf\xa3", "a Matroska or WebM video"),
    (0, b"#ROSBAG", "a ROS bag"),
    (0, b"PK\x03\x04", "a ZIP archive (or a spreadsheet): unpack it, or save it as CSV"),
    (0, b"\x1f\x8b", "a gzip archive: unpack it"),
    (0, b"7z\xbc\xaf", "a 7-Zip archive: unpack it"),
    (0, b"%PDF", "a PDF document"),
    (0, b"\x89HDF", "an HDF5 file: export it as CSV"),
    (0, b"MATLAB ", "a MATLAB file: export it as CSV"),
    (0, b"PAR1", "a Parquet table: export it as CSV"),
    (0, b"\x93NUMPY", "a NumPy array: export it as CSV"),
    (0, b"SQLite format 3", "an SQLite database: export it as CSV"),
    (0, b"\xff\xfe", "UTF-16 text: save it as UTF-8"),
    (0, b"\xfe\xff", "UTF-16 text: save it as UTF-8"),
)
"""Offset, the bytes there, and the kind of such a file."""

_BYTES_CHECKED: Final = 4096


def binary_kind(content: bytes) -> str | None:
    r"""What kind of binary file this is, with an article; None if it may be text.

    Parameters
    ----------
    content
        The file's content, or its beginning.

    Examples
    --------
    >>> binary_kind(b"\x89PNG\r\n")
    'a PNG picture'
    >>> binary_kind(b"frame,x,y,w,h") is None
    True
    """
    for offset, magic, kind in _MAGIC:
        if content.startswith(magic, offset):
            return kind
    return "a binary file" if b"\x00" in content[:_BYTES_CHECKED] else None
