"""Contents packed as the name of their file asks for."""

from __future__ import annotations

import lzma

import pyarrow as pa

_CODECS = {".gz": "gzip", ".bz2": "bz2", ".zst": "zstd"}


def packed_as(name: str, content: bytes) -> bytes:
    """The content, packed by gzip, bzip2, xz or Zstandard if the name ends so."""
    ending = name[name.rfind(".") :].lower()
    if ending == ".xz":
        return lzma.compress(content)
    if ending not in _CODECS:
        return content
    packed = pa.BufferOutputStream()
    with pa.CompressedOutputStream(packed, _CODECS[ending]) as stream:
        stream.write(content)
    result: bytes = packed.getvalue().to_pybytes()
    return result
