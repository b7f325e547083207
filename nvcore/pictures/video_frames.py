"""List the pictures of a video from its packets or, if unreliable, by decoding it once."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

import av
import numpy as np
from numpy.typing import NDArray

from nvcore.common.errors import MediaError
from nvcore.pictures.containers import (
    DAMAGED,
    REORDERED,
    is_cut_off,
    open_container,
    picture_streams,
)
from nvcore.pictures.notes import MOST_PLACES, PictureNote, PictureTrait

NOT_WHOLE: Final = 0.25
"""Largest deviation of a time from a whole number of steps, as a share of a step."""
_UNEVEN: Final = 0.1
"""Share of uneven steps above which the rate counts as varying."""
_SAME_RATE: Final = 1e-3
_WIDE_GAP: Final = 1.5
"""Multiple of the usual step above which a step is a gap."""
_UNCODED_BYTES: Final = 19
"""Size of the largest packet of MPEG-4 that may hold no picture of its own."""
_UNKNOWN: Final = int(np.iinfo(np.int64).min)
"""Stands for a missing presentation time."""
_PACKET: Final = np.dtype(
    [
        ("shown_at", np.int64),  # presentation time, or _UNKNOWN
        ("decoded_at", np.int64),  # decoding time, or the number of the packet
        ("is_key", np.bool_),
        # a key picture that can be sought: MPEG need not say the time of one within a part
        ("is_place", np.bool_),
        ("is_hidden", np.bool_),  # decoded but not shown
    ]
)


@dataclass(frozen=True)
class PictureTable:
    """The pictures of a video.

    Attributes
    ----------
    times
        Presentation times, sorted, all different; int64, shape (n,).
    keys, key_seeks
        Positions in `times` at which decoding can begin, and the time to seek for each; int64.
    is_sure
        True if decoded pictures carry these times. Otherwise, they are only counted.
    shown
        Position in `times` of picture 0, 1, ..., as shown; int64.
    times_s
        Time of each shown picture, s after the first; None if not `is_sure`.
    fps
        Frame rate, 1/s; None: not stated.
    notes
        Unusual facts about the video.
    """

    times: NDArray[np.int64]
    keys: NDArray[np.int64]
    key_seeks: NDArray[np.int64]
    is_sure: bool
    shown: NDArray[np.int64]
    times_s: NDArray[np.floating] | None
    fps: float | None
    notes: tuple[PictureNote, ...]


def list_pictures(
    path: Path, container_format: str, name: str, *, must_decode: bool = False
) -> PictureTable:
    """List the pictures of a file, decoding it only where packets may not be pictures.

    Parameters
    ----------
    must_decode
        True to list only the pictures that the decoder gives.

    Raises
    ------
    MediaError
        If there is no picture.
    av.error.FFmpegError
        If the file is damaged.
    """
    container, stream = open_container(path, container_format, name)
    with container:
        packets, are_pictures, is_cut = _read_packets(container, stream)
        codec, n_stated, tick_s = stream.codec_context, stream.frames, float(stream.time_base or 1)
        is_reordered = bool(codec.has_b_frames)
        fps = float(stream.average_rate or 0) or None
        others = tuple(
            f"{other.codec_context.name} {other.width} x {other.height}"
            for other in picture_streams(container)[1:]
            if other.codec_context is not None
        )
    if container_format != "mov" or not n_stated:
        is_cut = is_cut or is_cut_off(path, container_format)
    elif n_stated != len(packets):
        # an edit list shows samples twice or leaves them out: they are in the file all the same
        is_cut = is_cut or _n_packets(path, container_format, name) < n_stated
    # AVI has no presentation times: with reordered pictures they are guesses
    is_avi = container_format == "avi"
    is_guess = is_avi and is_reordered and codec.name in ("h264", "hevc")
    is_shown, is_leading = _shown_packets(packets)
    is_sure, n_listed, rate_of_codec = not is_guess, len(packets), None
    if must_decode or (time_notes(packets.decoded_at) if is_guess else not are_pictures):
        given = _decoded_times(path, container_format, name)
        _, firsts = np.unique(packets.shown_at, return_index=True)  # fields may have the same time
        is_shown &= np.isin(np.arange(len(packets)), firsts) & np.isin(packets.shown_at, given)
        n_listed = len(given)
        if codec.name == "h264":  # the container may count fields
            rate_of_codec = float(codec.framerate or 0) or None
        is_sure = is_sure and bool(n_listed == is_shown.sum() and (np.diff(given) > 0).all())
    if is_sure:
        n_listed = int(np.count_nonzero(is_shown))
        moments = np.sort(packets.decoded_at[is_shown | is_leading])[is_leading.sum() :]
        if is_cut or not (is_avi or n_stated):  # else the file is complete, and a gap is no loss
            is_shown &= packets.shown_at < _end_of_certainty(packets, is_shown, is_cut=is_cut)
        times = np.sort(packets.shown_at[is_shown])
        is_cut = is_cut or len(times) < n_listed
    else:
        moments = np.sort(packets.decoded_at)
        # among the last ones of a cut file a lost one may be missing
        times = np.arange(n_listed - REORDERED if is_cut else n_listed)
    if not len(times):
        raise MediaError(f"holds no picture that can be read: it {DAMAGED}", file=name)

    shown, times_s, chunks = np.arange(len(times)), None, None
    notes: list[PictureNote] = []
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
        if rate_of_codec or not any(note.trait is PictureTrait.UNEVEN for note in notes):
            fps = rate_of_codec or frame_rate(usual_step(moments) * tick_s, fps)
    elif is_guess:
        notes += time_notes(packets.decoded_at)
    if is_cut:
        n_total = n_stated
        if n_stated and is_sure and not is_avi:  # those never shown are stated, too
            n_total = max(0, n_stated - len(packets) + n_listed)
        notes.insert(0, PictureNote(PictureTrait.CUT, len(shown), n_total))
    if others:
        notes.append(PictureNote(PictureTrait.OTHER_STREAMS, len(others), names=others))
    keys, seeks = _keys(packets, is_shown & is_sure, times, container_format)
    return PictureTable(times, keys, seeks, is_sure, shown, times_s, fps, tuple(notes))


def _read_packets(container: Any, stream: Any) -> tuple[Any, bool, bool]:
    """Read the packets with pictures, in the order of decoding, as far as the file can be read.

    Returns
    -------
    tuple
        A record array of `_PACKET`. True if each shown packet seems to be a picture: all have
        presentation times, which nearly follow the order of decoding. MPEG-4 must also begin with a
        key picture, and have no packet so small that its picture may lie in the one before, or
        repeat it. True if the file ends early.
    """
    coding, are_pictures, is_partial = stream.codec_context.name, True, False
    is_stream = container.format.name in ("mpeg", "mpegts")
    rows: list[tuple[int, int, bool, bool, bool]] = []
    partial: list[bool] = []
    try:
        for packet in container.demux(stream):  # a step per picture: the demuxer's way
            if not packet.size:
                continue
            is_hidden, is_key = packet.is_discard, packet.is_keyframe
            if coding == "mpeg4":  # its decoder begins before the first key picture, at other times
                are_pictures &= packet.size > _UNCODED_BYTES and (is_key or bool(rows))
            elif coding == "vp8":  # some pictures only help to decode others, as this bit says
                is_hidden = is_hidden or not memoryview(packet)[0] & 16
            shown_at = _UNKNOWN if packet.pts is None else packet.pts
            decoded_at = len(rows) if packet.dts is None else packet.dts
            is_place = is_key and (not is_stream or packet.pos is not None)
            rows.append((shown_at, decoded_at, is_key, is_place, is_hidden))
            partial.append(packet.is_corrupt)
    except av.error.FFmpegError:
        is_partial = True
    if any(partial[-2:]):  # the file ends within the last packet, or within what it lies in
        is_partial = True
        rows.pop()
    packets = np.array(rows, _PACKET).view(np.recarray)
    times = packets.shown_at[~packets.is_hidden]
    order = np.argsort(times)  # joined files may begin again with earlier times
    are_pictures = (
        are_pictures
        and _UNKNOWN not in times
        and bool((np.abs(order - np.arange(len(order))) <= REORDERED).all())
    )
    return packets, are_pictures, is_partial


def _shown_packets(packets: Any) -> tuple[NDArray[np.bool_], NDArray[np.bool_]]:
    """Return which packets are shown, and which follow the first key picture but are not.

    A picture that is shown before the first key picture cannot be decoded, and no program counts
    it.
    """
    is_shown: NDArray[np.bool_] = ~packets.is_hidden
    if not packets.is_key.any():
        return is_shown, np.zeros_like(is_shown)
    start = int(np.argmax(packets.is_key))
    is_shown[:start] = False
    is_before = packets.shown_at < packets.shown_at[start]
    return is_shown & ~is_before, is_shown & is_before


def _keys(
    packets: Any, is_shown: NDArray[np.bool_], times: NDArray[np.int64], container_format: str
) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Return the first position that each key picture opens, ascending, and the time to seek.

    A hidden key picture is none of those shown, but they are decoded from it. Pictures that are
    decoded after it and shown before it need an earlier one as well.
    """
    is_place = packets.is_place & (is_shown | packets.is_hidden)  # no second field of a key picture
    starts = np.flatnonzero(is_place)
    key_of = np.maximum.accumulate(np.where(is_place, np.arange(len(packets)), 0))
    is_of_key = is_shown & (packets.shown_at >= packets.shown_at[key_of])
    never = np.iinfo(np.int64).max
    first = np.minimum.reduceat(np.where(is_of_key, packets.shown_at, never), starts)
    is_used = first < never
    keys = np.searchsorted(times, first[is_used])
    # the index of Matroska holds presentation times
    seeks = (packets.shown_at if container_format == "matroska" else packets.decoded_at)[starts]
    order = np.argsort(keys, kind="stable")
    return keys[order], seeks[is_used][order]


def _chunks(
    occupied: NDArray[np.int64], n_stated: int
) -> tuple[NDArray[np.int64], NDArray[np.int64]] | None:
    """Return the picture of each chunk of an AVI, and which chunks are empty.

    An empty chunk repeats the picture before. Chunks before the first picture and after the last
    one are counted if the file states as many. None if most are empty: these fill a rate that was
    never that of the pictures.

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
    """Count the packets of an MP4 or MOV without its edit list."""
    container, stream = open_container(path, container_format, name, advanced_editlist="0")
    n_packets = 0
    with container, suppress(av.error.FFmpegError):
        for packet in container.demux(stream):
            n_packets += packet.size > 0
    return n_packets


def _decoded_times(path: Path, container_format: str, name: str) -> NDArray[np.int64]:
    """Return the presentation times of the pictures that the decoder gives, in its order."""
    container, stream = open_container(path, container_format, name)
    times: list[int] = []
    with container, suppress(av.error.FFmpegError):  # as far as the file can be read
        for frame in decoded(container, stream):
            times.append(_UNKNOWN if frame.pts is None else frame.pts)
    return np.array(times, np.int64)


def decoded(container: Any, stream: Any) -> Iterator[Any]:
    """Yield all frames from here on, but for those of damaged packets."""
    for packet in container.demux(stream):
        try:
            yield from packet.decode()
        except av.error.InvalidDataError:
            continue


def _end_of_certainty(packets: Any, is_shown: NDArray[np.bool_], *, is_cut: bool) -> int:
    """Return the presentation time from which on pictures may be missing.

    In a file that is cut off, pictures may be missing among those shown after the last decoding
    time. In other files, a gap there counts as such a loss if all other steps are regular.
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


def usual_step(times: NDArray[np.int64]) -> float:
    """Return the commonest step between times, or 0 if there is none.

    It is the mean of the steps near the median: gaps do not lengthen it, and containers round each.
    """
    steps = np.sort(np.diff(times.astype(np.float64)))  # damaged files state times of 63 bit
    median = steps[(len(steps) - 1) // 2] if len(steps) else 0
    if median <= 0:
        return 0.0
    return float(steps[np.abs(steps - median) <= NOT_WHOLE * median].mean())


def time_notes(times: NDArray[np.int64]) -> tuple[PictureNote, ...]:
    """Note that pictures are missing by the times, or that the rate varies.

    Times that go back give no note.
    """
    step, steps = usual_step(times), np.diff(times.astype(np.float64))
    if not step or (steps <= 0).any():
        return ()
    passed = steps / step
    whole = np.rint(passed)
    n_beside = int(np.count_nonzero((np.abs(passed - whole) > NOT_WHOLE) | (whole < 1)))
    if n_beside > _UNEVEN * len(passed):
        return (PictureNote(PictureTrait.UNEVEN, n_beside, len(passed)),)
    after = np.flatnonzero(whole > 1)
    if not len(after):
        return ()
    n_missing = int(whole[after].sum()) - len(after)
    places = tuple(int(place) + 1 for place in after[:MOST_PLACES])
    return (PictureNote(PictureTrait.GAP, n_missing, len(times) + n_missing, places),)


def frame_rate(step_s: float, stated: float | None) -> float | None:
    """Return the rate by the commonest step, or the stated one if it agrees or the step is 0."""
    if not step_s:
        return stated
    rate = 1 / step_s
    if stated and abs(stated / rate - 1) < _SAME_RATE:
        return stated
    # times are rounded in a container: rates are whole, or those of colour television
    near = [usual for usual in (round(rate), round(rate * 1.001) / 1.001) if usual]
    nearest = min(near, key=lambda usual: abs(usual - rate), default=rate)
    return float(nearest) if abs(nearest / rate - 1) < _SAME_RATE / 2 else rate
