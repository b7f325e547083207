"""Number of samples that an MP4 or MOV states, read before a demuxer takes memory for each.

A few bytes can state millions. The demuxer makes an entry for each, whether the file holds it or
not.
"""

from __future__ import annotations

import struct
from collections.abc import Iterator
from pathlib import Path
from typing import BinaryIO, Final

from nvcore.errors import MediaError

MOST_SAMPLES: Final = 10_000_000
"""Largest number of samples: two days of pictures at 60 a second, 0.6 GB of entries."""
_DEEPEST: Final = 10
"""Depth of boxes up to which the demuxer follows them."""
_CONTAINERS: Final = frozenset(
    b"moov trak mdia minf stbl moof traf mvex edts udta dinf tref wave gmhd".split()
)
_EXTENDED: Final = 16
"""Bytes of the head of a box with a size of eight bytes."""


def check_samples(path: Path, name: str) -> None:
    """Refuse a file that states more samples than are worth their memory.

    Raises
    ------
    MediaError
        If they are more than `MOST_SAMPLES`, stated in a compressed header, or nowhere.
    """
    with path.open("rb") as file:
        end = file.seek(0, 2)
        if all(kind != b"moov" for kind, _, _ in _boxes(file, 0, end)):
            raise MediaError(
                "has no table of contents (moov): the recording was not closed, as when the power "
                "fails, or the file is cut off. A repair tool such as untrunc may mend it with a "
                "whole recording of the same camera; a recorder that writes Matroska or fragmented "
                "MP4 loses only the end",
                file=name,
            )
        n_samples = _count(file, 0, end, end, name, 0)
    if n_samples > MOST_SAMPLES:
        raise MediaError(
            f"states {n_samples:,} pictures and sounds, at most {MOST_SAMPLES:,} are read; copy or "
            "convert it again, in parts if it is so long",
            file=name,
        )


def is_short(path: Path) -> bool:
    """Whether the file ends within a box of pictures or of a fragment's tables."""
    with path.open("rb") as file:
        end = file.seek(0, 2)
        return any(
            stop > end for kind, _, stop in _boxes(file, 0, end) if kind in (b"moof", b"mdat")
        )


def _count(file: BinaryIO, start: int, end: int, file_size: int, name: str, depth: int) -> int:
    """Count the samples that the boxes of a part of the file state, and the boxes within them."""
    n_samples, n_alike, has_unit_steps = 0, 0, False
    for kind, content, stop in _boxes(file, start, end):
        if kind in _CONTAINERS and depth < _DEEPEST:
            n_samples += _count(file, content, min(stop, end), file_size, name, depth + 1)
        elif kind == b"stsz":
            size, number = _numbers(file, content + 4, 2)
            is_there = 0 < size * number <= file_size  # all of one size, and the file holds them
            n_alike += number if is_there else 0
            n_samples += 0 if is_there else number
        elif kind == b"stts":
            n_entries, _, step = _numbers(file, content + 4, 3)
            has_unit_steps = (n_entries, step) == (1, 1)
        elif kind == b"trun":
            n_samples += _numbers(file, content + 4, 1)[0]
        elif kind == b"cmov":
            raise MediaError(
                "has a compressed header, which is not read; convert it (MP4 with H.264 is sure)",
                file=name,
            )
    # uncompressed sound, of which the demuxer lists no single samples, has steps of one
    return n_samples + (0 if has_unit_steps else n_alike)


def _boxes(file: BinaryIO, start: int, end: int) -> Iterator[tuple[bytes, int, int]]:
    """Yield kind, start and end of the content of each box in a part of the file, as stated."""
    while start + 8 <= end:
        file.seek(start)
        head = file.read(_EXTENDED).ljust(_EXTENDED, b"\0")
        size, kind, long_size = struct.unpack(">I4sQ", head)
        n_head = _EXTENDED if size == 1 else 8
        size = {0: end - start, 1: long_size}.get(size, size)  # 0: up to the end
        if size < n_head:
            return
        yield kind, start + n_head, start + size
        start += size


def _numbers(file: BinaryIO, start: int, n: int) -> tuple[int, ...]:
    """Read `n` numbers of four bytes, 0 beyond the end of the file."""
    file.seek(start)
    return struct.unpack(f">{n}I", file.read(4 * n).ljust(4 * n, b"\0"))
