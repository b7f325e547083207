"""Models as files: ``.npz`` of plain arrays and a block of JSON, never pickle."""

from __future__ import annotations

import hashlib
import io
import json
import math
import re
import zipfile
import zlib
from collections.abc import Container, Iterator, Mapping
from contextlib import contextmanager
from itertools import chain
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from nvcore.file_kinds import binary_kind
from nvcore.subjects import subjects
from nvcore.wording import one_line

ABOUT: Final = "about"
"""The array of the JSON's bytes."""
Kinds = Mapping[str, tuple[str, tuple[str | int, ...]]]
"""Type and shape of each array by its name; equal words are equal lengths."""
FORMATS: Final = dict(chain(*(subject.formats.items() for _, subject in subjects().values())))
"""What each kind of model is, by the format that its JSON names."""
_TIME: Final = (1980, 1, 1, 0, 0, 0)
_ZIP: Final = b"PK"
_OF_TEXT: Final = b"\t\n\f\r"
"""Control characters that text may have."""
_MOST_LOOKED_AT: Final = 4096
_MOST_ABOUT: Final = 1 << 22
_HEADER: Final = re.compile(
    rb"\x93NUMPY\x01\x00(?P<length>..)\{'descr': '(?P<dtype>[|<][a-z]\d{1,2})', "
    rb"'fortran_order': False, 'shape': \((?P<shape>(\d{1,10}, ?)*(\d{1,10})?)\), \} *\n",
    re.DOTALL,
)
"""As numpy writes it, which reads it as Python: more than an array of numbers may stand there."""
_UNREADABLE: Final = (
    zipfile.BadZipFile,
    zlib.error,
    EOFError,
    NotImplementedError,
    RuntimeError,
    ValueError,
    OSError,
)


class BadArchiveError(Exception):
    """The content of a file is no such model; whoever reads it says which file."""


def members_of(
    about: Mapping[str, Any], values: Mapping[str, Any], kinds: Kinds
) -> dict[str, NDArray[Any]]:
    """Everything of a model as arrays by name, the JSON first; those that `values` lacks are left.

    Parameters
    ----------
    about
        What JSON can hold; no NaN.
    """
    text = json.dumps(about, ensure_ascii=False, allow_nan=False, indent=1)
    arrays = {
        name: np.ascontiguousarray(values[name], np.dtype(kind))
        for name, (kind, _) in kinds.items()
        if name in values
    }
    return {ABOUT: np.frombuffer(text.encode(), np.uint8), **arrays}


def pack(members: Mapping[str, NDArray[Any]]) -> bytes:
    """Arrays as the content of a file; equal arrays give equal bytes."""
    content = io.BytesIO()
    with zipfile.ZipFile(content, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, array in members.items():
            entry = zipfile.ZipInfo(f"{name}.npy", _TIME)
            entry.compress_type = zipfile.ZIP_DEFLATED
            member = io.BytesIO()
            np.lib.format.write_array(member, array, version=(1, 0), allow_pickle=False)
            archive.writestr(entry, member.getvalue())
    return content.getvalue()


def fingerprint_of(members: Mapping[str, NDArray[Any]]) -> str:
    """sha256 over the arrays, as hexadecimal digits."""
    digest = hashlib.sha256()
    for name, array in members.items():
        digest.update(f"{name} {array.dtype.str} {array.shape}\n".encode())
        digest.update(array.tobytes())
    return digest.hexdigest()


def format_of(content: bytes) -> str | None:
    """The key of `FORMATS` that a file's JSON names; None: it is no model, or cannot be read."""
    member = f"{ABOUT}.npy"
    try:
        with zipfile.ZipFile(io.BytesIO(content)) as archive:
            if archive.getinfo(member).file_size > _MOST_ABOUT:
                return None
            with archive.open(member) as stream:
                unpacked = stream.read(_MOST_ABOUT)
        name = _read_about(_array(unpacked, member, "|u1", 1).tobytes(), "a model").get("format")
    except (*_UNREADABLE, KeyError, BadArchiveError):
        return None
    return name if isinstance(name, str) and name in FORMATS else None


@contextmanager
def damage_of(what: str) -> Iterator[None]:
    """Within it, whatever a damaged file makes fail is said to be that.

    Parameters
    ----------
    what
        What it should be: "a model of nvcore".
    """
    try:
        yield
    except _UNREADABLE as error:
        text = one_line(str(error))
        raise BadArchiveError(f"is not {what}, or is damaged ({text})") from error


def unpack(
    content: bytes,
    kinds: Kinds,
    *,
    what: str,
    most_bytes: int,
    optional: Container[str] = frozenset(),
) -> tuple[dict[str, Any], dict[str, NDArray[Any]]]:
    """JSON and arrays of what `pack` wrote, within `damage_of`; sizes are checked first.

    Parameters
    ----------
    what
        What it should be: "a model of nvcore".
    most_bytes
        Size of the file, and of all that is in it.
    optional
        Arrays that may be missing.

    Raises
    ------
    BadArchiveError
        If it is too large, has other arrays, or one of another type or number of dimensions.
        Lengths and values are for `check_lengths` and the caller.
    """
    if len(content) > most_bytes:
        raise BadArchiveError(f"a model has at most {most_bytes >> 20} MiB")
    if not content.startswith(_ZIP):
        raise BadArchiveError(f"is not {what}: it is {_kind_of(content)}")
    arrays = _read_members(content, kinds, what, most_bytes, optional)
    return _read_about(arrays.pop(ABOUT).tobytes(), what), arrays


def check_lengths(
    arrays: Mapping[str, NDArray[Any]],
    kinds: Kinds,
    most: Mapping[str, int],
    may_be_empty: Container[str] = frozenset(),
) -> None:
    """Refuse arrays whose lengths do not fit each other, and numbers that are none.

    Parameters
    ----------
    most
        Greatest length by its word in `kinds`.
    may_be_empty
        Words of lengths that may be 0.

    Raises
    ------
    BadArchiveError
        With the name of the first.
    """
    lengths: dict[str, int] = {}
    for name, array in arrays.items():
        for side, length in zip(kinds[name][1], array.shape, strict=True):
            expected = side if isinstance(side, int) else lengths.setdefault(side, length)
            is_short = side not in may_be_empty and length < 1
            if length != expected or is_short or length > most.get(str(side), length):
                raise BadArchiveError(f"{name} has the shape {array.shape}")
    for name, array in arrays.items():
        if not np.isfinite(array).all():
            raise BadArchiveError(f"{name} has values that are no numbers")


def check_facts(about: Mapping[str, Any], facts: Mapping[str, type]) -> None:
    """Refuse JSON whose values are not of these types.

    Raises
    ------
    BadArchiveError
        With the name of the first.
    """
    for name, kind in facts.items():
        if type(about.get(name)) is not kind:
            raise BadArchiveError(f"{name}: expected {kind.__name__}, got {about.get(name)!r:.80}")


def check_name(about: Mapping[str, Any], name: str, longest: int) -> None:
    """Refuse a name that is empty, too long or not printable.

    Raises
    ------
    BadArchiveError
        With its key.
    """
    if not 0 < len(about[name]) <= longest or not about[name].isprintable():
        raise BadArchiveError(f"{name}: expected 1 to {longest} printable characters")


def check_version(about: Mapping[str, Any], name: str, version: int, *, what: str) -> None:
    """Refuse a file of another format or version.

    Raises
    ------
    BadArchiveError
        Which of them.
    """
    if about.get("format") != name:
        raise BadArchiveError(f"is not {what}")
    if about.get("version") != version:
        raise BadArchiveError(
            f"has version {about.get('version')!r}; this program reads {version}: update it, or "
            "train the model again"
        )


def _kind_of(content: bytes) -> str:
    """What a file is that is no archive."""
    if not content:
        return "empty"
    is_text = not any(byte < 32 and byte not in _OF_TEXT for byte in content[:_MOST_LOOKED_AT])
    return binary_kind(content) or ("text" if is_text else "a binary file")


def _read_members(
    content: bytes, kinds: Kinds, what: str, most_bytes: int, optional: Container[str]
) -> dict[str, NDArray[Any]]:
    with zipfile.ZipFile(io.BytesIO(content)) as archive:
        members = archive.infolist()
        required = {f"{name}.npy" for name in (ABOUT, *kinds) if name not in optional}
        names = [member.filename for member in members]
        may_be = {f"{name}.npy" for name in (ABOUT, *kinds)}
        if not required <= set(names) <= may_be or len(names) != len(set(names)):
            other = format_of(content)
            is_other = "its arrays are others" if other is None else f"it is {FORMATS[other]}"
            raise BadArchiveError(f"is not {what}: {is_other}")
        if sum(member.file_size for member in members) > most_bytes:
            raise BadArchiveError(f"a model has at most {most_bytes >> 20} MiB")
        arrays = {}
        for member in members:
            if member.flag_bits & 1 or member.compress_type not in (0, zipfile.ZIP_DEFLATED):
                raise BadArchiveError(f"{member.filename} is encrypted or compressed unusually")
            with archive.open(member) as stream:
                unpacked = stream.read(member.file_size + 1)
            name = member.filename.removesuffix(".npy")
            kind, shape = kinds.get(name, ("|u1", ("bytes",)))
            arrays[name] = _array(unpacked, member.filename, kind, len(shape))
    return arrays


def _array(member: bytes, name: str, kind: str, n_sides: int) -> NDArray[Any]:
    """An array of a plain type that is as large as its header says."""
    header = _HEADER.match(member)
    if header is None or header.end() != 10 + int.from_bytes(header["length"], "little"):
        raise BadArchiveError(f"{name} does not begin as an array of numbers")
    dtype = header["dtype"].decode()
    shape = tuple(map(int, header["shape"].replace(b",", b" ").split()))
    if dtype != kind or len(shape) != n_sides:
        raise BadArchiveError(f"{name} has type {dtype} and shape {shape}, expected {kind}")
    if math.prod(shape) * np.dtype(kind).itemsize != len(member) - header.end():
        raise BadArchiveError(f"{name} is not of the size that it states")
    return np.frombuffer(member, kind, offset=header.end()).reshape(shape)


def _read_about(text: bytes, what: str) -> dict[str, Any]:
    def refuse(constant: str) -> None:
        raise BadArchiveError(f"{constant} is not a number that a model may have")

    try:
        about = json.loads(text.decode(), parse_constant=refuse)
    except RecursionError as error:
        raise BadArchiveError("its JSON is nested too deeply") from error
    if not isinstance(about, dict):
        raise BadArchiveError(f"is not {what}")
    return about
