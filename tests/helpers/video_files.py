"""Videos as cameras, phones and editors write them: edit lists, fields, packed and empty chunks."""

from __future__ import annotations

import re
import struct
from collections.abc import Callable, Collection, Sequence
from fractions import Fraction
from pathlib import Path

import av
from picture_files import WIDTH, numbered


def remux(
    path: Path, to: Path, change: Callable[[av.Packet], bool] = lambda _: True, **options: str
) -> Path:
    """The packets in another container; `change` works on each and says whether it stays."""
    with av.open(str(path)) as old, av.open(str(to), "w", options=options) as new:
        stream = new.add_stream_from_template(old.streams.video[0])
        for packet in old.demux(old.streams.video[0]):
            if packet.dts is not None and change(packet):
                packet.stream = stream
                new.mux(packet)
    return to


def hiding(path: Path, to: Path, number: int) -> Path:
    """The VP8 video whose picture of this number is decoded and not shown."""
    with av.open(str(path)) as old, av.open(str(to), "w") as new:
        stream = new.add_stream_from_template(old.streams.video[0])
        for at, packet in enumerate(old.demux(old.streams.video[0])):
            if packet.dts is None:
                continue
            content = bytearray(bytes(packet))
            content[0] &= ~16 if at == number else ~0
            copy = av.Packet(bytes(content))
            copy.pts, copy.dts, copy.is_keyframe = packet.pts, packet.dts, packet.is_keyframe
            copy.time_base, copy.stream = packet.time_base, stream
            new.mux(copy)
    return to


def cut_without_reencoding(path: Path, to: Path, first: int) -> Path:
    """Shown from picture `first` on; those needed to decode it are in the file, hidden."""
    with av.open(str(path)) as video:
        stream = video.streams.video[0]
        step = int(1 / (stream.average_rate * stream.time_base))
        keys = [packet.pts for packet in video.demux(stream) if packet.is_keyframe]
    key = max(time for time in keys if time is not None and time <= first * step)
    started = []

    def shift(packet: av.Packet) -> bool:
        if packet.pts == key:
            started.append(key)
        packet.pts, packet.dts = packet.pts - first * step, packet.dts - first * step
        return bool(started)

    return remux(path, to, shift)


def edited(path: Path, edits: Sequence[tuple[int, int | None]]) -> Path:
    """The MP4 or MOV with this edit list: how many pictures from which on; None: of nothing."""

    def rewrite(content: bytes) -> bytes:
        parts, start = [], 0
        while start < len(content):
            size = int.from_bytes(content[start : start + 4])
            kind, inner = content[start + 4 : start + 8], content[start + 8 : start + size]
            start += size
            if kind in (b"moov", b"trak", b"edts"):
                inner = rewrite(inner)
            if kind == b"elst":
                n_ticks, delay = 512, int.from_bytes(inner[12:16])  # 1/20 s; up to the first one
                inner = struct.pack(">II", 0, len(edits)) + b"".join(
                    struct.pack(">iiI", n * 50, -1 if at is None else at * n_ticks + delay, 1 << 16)
                    for n, at in edits
                )
            parts.append(struct.pack(">I", 8 + len(inner)) + kind + inner)
        return b"".join(parts)

    path.write_bytes(rewrite(path.read_bytes()))
    return path


def rewrite_chunks(path: Path, change: Callable[[list[bytes]], list[bytes]]) -> Path:
    """The AVI with other contents of its chunks of pictures, and an index of these."""
    content = path.read_bytes()
    movi = content.index(b"movi") + 4
    at, end = movi, movi + int.from_bytes(content[movi - 8 : movi - 4], "little") - 4
    chunks = []
    while at < end:
        size = int.from_bytes(content[at + 4 : at + 8], "little")
        chunks += [content[at + 8 : at + 8 + size]] if content[at : at + 4] == b"00dc" else []
        at += 8 + size + size % 2
    parts, index = [b"movi"], []
    for chunk in change(chunks):
        index.append(struct.pack("<4s3I", b"00dc", 16, sum(map(len, parts)), len(chunk)))
        parts.append(struct.pack("<4sI", b"00dc", len(chunk)) + chunk + bytes(len(chunk) % 2))
    listed, entries = b"".join(parts), b"".join(index)
    body = content[8 : movi - 12] + struct.pack("<4sI", b"LIST", len(listed)) + listed
    body += struct.pack("<4sI", b"idx1", len(entries)) + entries
    path.write_bytes(struct.pack("<4sI", b"RIFF", len(body)) + body)
    return path


def with_empty_chunks(path: Path, empty: Collection[int]) -> Path:
    """The AVI as a recorder writes it that missed these pictures."""
    return rewrite_chunks(
        path, lambda chunks: [b"" if n in empty else chunk for n, chunk in enumerate(chunks)]
    )


UNCODED = bytes.fromhex("000001b6504f")
"""A picture of MPEG-4 (times in 20ths) that says: show the one before again."""


def with_uncoded_pictures(path: Path, uncoded: Collection[int]) -> Path:
    """The MPEG-4 AVI as an encoder writes it that drops these pictures."""
    return rewrite_chunks(
        path, lambda chunks: [UNCODED if n in uncoded else chunk for n, chunk in enumerate(chunks)]
    )


def with_packed_pictures(path: Path) -> Path:
    """The MPEG-4 AVI as XviD writes it: a B-picture lies in the chunk of what it refers to."""

    def pack(chunks: list[bytes]) -> list[bytes]:
        packed: list[bytes] = []
        for chunk in chunks:
            at = chunk.index(b"\0\0\1\xb6")
            if chunk[at + 4] >> 6 == 2:  # a B-picture
                packed[-1] += chunk
                packed.append(UNCODED)
            else:
                user = b"\0\0\1\xb2DivX503b1393p" if not packed else b""
                packed.append(chunk[:at] + user + chunk[at:])
        return packed

    return rewrite_chunks(path, pack)


def _ue(number: int) -> str:
    digits = f"{number + 1:b}"
    return "0" * (len(digits) - 1) + digits


def _unit(head: int, bits: str, content: bytes = b"") -> bytes:
    """A unit of H.264: bits, then zeros up to a whole byte, then content and the end mark."""
    if not content:
        bits += "1"
    bits += "0" * (-len(bits) % 8)
    payload = int(bits, 2).to_bytes(len(bits) // 8) + (content and content + b"\x80")
    return b"\0\0\1" + bytes([head]) + re.sub(rb"\0\0(?=[\0-\3])", b"\0\0\3", payload)


def field_pictures(
    path: Path,
    n: int = 24,
    *,
    packets: str = "both times",
    whole: Collection[int] = (),
    per_second: int = 50,
) -> Path:
    """H.264 of n numbered frames, each two pictures: one of its even and one of its odd lines.

    No encoder at hand writes it: each block of 16 x 16 samples stands in it uncompressed.
    `packets` have both their times, the first of two has ("first time"), both have one ("same
    time"), or both are in one ("joined"). Frames that are `whole` are one picture. The container
    counts so many fields `per_second`, the stream 50.
    """
    across, down = WIDTH // 16, 2  # blocks of a field
    sequence = "01001101" + "0" * 8 + f"{30:08b}" + _ue(0) + _ue(0) + _ue(2) + _ue(1) + "0"
    sequence += _ue(across - 1) + _ue(down - 1) + "00" + "1" + "0"
    sequence += "1" + "0000" + f"1{1:032b}{50:032b}1" + "0000"  # 50 fields per second
    picture = _ue(0) + _ue(0) + "00" + _ue(0) + _ue(0) + _ue(0) + "000" + "1" * 3 + "000"
    headers = _unit(0x67, sequence) + _unit(0x68, picture)
    pictures: list[tuple[int, bytes]] = []  # half frames before each, and its content
    for frame in range(n):
        row = numbered(frame)[:1].clip(16, 235)
        blocks = [
            bytes(row[:, 16 * column : 16 * column + 16].repeat(16, 0)) + b"\x80" * 128
            for column in range(across)
        ]
        for field in (None,) if frame in whole else (0, 1):
            is_first = frame == 0 and not field
            slices = _ue(0) + _ue(7) + _ue(0) + f"{frame % 16:04b}"
            slices += "0" if field is None else f"1{field}"
            slices += (_ue(0) + "00" if is_first else "0") + _ue(0) + _ue(25)
            # the kind of block, filled up to whole bytes
            content = b"\x0d\0".join(blocks * (2 * down if field is None else down))
            coded = _unit(0x65 if is_first else 0x61, slices, content)
            pictures.append((2 * frame + (field or 0), (b"" if field else headers) + coded))
    if packets == "joined":
        halves = [content for _, content in pictures]
        joined = map(b"".join, zip(halves[::2], halves[1::2], strict=True))
        pictures = [(2 * frame, content) for frame, content in enumerate(joined)]
    raw = path.with_suffix(".h264")
    raw.write_bytes(b"".join(content for _, content in pictures))
    with av.open(str(raw), format="h264") as old, av.open(str(path), "w") as new:
        stream = new.add_stream_from_template(old.streams.video[0])
        ends = [*(at for at, _ in pictures[1:]), 2 * n]
        for (at, content), end in zip(pictures, ends, strict=True):
            packet = av.Packet(content)
            packet.stream, packet.time_base = stream, Fraction(1, per_second)
            packet.duration, packet.pts, packet.dts = end - at, at, at
            if packets == "first time" and at % 2:
                packet.pts = None
            if packets == "same time":
                packet.pts, packet.dts = at - at % 2, at - 1
            packet.is_keyframe = at == 0
            new.mux(packet)
    return path
