"""Video containers: which are opened, how, and what pictures they list.

Only plain containers are opened, by the format that their first bytes show and with no protocol
but the file's own: a playlist or script, whatever its name, never makes the program read another
file or the network.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

import av
import numpy as np
from numpy.typing import NDArray

from nvcore.errors import MediaError
from nvcore.pictures.base import first_bytes
from nvcore.pictures.header import MAX_PIXELS, check_size

DAMAGED: Final = "is damaged or no such video; copy or convert it again (MP4 with H.264 is sure)"
_OPTIONS: Final = {"protocol_whitelist": "file", "max_pixels": str(MAX_PIXELS)}
_MP4_BOXES: Final = frozenset({b"ftyp", b"moov", b"mdat", b"free", b"skip", b"wide", b"pnot"})
REORDERED: Final = 16
"""Most pictures by which the order of decoding and the order of showing differ."""
_LOOKED_AT: Final = 512
_WIDE_GAP: Final = 1.5
"""Times the usual step from which on a step is a gap."""


def video_format(content: bytes) -> str | None:
    """The container's format by its first bytes (at least 400); None if it is none of those read.

    MP4 and MOV, Matroska and WebM, AVI, MPEG transport and program stream.
    """
    if content[4:8] in _MP4_BOXES:
        return "mov"
    if content.startswith(b"\x1a\x45\xdf\xa3"):
        return "matroska"
    if content.startswith(b"RIFF") and content[8:12] == b"AVI ":
        return "avi"
    if content.startswith(b"\0\0\1\xba"):
        return "mpeg"
    for start, step in ((0, 188), (4, 192)):
        if all(
            content[position : position + 1] == b"\x47"
            for position in range(start, start + 2 * step + 1, step)
        ):
            return "mpegts"
    return None


def format_of_file(path: Path, name: str) -> str:
    """`video_format` of a file.

    Raises
    ------
    MediaError
        If it cannot be opened or is no video of these formats.
    """
    container_format = video_format(first_bytes(path, _LOOKED_AT, name))
    if container_format is None:
        raise MediaError(
            "is no video that can be read, whatever its name says; expected MP4, MOV, "
            "Matroska, WebM, AVI or MPEG",
            file=name,
        )
    return container_format


def open_container(path: Path, container_format: str, name: str) -> tuple[Any, Any]:
    """The open container and its first stream of pictures.

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
        options=dict(_OPTIONS),
        metadata_errors="replace",  # a title in another encoding is no damage
    )
    try:
        streams = [
            stream
            for stream in container.streams.video
            if not stream.disposition & av.stream.Disposition.attached_pic
        ]
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


@dataclass(frozen=True)
class PictureTable:
    """Which pictures there are.

    Attributes
    ----------
    times
        Presentation times, sorted, all different; int64, shape (n,).
    keys, key_seeks
        Positions of the key pictures in `times`, and what to seek for each; int64.
    is_sure
        Whether decoded pictures carry these times.
    is_cut
        Whether the file ends early, or some of its pictures are missing.
    n_stated
        Number of pictures that the file states, 0: it states none.
    """

    times: NDArray[np.int64]
    keys: NDArray[np.int64]
    key_seeks: NDArray[np.int64]
    is_sure: bool
    is_cut: bool
    n_stated: int


def is_cut_off(path: Path, container_format: str) -> bool:
    """Whether the file is shorter than it says; only for Matroska, whose packets do not show it."""
    if container_format != "matroska":
        return False
    with path.open("rb") as file:
        head = file.read(_LOOKED_AT)
    position = head.find(b"\x18\x53\x80\x67") + 4  # the segment, which holds all that follows
    if position < 4 or len(head) < position + 8 or not head[position]:
        return False
    n_bytes = 9 - head[position].bit_length()  # the size says its own length by its leading zeros
    size = int.from_bytes(head[position : position + n_bytes], "big") - (1 << 7 * n_bytes)
    is_known = size != (1 << 7 * n_bytes) - 1
    return is_known and position + n_bytes + size > path.stat().st_size


def list_pictures(
    container: Any, stream: Any, container_format: str, name: str, *, is_cut: bool
) -> PictureTable:
    """The pictures of a stream that was just opened, from its packets; nothing is decoded.

    Parameters
    ----------
    is_cut
        Whether the file is known to end early.

    Raises
    ------
    MediaError
        If there is none.
    """
    n_left_out, rows = 0, []
    is_partial: list[bool] = []
    try:
        for packet in container.demux(stream):  # a step per picture: the demuxer's way
            if packet.size and packet.is_discard:
                n_left_out += 1
            elif packet.size:
                rows.append((packet.pts, packet.dts, packet.is_keyframe))
                is_partial.append(packet.is_corrupt)
    except av.error.FFmpegError:
        is_cut = True
    if any(is_partial[-2:]):  # the file ends within the last packet, or within what it lies in
        is_cut = True
        rows.pop()
    n_stated = stream.frames - n_left_out if stream.frames else 0
    is_cut = is_cut or len(rows) < n_stated
    # AVI has no presentation times: with reordered pictures they are guesses
    is_sure = not (
        container_format == "avi"
        and stream.codec_context.has_b_frames
        and stream.codec_context.name in ("h264", "hevc")
    )
    shown_at = [n if pts is None else pts for n, (pts, _, _) in enumerate(rows)]
    decoded_at = [n if dts is None else dts for n, (_, dts, _) in enumerate(rows)]
    times, seeks = np.array(shown_at, dtype=np.int64), np.array(decoded_at, dtype=np.int64)
    is_key = np.array([key for _, _, key in rows], dtype=bool)
    is_sure = is_sure and len(np.unique(times)) == len(rows)
    is_sure = is_sure and all(pts is not None for pts, _, _ in rows)
    if is_sure and is_key.any():
        # what comes before the first key picture cannot be decoded, and no program counts it
        start = int(np.argmax(is_key))
        is_whole = (np.arange(len(times)) >= start) & (times >= times[start])
        times, seeks, is_key = times[is_whole], seeks[is_whole], is_key[is_whole]
        n_stated = max(0, n_stated - int(np.count_nonzero(~is_whole)))
    if is_sure and len(times):
        end = _end_of_certainty(times, int(seeks[-1]), is_cut=is_cut)
        is_cut = is_cut or end <= times.max()
        is_whole = times < end
        times, seeks, is_key = times[is_whole], seeks[is_whole], is_key[is_whole]
    if is_cut and not is_sure:
        # counted pictures: among the last ones a lost one may be missing
        times, seeks, is_key = times[:-REORDERED], seeks[:-REORDERED], is_key[:-REORDERED]
    if not len(times):
        raise MediaError(f"holds no picture that can be read: it {DAMAGED}", file=name)
    if container_format == "matroska":  # its index has presentation times
        seeks = times
    order = np.argsort(times, kind="stable") if is_sure else np.arange(len(times))
    keys = np.flatnonzero(is_key[order])
    return PictureTable(times[order], keys, seeks[order][keys], is_sure, is_cut, n_stated)


def _end_of_certainty(times: NDArray[np.int64], last_decoded: int, *, is_cut: bool) -> int:
    """Presentation time from which on pictures may be missing, and others be taken for them.

    Of a file that is cut off, that is what is shown after the last picture was to be decoded: lost
    ones may come before it. Where nothing says that it is cut, a gap there counts, if all other
    steps are regular.
    """
    display_times = np.sort(times)
    if is_cut:
        return last_decoded + 1
    gaps = np.diff(display_times)
    is_wide = gaps > _WIDE_GAP * np.median(gaps) if len(gaps) else np.zeros(0, dtype=bool)
    is_tail = display_times[1:] > last_decoded
    if (is_wide & ~is_tail).any() or not is_wide.any():
        return int(display_times[-1]) + 1
    return int(display_times[1:][is_wide][0])
