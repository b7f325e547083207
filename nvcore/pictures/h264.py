"""Field pictures of H.264: interlaced cameras write some frames as two pictures, one a packet.

A decoder gives one picture for both, at the time of the first. Only headers are read here.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Final, NamedTuple

_SLICES: Final = (1, 5)
_SEQUENCE: Final = 7
_HEADER_BYTES: Final = 24
"""Of a slice: enough for what comes before the field's parity."""
LOOKED_AT: Final = 4096
"""Bytes of a packet in which the first slice begins."""
_WITH_CHROMA: Final = frozenset({44, 83, 86, 100, 110, 118, 122, 128, 134, 135, 138, 139, 144, 244})
"""Profiles whose headers state how colours are sampled."""


class _Bits:
    """Reads numbers of some bits; beyond the end all bits are 0."""

    def __init__(self, content: bytes):
        content = content.replace(b"\0\0\3", b"\0\0")  # an encoder breaks up runs of zeros so
        self._digits = f"{int.from_bytes(content):0{8 * len(content)}b}"
        self._at = 0

    def fixed(self, n_bits: int) -> int:
        self._at += n_bits
        return int(self._digits[self._at - n_bits : self._at] or "0", 2)

    def variable(self) -> int:
        """An unsigned Exp-Golomb number; a signed one is as long."""
        end = self._digits.find("1", self._at)
        n_zeros = min(max(0, end - self._at), 32)
        self._at += n_zeros
        return self.fixed(n_zeros + 1) - 1


class _Sequence(NamedTuple):
    """What the header of a sequence says of its slices' headers."""

    may_be_fields: bool
    number_bits: int
    has_planes: bool


class _Field(NamedTuple):
    frame_number: int
    is_bottom: bool


class FieldPairs:
    """Tells which packets of an H.264 stream hold the second field of a frame."""

    def __init__(self, extradata: bytes):
        """Read the stream's headers: as in MP4 and Matroska, or with start codes."""
        self._size_bytes = 0
        self._first: _Field | None = None
        units = [*_after_start_codes(extradata)]
        if extradata[:1] == b"\1" and len(extradata) > 8:
            self._size_bytes = (extradata[4] & 3) + 1
            units = [extradata[8 : 8 + int.from_bytes(extradata[6:8])]]
        sequences = [_sequence(unit) for unit in units if unit and unit[0] & 31 == _SEQUENCE]
        self._sequence = sequences[-1] if sequences else None

    @property
    def may_occur(self) -> bool:
        """Whether the stream's headers allow for fields."""
        return self._sequence is not None and self._sequence.may_be_fields

    def is_second(self, packet: bytes) -> bool:
        """Whether the next packet of the stream completes the frame of the one before."""
        field, first = self._field(packet), self._first
        is_second = (
            field is not None
            and first is not None
            and field.frame_number == first.frame_number
            and field.is_bottom != first.is_bottom
        )
        self._first = None if is_second else field
        return is_second

    def _field(self, packet: bytes) -> _Field | None:
        """Of the first slice; None: it is of a whole frame."""
        units = _after_start_codes(packet)
        if self._size_bytes:
            units = _of_stated_size(packet, self._size_bytes)
        for unit in units:
            kind = unit[0] & 31 if unit else 0
            if kind == _SEQUENCE:
                self._sequence = _sequence(unit)
            if kind in _SLICES and self._sequence is not None:
                return _slice_field(unit, self._sequence)
        return None


def _after_start_codes(content: bytes) -> Iterator[bytes]:
    end = content.find(b"\0\0\1")
    while end >= 0:
        start = end + 3
        end = content.find(b"\0\0\1", start)
        yield content[start : end if end >= 0 else None]


def _of_stated_size(content: bytes, size_bytes: int) -> Iterator[bytes]:
    start = 0
    while start + size_bytes < len(content):
        size = int.from_bytes(content[start : start + size_bytes])
        yield content[start + size_bytes : start + size_bytes + size]
        start += size_bytes + size


def _slice_field(unit: bytes, sequence: _Sequence) -> _Field | None:
    """Clause 7.3.3 of H.264, up to `bottom_field_flag`."""
    bits = _Bits(unit[1:_HEADER_BYTES])
    for _ in range(3):  # first macroblock, kind of slice, parameters
        bits.variable()
    bits.fixed(2 * sequence.has_planes)
    number = bits.fixed(sequence.number_bits)
    is_field = sequence.may_be_fields and bits.fixed(1)
    return _Field(number, bool(bits.fixed(1))) if is_field else None


def _sequence(unit: bytes) -> _Sequence:
    """Clause 7.3.2.1.1 of H.264, up to `frame_mbs_only_flag`."""
    bits = _Bits(unit[1:])
    profile, _, _ = bits.fixed(8), bits.fixed(16), bits.variable()
    has_planes = False
    if profile in _WITH_CHROMA:
        chroma = bits.variable()
        has_planes = chroma == 3 and bool(bits.fixed(1))
        bits.variable(), bits.variable(), bits.fixed(1)
        if bits.fixed(1):
            for number in range(12 if chroma == 3 else 8):
                _pass_scaling_list(bits, 16 if number < 6 else 64)
    number_bits = bits.variable() + 4
    order = bits.variable()
    if order == 0:
        bits.variable()
    elif order == 1:
        bits.fixed(1), bits.variable(), bits.variable()
        for _ in range(min(bits.variable(), 255)):
            bits.variable()
    bits.variable(), bits.fixed(1), bits.variable(), bits.variable()
    return _Sequence(not bits.fixed(1), number_bits, has_planes)


def _pass_scaling_list(bits: _Bits, n: int) -> None:
    last = following = 8
    for _ in range(n if bits.fixed(1) else 0):
        if following:
            code = bits.variable()
            following = (last + ((code + 1) // 2 if code % 2 else -(code // 2))) % 256
        last = following or last
