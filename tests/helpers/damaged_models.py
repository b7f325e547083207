"""Model files whose members are changed and packed anew: behind a ZIP that is whole."""

from __future__ import annotations

import io
import json
import zipfile
from collections.abc import Iterator
from typing import Any

import numpy as np

ODD = (None, True, "x", -1, 0.5, 10**400, 1e308, [], [0.5], [[1]], {}, {"a": 1})
"""Values in place of others."""
HEADERS = (b"(" * 118, b"{" * 118, b"-" * 117 + b"1", b"{'descr': '|O', ".ljust(118))
"""In place of the facts of an array; Python, were they read as such, or none."""


def members(content: bytes) -> dict[str, bytes]:
    """The files of an archive, by name."""
    with zipfile.ZipFile(io.BytesIO(content)) as archive:
        return {name: archive.read(name) for name in archive.namelist()}


def packed(files: dict[str, bytes]) -> bytes:
    """An archive of these files."""
    stream = io.BytesIO()
    with zipfile.ZipFile(stream, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, content in files.items():
            archive.writestr(name, content)
    return stream.getvalue()


def npy(array: np.ndarray, **more: bool) -> bytes:
    """An array as a file."""
    stream = io.BytesIO()
    np.lib.format.write_array(stream, array, version=(1, 0), **more)
    return stream.getvalue()


def about_of(files: dict[str, bytes]) -> Any:
    """The JSON of a model."""
    return json.loads(np.lib.format.read_array(io.BytesIO(files["about.npy"])).tobytes())


def with_about(files: dict[str, bytes], about: Any) -> dict[str, bytes]:
    """The files with other JSON."""
    return {**files, "about.npy": npy(np.frombuffer(json.dumps(about).encode(), np.uint8))}


def with_changed_members(content: bytes, n: int = 6, seed: int = 0) -> Iterator[bytes]:
    """Each member with another header, a changed byte of it or of its values, or cut off."""
    files, rng = members(content), np.random.default_rng(seed)
    for name, member in files.items():
        for header in HEADERS:
            yield packed({**files, name: member[:10] + header + member[128:]})
        for place in (*rng.integers(0, 128, n), *rng.integers(128, max(len(member), 129), n)):
            changed = bytearray(member)
            changed[min(int(place), len(member) - 1)] ^= 1 << int(rng.integers(8))
            yield packed({**files, name: bytes(changed)})
        yield packed({**files, name: member[: int(rng.integers(len(member)))]})


def with_odd_values(content: bytes) -> Iterator[tuple[str, bytes]]:
    """Each value of the JSON in turn in place of which stands one of another type or size."""
    files = members(content)
    about = about_of(files)
    for path, table, key in list(_values(about)):
        before = table[key]
        for odd in (*ODD, [before], str(before)):
            table[key] = odd
            yield f"{path} {str(odd)[:20]}", packed(with_about(files, about))
        table[key] = before


def _values(part: Any, path: str = "") -> Iterator[tuple[str, Any, Any]]:
    """Where each value stands: its path, what holds it, and its key there."""
    for key, value in part.items() if isinstance(part, dict) else enumerate(part):
        yield f"{path}/{key}", part, key
        if isinstance(value, dict | list):
            yield from _values(value, f"{path}/{key}")
