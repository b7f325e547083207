"""Read files compressed by gzip, bzip2, xz or Zstandard, within limits of size."""

from __future__ import annotations

import io
import lzma
from collections.abc import Callable
from typing import Final, Protocol

import pyarrow as pa

MAX_UNPACKED_BYTES: Final = 1 << 31
"""Largest content of one packed file."""
MAX_RATIO: Final = 200
"""Largest compression ratio of content of more than `RATIO_FROM_BYTES`."""
RATIO_FROM_BYTES: Final = 1 << 26
_MAX_XZ_MEMORY: Final = 1 << 28
"""Memory limit in bytes. The strongest setting of xz needs 65 MiB."""
_CHUNK: Final = 1 << 20


class _Source(Protocol):
    def read(self, size: int, /) -> bytes: ...


class Unpacking(io.RawIOBase):
    """Decompressed content of a file, read once from its beginning.

    Reading raises the error that `fault` returns if the file is damaged or too large.
    """

    def __init__(
        self,
        packed: io.BufferedReader,
        kind: str,
        *,
        n_bytes: int,
        fault: Callable[[str], Exception],
    ):
        """Start decompressing a file.

        Parameters
        ----------
        packed
            The file, at its beginning.
        kind
            See `nvcore.common.file_kinds.packed_by`.
        n_bytes
            Its size.
        """
        super().__init__()
        is_xz = kind == "xz"
        self._source: _Source = _Xz(packed) if is_xz else pa.CompressedInputStream(packed, kind)
        self._kind, self._n_packed, self._fault = kind, n_bytes, fault
        self._n_unpacked = 0

    def readable(self) -> bool:
        """Return True."""
        return True

    def readinto(self, buffer: bytearray | memoryview) -> int:  # type: ignore[override]
        """Read up to a buffer's size, and return the number of bytes."""
        part = self._next(len(buffer))
        buffer[: len(part)] = part
        return len(part)

    def readall(self) -> bytes:
        """Return the rest of the content."""
        parts = []
        while part := self._next(_CHUNK):
            parts.append(part)
        return b"".join(parts)

    def _next(self, size: int) -> bytes:
        try:
            part = self._source.read(size)
        except (OSError, EOFError, lzma.LZMAError) as error:
            raise self._fault(
                f"expected a whole file packed by {self._kind}, found damaged or missing data "
                f"({error}); pack it anew, or give the unpacked file"
            ) from error
        self._n_unpacked += len(part)
        if self._n_unpacked > max(RATIO_FROM_BYTES, MAX_RATIO * self._n_packed):
            raise self._fault(
                f"unpacks to more than {MAX_RATIO} times its size, as annotations never do; "
                "expected text"
            )
        if self._n_unpacked > MAX_UNPACKED_BYTES:
            raise self._fault(
                f"unpacks to more than {MAX_UNPACKED_BYTES >> 30} GiB; give the unpacked file, or "
                "several smaller ones"
            )
        return part


class _Xz:
    """Content of an xz file of one or more streams without padding.

    Unlike `lzma.open`, it limits memory.
    """

    def __init__(self, packed: io.BufferedReader):
        self._packed, self._decoder = packed, self._new()

    @staticmethod
    def _new() -> lzma.LZMADecompressor:
        return lzma.LZMADecompressor(lzma.FORMAT_XZ, memlimit=_MAX_XZ_MEMORY)

    def read(self, size: int, /) -> bytes:
        while True:
            rest = b""
            if self._decoder.eof:
                rest = self._decoder.unused_data or self._packed.read(_CHUNK)
                if not rest:
                    return b""
                self._decoder = self._new()
            elif self._decoder.needs_input:
                rest = self._packed.read(_CHUNK)
                if not rest:
                    raise EOFError("the end is missing")
            if part := self._decoder.decompress(rest, max_length=size):
                return part
