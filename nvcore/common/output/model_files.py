"""Model files: ``.npz`` with plain arrays and a block of JSON, never pickle.

The archive holds a CRC-32 of each array, which every reader checks.
"""

from __future__ import annotations

import hashlib
import io
import json
import math
import re
import zipfile
import zlib
from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass, field
from itertools import chain
from pathlib import Path
from typing import Any, Final, Generic, TypeVar

import numpy as np
from numpy.typing import NDArray

from nvcore.common.errors import InputError, NvcoreError, ParameterError
from nvcore.common.file_kinds import binary_kind
from nvcore.common.records import decode, parse_json
from nvcore.common.subject import subjects
from nvcore.common.wording import one_line

A = TypeVar("A")
T = TypeVar("T")
Arrays = Mapping[str, NDArray[Any]]
LONGEST_NAME: Final = 200
ABOUT: Final = "about"
"""Name of the array with the bytes of the JSON."""
FORMATS: Final = dict(chain(*(subject.formats.items() for subject in subjects())))
"""Description of each kind of model, by the format that its JSON names."""
_TIME: Final = (1980, 1, 1, 0, 0, 0)
_ZIP: Final = b"PK"
_OF_TEXT: Final = b"\t\n\f\r"
"""Control characters that text may contain."""
_MOST_LOOKED_AT: Final = 4096
_MOST_ABOUT: Final = 1 << 22
_HEADER: Final = re.compile(
    rb"\x93NUMPY\x01\x00(?P<length>..)\{'descr': '(?P<dtype>[|<][a-z]\d{1,2})', "
    rb"'fortran_order': False, 'shape': \((?P<shape>(\d{1,10}, ?)*(\d{1,10})?)\), \} *\n",
    re.DOTALL,
)
"""Header as numpy writes it. Numpy parses it as Python, so other headers could hold more."""
_UNREADABLE: Final = (
    zipfile.BadZipFile,
    zlib.error,
    EOFError,
    NotImplementedError,
    RuntimeError,
    ValueError,
    OSError,
)


class BadModelError(ValueError):
    """Error: a file is not a valid model."""


@dataclass(frozen=True)
class Array:
    """Array of a model file.

    Attributes
    ----------
    dtype
        NumPy's text: ``<f8``.
    shape
        Lengths. Equal letters are equal lengths.
    low, high
        Range of its values.
    is_optional
        True if models may lack it.
    """

    dtype: str
    shape: tuple[str | int, ...]
    low: float = -math.inf
    high: float = math.inf
    is_optional: bool = False

    def check_values(self, name: str, values: NDArray[Any]) -> None:
        """Reject values outside the range.

        Raises
        ------
        BadModelError
            Names the first value out of range.
        """
        is_wrong = (values < self.low) | (values > self.high)
        if is_wrong.any():
            value = values[np.unravel_index(is_wrong.argmax(), values.shape)]
            raise BadModelError(f"{name}: expected {self.low:g} to {self.high:g}, found {value:g}")


@dataclass(frozen=True, kw_only=True)
class ModelFormat(Generic[A]):
    """Kind of model file.

    Attributes
    ----------
    name, version
        Values of ``format`` and ``version`` in its JSON.
    what
        Description for error messages: "an estimator that nvcore driver train wrote".
    error
        Error type for invalid files.
    about
        Dataclass of the remaining JSON.
    arrays
        Arrays by name.
    longest
        Maximum length by its name in the shapes.
    may_be_empty
        Names of lengths that may be 0.
    max_bytes
        Maximum size of the file, and of its unpacked content.
    """

    name: str
    version: int
    what: str
    error: type[InputError]
    about: type[A]
    arrays: Mapping[str, Array]
    longest: Mapping[str, int]
    may_be_empty: frozenset[str] = field(default=frozenset())
    max_bytes: int

    def to_bytes(self, about: A, values: Mapping[str, Any]) -> bytes:
        """Serialize a model. Equal models give equal bytes.

        Parameters
        ----------
        about
            JSON facts. Those that are None are omitted.
        values
            Arrays, or array-likes, by name.
        """
        return pack(self._members(about, values))

    def fingerprint(self, about: A, values: Mapping[str, Any]) -> str:
        """Return the sha256 of JSON and arrays as hexadecimal digits."""
        digest = hashlib.sha256()
        for name, array in self._members(about, values).items():
            digest.update(f"{name} {array.dtype.str} {array.shape}\n".encode())
            digest.update(array.tobytes())
        return digest.hexdigest()

    def _members(self, about: A, values: Mapping[str, Any]) -> dict[str, NDArray[Any]]:
        facts = asdict(about)  # type: ignore[call-overload]
        content = {"format": self.name, "version": self.version, **facts}
        content = {name: value for name, value in content.items() if value is not None}
        text = json.dumps(content, ensure_ascii=False, allow_nan=False, indent=1)
        arrays = {
            name: np.ascontiguousarray(values[name], np.dtype(array.dtype))
            for name, array in self.arrays.items()
            if name in values
        }
        return {ABOUT: np.frombuffer(text.encode(), np.uint8), **arrays}

    def read(self, path: Path) -> bytes:
        """Read a file, up to the number of bytes that shows that it is too large.

        Raises
        ------
        InputError
            If the file cannot be opened. Its type is `error`.
        """
        try:
            with path.open("rb") as file:
                return file.read(self.max_bytes + 1)
        except OSError as error:
            text = f"cannot be opened ({error.strerror})"
            raise self.error(text, file=path.name) from error

    def parse(
        self, content: bytes, name: str, build: Callable[[A, dict[str, NDArray[Any]]], T]
    ) -> T:
        """Parse a file written by `to_bytes`, checking sizes before unpacking anything.

        Parameters
        ----------
        name
            File name for error messages.
        build
            Builds the model from JSON and arrays with validated types, lengths and ranges.

        Raises
        ------
        InputError
            If the file is damaged or its content is invalid. Its type is `error`.
        """
        try:
            about, arrays = self._unpack(content)
            return build(about, arrays)
        except (ValueError, NvcoreError) as error:
            raise self.error(str(error), file=name) from error

    def _unpack(self, content: bytes) -> tuple[A, dict[str, NDArray[Any]]]:
        if len(content) > self.max_bytes:
            raise BadModelError(f"a model has at most {self.max_bytes >> 20} MiB")
        if not content.startswith(_ZIP):
            raise BadModelError(f"is not {self.what}: it is {_kind_of(content)}")
        try:
            arrays = self._read_arrays(content)
            facts = _read_about(arrays.pop(ABOUT).tobytes())
        except BadModelError:
            raise
        except RecursionError as error:
            raise BadModelError("its JSON is nested too deeply") from error
        except _UNREADABLE as error:
            text = one_line(str(error))
            raise BadModelError(f"is not {self.what}, or is damaged ({text})") from error
        if facts is None or facts.pop("format", None) != self.name:
            raise BadModelError(f"is not {self.what}")
        version = facts.pop("version", None)
        if type(version) is not int or version != self.version:
            raise BadModelError(
                f"has version {version!r:.80}; this program reads {self.version}: update it, or "
                "train the model again"
            )
        about = decode(self.about, facts, "", known_only=False)
        self._check(arrays)
        return about, arrays

    def _read_arrays(self, content: bytes) -> dict[str, NDArray[Any]]:
        kinds = {f"{ABOUT}.npy": Array("|u1", ("bytes",))}
        kinds |= {f"{name}.npy": array for name, array in self.arrays.items()}
        with zipfile.ZipFile(io.BytesIO(content)) as archive:
            members = archive.infolist()
            names = {member.filename for member in members}
            required = {name for name, kind in kinds.items() if not kind.is_optional}
            if not required <= names <= kinds.keys() or len(names) != len(members):
                other = format_of(content)
                is_other = "its arrays are others" if other is None else f"it is {FORMATS[other]}"
                raise BadModelError(f"is not {self.what}: {is_other}")
            if sum(member.file_size for member in members) > self.max_bytes:
                raise BadModelError(f"a model has at most {self.max_bytes >> 20} MiB")
            arrays = {}
            for member in members:
                if member.flag_bits & 1 or member.compress_type not in (0, zipfile.ZIP_DEFLATED):
                    raise BadModelError(f"{member.filename} is encrypted or compressed unusually")
                with archive.open(member) as stream:
                    unpacked = stream.read(member.file_size + 1)
                kind = kinds[member.filename]
                array = _array(unpacked, member.filename, kind.dtype, len(kind.shape))
                arrays[member.filename.removesuffix(".npy")] = array
        return arrays

    def _check(self, arrays: Arrays) -> None:
        """Reject arrays of mismatched lengths, and values that are not finite or in range."""
        lengths: dict[str, int] = {}
        for name, array in arrays.items():
            for side, length in zip(self.arrays[name].shape, array.shape, strict=True):
                expected = side if isinstance(side, int) else lengths.setdefault(side, length)
                is_short = side not in self.may_be_empty and length < 1
                if length != expected or is_short or length > self.longest.get(str(side), length):
                    raise BadModelError(f"{name} has the shape {array.shape}")
        for name, array in arrays.items():
            if not np.isfinite(array).all():
                raise BadModelError(f"{name} has values that are no numbers")
            self.arrays[name].check_values(name, array)


def pack(members: Arrays) -> bytes:
    """Serialize arrays as the content of a file. Equal arrays give equal bytes."""
    content = io.BytesIO()
    with zipfile.ZipFile(content, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, array in members.items():
            entry = zipfile.ZipInfo(f"{name}.npy", _TIME)
            entry.compress_type = zipfile.ZIP_DEFLATED
            member = io.BytesIO()
            np.lib.format.write_array(member, array, version=(1, 0), allow_pickle=False)
            archive.writestr(entry, member.getvalue())
    return content.getvalue()


def format_of(content: bytes) -> str | None:
    """Return the key of `FORMATS` named by a file's JSON, or None if it is not a readable model."""
    member = f"{ABOUT}.npy"
    try:
        with zipfile.ZipFile(io.BytesIO(content)) as archive:
            if archive.getinfo(member).file_size > _MOST_ABOUT:
                return None
            with archive.open(member) as stream:
                unpacked = stream.read(_MOST_ABOUT)
        about = _read_about(_array(unpacked, member, "|u1", 1).tobytes())
    except (*_UNREADABLE, KeyError):
        return None
    name = None if about is None else about.get("format")
    return name if isinstance(name, str) and name in FORMATS else None


def check_name(key: str, name: str) -> None:
    """Reject a name that is empty, longer than `LONGEST_NAME` or not printable.

    Raises
    ------
    ParameterError
        States the key of the name.
    """
    if not 0 < len(name) <= LONGEST_NAME or not name.isprintable():
        raise ParameterError(
            f"{key}: expected 1 to {LONGEST_NAME} printable characters, got {name[:40]!r}"
        )


def _kind_of(content: bytes) -> str:
    """Describe the kind of a file that is not an archive."""
    if not content:
        return "empty"
    is_text = not any(byte < 32 and byte not in _OF_TEXT for byte in content[:_MOST_LOOKED_AT])
    return binary_kind(content) or ("text" if is_text else "a binary file")


def _array(member: bytes, name: str, kind: str, n_sides: int) -> NDArray[Any]:
    """Parse an array of a plain type, whose size must match its header."""
    header = _HEADER.match(member)
    if header is None or header.end() != 10 + int.from_bytes(header["length"], "little"):
        raise BadModelError(f"{name} does not begin as an array of numbers")
    dtype = header["dtype"].decode()
    shape = tuple(map(int, header["shape"].replace(b",", b" ").split()))
    if dtype != kind or len(shape) != n_sides:
        raise BadModelError(f"{name} has type {dtype} and shape {shape}, expected {kind}")
    if math.prod(shape) * np.dtype(kind).itemsize != len(member) - header.end():
        raise BadModelError(f"{name} is not of the size that it states")
    return np.frombuffer(member, kind, offset=header.end()).reshape(shape)


def _read_about(text: bytes) -> dict[str, Any] | None:
    about = parse_json(text)
    return about if isinstance(about, dict) else None
