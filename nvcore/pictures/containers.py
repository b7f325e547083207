"""Video containers: opened by content, and checked for size and completeness.

Only plain containers are opened, in the format that their first bytes show and with the protocol
for files alone. A playlist or script, whatever its name, never makes the program read another file
or the network. A few bytes of an MP4 or MOV can state millions of samples, and the demuxer takes
memory for each, so they are counted first.
"""

from __future__ import annotations

import struct
from collections.abc import Iterator
from pathlib import Path
from typing import Any, BinaryIO, Final

import av

from nvcore.common.errors import MediaError
from nvcore.pictures.header import MAX_PIXELS, check_size

DAMAGED: Final = "is damaged or no such video; copy or convert it again (MP4 with H.264 is sure)"
_OPTIONS: Final = {"protocol_whitelist": "file", "max_pixels": str(MAX_PIXELS)}
_MP4_BOXES: Final = frozenset({b"ftyp", b"moov", b"mdat", b"free", b"skip", b"wide", b"pnot"})
REORDERED: Final = 16
"""Largest difference between a picture's place in the order of decoding and of showing."""
_LOOKED_AT: Final = 512
MOST_SAMPLES: Final = 10_000_000
"""Largest number of samples: two days of pictures at 60 a second, 0.6 GB of entries."""
_DEEPEST: Final = 10
"""Depth of boxes up to which the demuxer follows them."""
_CONTAINERS: Final = frozenset(
    b"moov trak mdia minf stbl moof traf mvex edts udta dinf tref wave gmhd".split()
)
_EXTENDED: Final = 16
"""Bytes of the head of a box with a size of eight bytes."""


def video_format(content: bytes) -> str | None:
    """Return the container's format by its first bytes (at least 400), or None if not supported.

    Formats are MP4 and MOV, Matroska and WebM, AVI, MPEG transport and program stream.
    """
    if content[4:8] in _MP4_BOXES:
        return "mov"
    if content.startswith(b"\x1a\x45\xdf\xa3"):
        return "matroska"
    if content.startswith(b"RIFF") and content[8:12] == b"AVI ":
        return "avi"
    if content.startswith(b"\0\0\1\xba"):
        return "mpeg"
    is_transport = any(
        content[start : start + 2 * step + 1 : step] == b"GGG"
        for start, step in ((0, 188), (4, 192))
    )
    return "mpegts" if is_transport else None


def open_container(path: Path, container_format: str, name: str, **options: str) -> tuple[Any, Any]:
    """Open a container, and its first stream of pictures, by preference a default one.

    Parameters
    ----------
    options
        Options of the demuxer.

    Raises
    ------
    MediaError
        If there is no such stream, or its pictures are too large.
    av.error.FFmpegError
        If the file is damaged.
    """
    # "file:" and an absolute path: no part of the name is taken for a protocol
    container = av.open(
        f"file:{path.absolute()}",
        format=container_format,
        options=_OPTIONS | options,
        metadata_errors="replace",  # a title in another encoding is no damage
    )
    try:
        streams = picture_streams(container)
        if not streams:
            raise MediaError("holds no pictures, only sound or data", file=name)
        if streams[0].codec_context is None:
            raise MediaError(
                "its pictures are coded in a way that is not known here; convert it (MP4 with "
                "H.264 is sure)",
                file=name,
            )
        check_size(streams[0].width or 1, streams[0].height or 1, name)
    except MediaError:
        container.close()
        raise
    streams[0].codec_context.options = {"max_pixels": str(MAX_PIXELS)}
    return container, streams[0]


def picture_streams(container: Any) -> list[Any]:
    """Return the streams of pictures without title pictures, default ones first."""
    flags = av.stream.Disposition
    streams = [
        stream for stream in container.streams.video if not stream.disposition & flags.attached_pic
    ]
    return sorted(streams, key=lambda stream: not stream.disposition & flags.default)


def is_cut_off(path: Path, container_format: str) -> bool:
    """Whether a file is shorter than it states. Of an MP4 or MOV, only fragments are looked at."""
    file_size = path.stat().st_size
    with path.open("rb") as file:
        if container_format == "mov":
            return any(
                stop > file_size
                for kind, _, stop in _boxes(file, 0, file_size)
                if kind in (b"moof", b"mdat")
            )
        head = file.read(_LOOKED_AT)
        if container_format == "avi":  # parts one after another, each with its size
            end, part = 0, head
            while part[:4] == b"RIFF" and len(part) >= 8:
                end += 8 + int.from_bytes(part[4:8], "little")
                file.seek(end)
                part = file.read(8)
            return end > file_size
    position = head.find(b"\x18\x53\x80\x67") + 4  # the segment, which holds all that follows
    if container_format != "matroska" or position < 4:
        return False
    if len(head) < position + 8 or not head[position]:
        return False
    n_bytes = 9 - head[position].bit_length()  # the size says its own length by its leading zeros
    size = int.from_bytes(head[position : position + n_bytes], "big") - (1 << 7 * n_bytes)
    is_known = size != (1 << 7 * n_bytes) - 1
    return is_known and position + n_bytes + size > file_size


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
