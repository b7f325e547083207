"""Files packed in the ways that are read."""

from __future__ import annotations

import bz2
import gzip
import lzma
from collections.abc import Callable
from typing import Final

import pyarrow as pa


def zstd(content: bytes) -> bytes:
    """The content as Zstandard's command line packs it: its size is not stated."""
    packed = pa.BufferOutputStream()
    with pa.CompressedOutputStream(packed, "zstd") as stream:
        stream.write(content)
    return packed.getvalue().to_pybytes()


PACK: Final[dict[str, Callable[[bytes], bytes]]] = {
    ".gz": gzip.compress,
    ".bz2": bz2.compress,
    ".xz": lambda content: lzma.compress(content, preset=0),  # others ask for much memory
    ".zst": zstd,
}
"""What packs a content, by the ending of such files."""
