"""Which pictures a video holds, by its packets; where these do not tell, by decoding it once."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

import av
import numpy as np
from numpy.typing import NDArray

from nvcore.errors import MediaError
from nvcore.pictures.containers import (
    DAMAGED,
    REORDERED,
    is_cut_off,
    open_container,
    picture_streams,
)
from nvcore.pictures.mp4 import is_short
from nvcore.pictures.notes import MOST_PLACES, PictureNote, PictureTrait
from nvcore.pictures.timing import frame_rate, time_notes, usual_step

_WIDE_GAP: Final = 1.5
"""Times the usual step from which on a step is a gap."""
_UNCODED_BYTES: Final = 19
"""Size of the largest packet of MPEG-4 that may hold no picture of its own."""
_UNKNOWN: Final = int(np.iinfo(np.int64).min)
"""Stands for a presentation time that is missing."""


@dataclass(frozen=True)
class PictureTable:
    """Which pictures there are.

    Attributes
    ----------
    times
        Presentation times, sorted, all different; int64, shape (n,).
    keys, key_seeks
        Where decoding can begin, as positions in `times`, and what to seek for each; int64.
    is_sure
        Whether decoded pictures carry these times; if not, they are only counted.
    shown
        Position in `times` of what is shown as picture 0, 1, ...; int64.
    times_s
        When each of these is shown, s after the first; None if not `is_sure`.
    fps
        Frame rate, 1/s; None: not stated.
    notes
        What is unusual.
    """

    times: NDArray[np.int64]
    keys: NDArray[np.int64]
    key_seeks: NDArray[np.int64]
    is_sure: bool
    shown: NDArray[np.int64]
    times_s: NDArray[np.floating] | None
    fps: float | None
    notes: tuple[PictureNote, ...]


@dataclass(frozen=True)
class _Packets:
    """Packets with pictures, in the order of decoding; n of them.

    Attributes
    ----------
    shown_at, decoded_at
        Presentation times, `_UNKNOWN` where they are missing, and decoding times, where they are
        missing the number of the packet; int64.
    is_key, is_place, is_hidden
        Key pictures; those of them that can be sought: MPEG need not say the time of a picture that
        begins within a part; pictures that are decoded but not shown.
    are_pictures
        Whether each packet shown seems to be a picture: all have presentation times, which differ
        and nearly follow the order of decoding. Not where MPEG-4 begins without a key picture, or
        where a packet is so small that its picture may lie in the one before, or be that one again.
    is_partial
        Whether the file ends early.
    """

    shown_at: NDArray[np.int64]
    decoded_at: NDArray[np.int64]
    is_key: NDArray[np.bool_]
    is_place: NDArray[np.bool_]
    is_hidden: NDArray[np.bool_]
    are_pictures: bool
    is_partial: bool


def list_pictures(
    path: Path, container_format: str, name: str, *, must_decode: bool = False
) -> PictureTable:
    """The pictures of a file; it is decoded only where its packets may not be its pictures.

    Parameters
    ----------
    must_decode
        Whether to list only what the decoder gives.

    Raises
    ------
    MediaError
        If there is none.
    av.error.FFmpegError
        If the file is damaged.
    """
    container, stream = open_container(path, container_format, name)
    with container:
        packets = _read_packets(container, stream)
        codec, n_stated, tick_s = stream.codec_context, stream.frames, float(stream.time_base or 1)
        is_reordered = bool(codec.has_b_frames)
        fps = float(stream.average_rate or 0) or None
        # AVI has no presentation times: with reordered pictures they are guesses
        is_avi = container_format == "avi"
        is_guess = is_avi and is_reordered and codec.name in ("h264", "hevc")
        others = tuple(
            f"{other.codec_context.name} {other.width} x {other.height}"
            for other in picture_streams(container)[1:]
            if other.codec_context is not None
        )
    is_cut = packets.is_partial or is_cut_off(path, container_format)
    if container_format == "mov" and not n_stated:
        is_cut = is_cut or is_short(path)
    elif container_format == "mov" and n_stated != len(packets.is_key):
        # an edit list shows samples twice or leaves them out: they are in the file all the same
        is_cut = is_cut or _n_packets(path, container_format, name) < n_stated
    keys = seeks = np.empty(0, np.int64)
    is_sure, n_listed = not is_guess, len(packets.shown_at)
    is_shown, is_leading = _is_shown(packets)
    fps_of_frames = None
    if must_decode or (
        len(time_notes(packets.decoded_at)) if is_guess else not packets.are_pictures
    ):
        given = _decoded_times(path, container_format, name)
        is_given = np.isin(packets.shown_at, given)
        if codec.name == "h264" and (is_shown & ~is_given).any():  # the container counts fields
            fps_of_frames = float(codec.framerate or 0) or None
        is_shown, n_listed = is_shown & is_given, len(given)
        is_sure = is_sure and bool(n_listed == is_shown.sum() and (np.diff(given) > 0).all())
    if is_sure:
        n_listed = int(np.count_nonzero(is_shown))
        moments = np.sort(packets.decoded_at[is_shown | is_leading])[is_leading.sum() :]
        if is_cut or not (is_avi or n_stated):  # else all is there, and a gap is no loss
            is_shown &= packets.shown_at < _end_of_certainty(packets, is_shown, is_cut=is_cut)
        times = np.sort(packets.shown_at[is_shown])
        is_cut = is_cut or len(times) < n_listed
        keys, seeks = _keys(packets, is_shown, times, by_shown=container_format == "matroska")
    else:
        moments = np.sort(packets.decoded_at)
        # among the last ones of a cut file a lost one may be missing
        times = np.arange(n_listed - REORDERED if is_cut else n_listed)
    if not len(times):
        raise MediaError(f"holds no picture that can be read: it {DAMAGED}", file=name)

    shown, times_s, notes = np.arange(len(times)), None, []
    chunks = None
    if is_avi and (is_sure or is_guess) and len(moments) == n_listed:
        # the time of decoding is the number of the chunk, that of showing a guess
        moments = moments[: len(times)]
        if is_reordered and len(moments) > 1:  # some encoders fill their delay behind the first one
            moments[0] = moments[1] - 1
        is_whole = not is_cut and moments[0] == packets.decoded_at[0]
        chunks = _chunks(moments, n_stated if is_whole else 0)
    if chunks is not None:
        shown, empty = chunks
        times_s = np.arange(len(shown)) * tick_s if is_sure else None
        if len(empty):
            places = tuple(map(int, empty[:MOST_PLACES]))
            notes.append(PictureNote(PictureTrait.REPEATED, len(empty), len(shown), places))
    elif is_sure:
        moments = moments if is_avi else times
        times_s = (moments - moments[0]) * tick_s
        notes += time_notes(moments)
        is_even = not any(note.trait is PictureTrait.UNEVEN for note in notes)
        if fps_of_frames or is_even:
            fps = fps_of_frames or frame_rate(usual_step(moments) * tick_s, fps)
    elif is_guess:
        notes += time_notes(packets.decoded_at)
    if is_cut:
        n_total = n_stated
        if n_stated and is_sure and not is_avi:  # those never shown are stated, too
            n_total = max(0, n_stated - len(packets.is_key) + n_listed)
        notes.insert(0, PictureNote(PictureTrait.CUT, len(shown), n_total))
    if others:
        notes.append(PictureNote(PictureTrait.OTHER_STREAMS, len(others), names=others))
    return PictureTable(times, keys, seeks, is_sure, shown, times_s, fps, tuple(notes))


def _read_packets(container: Any, stream: Any) -> _Packets:
    """As far as the file can be read; of the two fields of a frame only the first."""
    coding = stream.codec_context.name
    is_mpeg4, is_vp8, is_partial, are_pictures = coding == "mpeg4", coding == "vp8", False, True
    is_stream = container.format.name in ("mpeg", "mpegts")
    rows: list[tuple[int | None, int | None, bool, bool, bool]] = []
    partial: list[bool] = []
    try:
        for packet in container.demux(stream):  # a step per picture: the demuxer's way
            size = packet.size
            if not size:
                continue
            is_hidden, is_key = packet.is_discard, packet.is_keyframe
            if is_mpeg4:  # its decoder begins before the first key picture, with other times
                are_pictures &= size > _UNCODED_BYTES and (is_key or bool(rows))
            elif is_vp8:  # some pictures only help to decode others, as this bit says
                is_hidden = is_hidden or not memoryview(packet)[0] & 16
            is_place = is_key and (not is_stream or packet.pos is not None)
            rows.append((packet.pts, packet.dts, is_key, is_place, is_hidden))
            partial.append(packet.is_corrupt)
    except av.error.FFmpegError:
        is_partial = True
    if any(partial[-2:]):  # the file ends within the last packet, or within what it lies in
        is_partial = True
        rows.pop()
    shown_at = np.array([_UNKNOWN if row[0] is None else row[0] for row in rows], np.int64)
    is_hidden = np.array([row[4] for row in rows], bool)
    order = np.argsort(shown_at[~is_hidden])  # joined files may begin again with earlier times
    return _Packets(
        shown_at,
        np.array([n if row[1] is None else row[1] for n, row in enumerate(rows)], np.int64),
        np.array([row[2] for row in rows], bool),
        np.array([row[3] for row in rows], bool),
        is_hidden,
        are_pictures
        and _UNKNOWN not in shown_at[~is_hidden]
        and bool((np.diff(shown_at[~is_hidden][order]) > 0).all())
        and bool((np.abs(order - np.arange(len(order))) <= REORDERED).all()),
        is_partial,
    )


def _is_shown(packets: _Packets) -> tuple[NDArray[np.bool_], NDArray[np.bool_]]:
    """Which packets' pictures are shown, and which lie behind the first key picture's and are not.

    Not what is shown before that one: it cannot be decoded, and no program counts it.
    """
    is_shown: NDArray[np.bool_] = ~packets.is_hidden
    if not packets.is_key.any():
        return is_shown, np.zeros_like(is_shown)
    start = int(np.argmax(packets.is_key))
    is_shown[:start] = False
    is_before = (packets.shown_at < packets.shown_at[start]) & (packets.shown_at != _UNKNOWN)
    return is_shown & ~is_before, is_shown & is_before


def _keys(
    packets: _Packets, is_shown: NDArray[np.bool_], times: NDArray[np.int64], *, by_shown: bool
) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """First position that can be decoded from each key picture, ascending, and what to seek.

    A hidden key picture is none of those shown, but they are decoded from it. Pictures that are
    decoded after it and shown before it need an earlier one as well.

    Parameters
    ----------
    by_shown
        Whether the file's index has presentation times.
    """
    is_place = packets.is_place & (is_shown | packets.is_hidden)  # no second field of a key picture
    group = np.cumsum(is_place) - 1
    key_times = packets.shown_at[is_place]
    is_of_key = is_shown & (group >= 0)
    is_of_key[is_of_key] = packets.shown_at[is_of_key] >= key_times[group[is_of_key]]
    never = np.iinfo(np.int64).max
    first = np.full(len(key_times), never)
    np.minimum.at(first, group[is_of_key], packets.shown_at[is_of_key])
    is_used = first < never
    keys = np.searchsorted(times, first[is_used])
    seeks = (packets.shown_at if by_shown else packets.decoded_at)[is_place][is_used]
    order = np.argsort(keys, kind="stable")
    return keys[order], seeks[order]


def _chunks(
    occupied: NDArray[np.int64], n_stated: int
) -> tuple[NDArray[np.int64], NDArray[np.int64]] | None:
    """Picture of each chunk of an AVI, of an empty one the picture before; and which are empty.

    Chunks before the first picture and after the last one are counted if the file states as many.
    None: most are empty, which fill a rate that was never that of the pictures.

    Parameters
    ----------
    occupied
        Numbers of the chunks with a picture, ascending.
    """
    end = int(occupied[-1]) + 1
    start = 0 if end <= n_stated else int(occupied[0])
    if end < n_stated <= 2 * end:  # else the number is no more than a wish
        end = n_stated
    if end - start > 2 * len(occupied):
        return None
    chunks = np.arange(start, end)
    shown = np.maximum(np.searchsorted(occupied, chunks, side="right") - 1, 0)
    return shown, np.flatnonzero(occupied[shown] != chunks)


def _n_packets(path: Path, container_format: str, name: str) -> int:
    """Packets of an MP4 or MOV without its edit list."""
    container, stream = open_container(path, container_format, name, advanced_editlist="0")
    n_packets = 0
    with container, suppress(av.error.FFmpegError):
        for packet in container.demux(stream):
            n_packets += packet.size > 0
    return n_packets


def _decoded_times(path: Path, container_format: str, name: str) -> NDArray[np.int64]:
    """Presentation times of the pictures that the decoder gives, in its order."""
    container, stream = open_container(path, container_format, name)
    times: list[int] = []
    with container, suppress(av.error.FFmpegError):  # as far as the file can be read
        for frame in decoded(container, stream):
            times.append(_UNKNOWN if frame.pts is None else frame.pts)
    return np.array(times, np.int64)


def decoded(container: Any, stream: Any) -> Iterator[Any]:
    """All frames from here on; those of damaged packets are missing."""
    for packet in container.demux(stream):
        try:
            yield from packet.decode()
        except av.error.InvalidDataError:
            continue


def _end_of_certainty(packets: _Packets, is_shown: NDArray[np.bool_], *, is_cut: bool) -> int:
    """Presentation time from which on pictures may be missing, and others be taken for them.

    Of a file that is cut off, that is what is shown after the last picture was to be decoded: lost
    ones may come before it. Where nothing says that it is cut, a gap there counts, if all other
    steps are regular.
    """
    if not is_shown.any():
        return 0
    display_times, last_decoded = np.sort(packets.shown_at[is_shown]), int(packets.decoded_at[-1])
    if is_cut:
        return last_decoded + 1
    gaps = np.diff(display_times)
    is_wide = gaps > _WIDE_GAP * (np.median(gaps) if len(gaps) else 0)
    is_tail = display_times[1:] > last_decoded
    if (is_wide & ~is_tail).any() or not is_wide.any():
        return int(display_times[-1]) + 1
    return int(display_times[1:][is_wide][0])
