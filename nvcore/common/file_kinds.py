"""Kind of a file: binary and compressed files by their first bytes, pictures by their name."""

from __future__ import annotations

import re
import unicodedata
from contextlib import suppress
from pathlib import Path, PurePath
from typing import Final

IMAGE_SUFFIXES: Final = frozenset({".png", ".jpg", ".jpeg", ".tif", ".tiff", ".bmp"})
"""Suffixes of pictures in a folder or an archive."""

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
    (0, b"\x89MCAP0", "an MCAP recording: export its boxes as CSV"),
    (0, b"PK\x03\x04", "a ZIP archive (or a spreadsheet): unpack it, or save it as CSV"),
    (0, b"\x1f\x8b", "a file packed by gzip: unpack it"),
    (0, b"\xfd7zXZ\x00", "a file packed by xz: unpack it"),
    (0, b"\x28\xb5\x2f\xfd", "a file packed by Zstandard: unpack it"),
    (0, b"7z\xbc\xaf", "a 7-Zip archive: unpack it"),
    (257, b"ustar", "a tar archive: unpack it"),
    (0, b"%PDF", "a PDF document"),
    (0, b"\x89HDF", "an HDF5 file: export it as CSV"),
    (0, b"MATLAB ", "a MATLAB file: export it as CSV"),
    (0, b"PAR1", "a Parquet table"),
    (0, b"PARE", "an encrypted Parquet table"),
    (0, b"\x93NUMPY", "a NumPy array: export it as CSV"),
    (0, b"SQLite format 3", "an SQLite database: export it as CSV"),
    (0, b"\xff\xfe", "UTF-16 text: save it as UTF-8"),
    (0, b"\xfe\xff", "UTF-16 text: save it as UTF-8"),
)
"""Offset, the bytes there, and the kind of such a file."""

_BYTES_CHECKED: Final = 4096

PACKED_ENDINGS: Final = (".gz", ".bz2", ".xz", ".zst")
"""Suffixes of compressed files, after that of their content: ``truth.csv.gz``."""

_PACKED: Final[dict[str, re.Pattern[bytes]]] = {
    "gzip": re.compile(rb"\x1f\x8b\x08"),
    "bz2": re.compile(rb"BZh[1-9](?:1AY&SY|\x17rE8P\x90)"),
    "xz": re.compile(rb"\xfd7zXZ\x00"),
    "zstd": re.compile(rb"\x28\xb5\x2f\xfd|[\x50-\x5f]\x2a\x4d\x18"),
}
PACKED_HEAD_BYTES: Final = 10


def packed_by(head: bytes) -> str | None:
    r"""Return the compression of a file by its first bytes, or None if it is not compressed.

    Examples
    --------
    >>> packed_by(b"\x1f\x8b\x08\x00")
    'gzip'
    >>> packed_by(b"frame,x,y,w,h") is None
    True
    """
    return next((kind for kind, magic in _PACKED.items() if magic.match(head)), None)


def unpacked_name(name: str) -> str:
    """Return the name of a file without the suffix of its compression.

    Examples
    --------
    >>> unpacked_name("night/truth.csv.gz"), unpacked_name("truth.csv")
    ('night/truth.csv', 'truth.csv')
    """
    lowered = name.lower()
    if not lowered.endswith(PACKED_ENDINGS):
        return name
    return name[: -len(next(end for end in PACKED_ENDINGS if lowered.endswith(end)))]


def suffix_of(path: PurePath) -> str:
    """Return the suffix of a file's content in lower case, or "" if it has none.

    Examples
    --------
    >>> suffix_of(PurePath("night/truth.CSV.gz"))
    '.csv'
    """
    return PurePath(unpacked_name(path.name)).suffix.lower()


def binary_kind(content: bytes) -> str | None:
    r"""Return the kind of a binary file, with an article, or None if it may be text.

    Parameters
    ----------
    content
        Content of the file, or its beginning.

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


def composed(name: str) -> str:
    """Normalise a name for comparison: a Mac stores an accent as a character after its letter.

    Examples
    --------
    >>> composed("Nacht_fu\u0308nf") == "Nacht_f\u00fcnf"
    True
    """
    return unicodedata.normalize("NFC", name)


def as_stored(path: Path) -> Path:
    """Return the path of the file or folder with this name, with accents as they are stored.

    If there is none, the path is returned unchanged.
    """
    with suppress(OSError, ValueError):  # a name that no file can have
        if path.exists():
            return path
        stored = Path(path.anchor)
        for part in path.parts[1 if path.anchor else 0 :]:
            stored = stored / part
            if not stored.exists():
                siblings = {composed(file.name): file for file in stored.parent.iterdir()}
                stored = siblings.get(composed(part), stored)
        return stored
    return path
