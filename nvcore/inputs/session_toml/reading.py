"""A session file read.

The tables are decoded by hand, by the types of the dataclasses' fields. The alternatives, weighed
by licence, size and dependencies: msgspec rejects unknown keys only for its own classes, so that
every field would be declared twice; cattrs converts anything to text or numbers unless told
otherwise for each type; pydantic adds 11 MB. Each would need its errors translated into plain
words, which takes as much code as decoding here.
"""

from __future__ import annotations

import reprlib
from collections.abc import Collection, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import MISSING, fields
from pathlib import Path
from types import UnionType
from typing import Any, Final, TypeVar, get_args, get_origin, get_type_hints

from nvcore.codes import CodedInterval
from nvcore.errors import ParameterError, SessionError
from nvcore.inputs.facts import check_path, parse_size
from nvcore.inputs.session import (
    TABLES_OF_SUBJECTS,
    RecordingEntry,
    RecordingsFile,
    Session,
    Source,
    SystemSource,
)
from nvcore.inputs.toml_text import parse_toml
from nvcore.objects import PEDESTRIAN, objects_from
from nvcore.params import params_from
from nvcore.params.traffic import parse_context
from nvcore.primary import primary_from
from nvcore.protocols import protocol_from
from nvcore.published import PublishedPoint
from nvcore.settings import operating_point
from nvcore.wording import did_you_mean

_T = TypeVar("_T")

MAX_BYTES: Final = 16 << 20
"""With the hashes of a hundred thousand inputs."""
MOST_SYSTEMS: Final = 1000
_TABLES: Final = frozenset(
    {
        "recording",
        "recordings",
        "defaults",
        "truth",
        "system",
        "compare",
        "primary",
        "parameters",
        "protocol",
        "published",
        "code",
        "codes",
        "written",
        *TABLES_OF_SUBJECTS,
    }
)
_DEFAULTS: Final = {"size": str, "fps": float, "frames": str}
_COMPARE: Final = {
    "x": str,
    "y": str,
    "tags": tuple[str, ...],
    "recordings": tuple[str, ...],
    "objects": tuple[str, ...],
    "accept": tuple[str, ...],
    "operating_point": str,
}
_PRIMARY: Final = {"measure": str, "fixed_at": str, "fingerprint": str, "changed": bool}
_TABLE_FILE: Final = {"path": str}
_WORDS: Final = {
    str: "a text",
    int: "a whole number",
    float: "a number",
    bool: "true or false",
    tuple[str, ...]: "a list of texts",
    tuple[float, float]: "two numbers",
    tuple[float, float, float, float]: "four numbers",
    Mapping[str, str]: "a table of texts",
}
"""What is expected, by the type of the field."""


def read_session(path: str | Path, *, needs_system: bool = True) -> Session:
    """Read a session file.

    Parameters
    ----------
    needs_system
        Whether one that names no system is refused: a detector may be about to make the first.

    Raises
    ------
    SessionError
        If it cannot be opened, is not TOML, or says something that cannot be done; with the key.
    """
    path = Path(path)
    try:
        if path.stat().st_size > MAX_BYTES:
            raise SessionError(f"is larger than {MAX_BYTES >> 20} MiB", file=path)
        content = path.read_bytes()
    except OSError as error:
        raise SessionError(f"cannot be opened ({error.strerror})", file=path) from error
    tables = parse_toml(content, file=path, error=SessionError)
    return _Decoder(path).session(tables, needs_system)


class _Decoder:
    """Turns the content of one session file into a `Session`; knows the file for errors."""

    def __init__(self, path: Path):
        self.path = path

    def fail(self, message: str) -> SessionError:
        return SessionError(message, file=self.path)

    def expect(self, is_met: bool, message: str) -> None:
        if not is_met:
            raise self.fail(message)

    @contextmanager
    def errors_in(self, where: str) -> Iterator[None]:
        """What a part of a session refuses is an error with the file and the table."""
        try:
            yield
        except (SessionError, ParameterError, ValueError) as error:
            raise self.fail(f"{where}: {error}") from error

    def session(self, content: dict[str, Any], needs_system: bool) -> Session:
        self.check_keys(content, _TABLES, "the session")
        of_systems = self.tables(content, "system")
        self.expect(len(of_systems) <= MOST_SYSTEMS, f"system: expected at most {MOST_SYSTEMS:,}")
        self.expect(
            "truth" in content and (len(of_systems) > 0 or not needs_system),
            "expected a [truth] table and at least one [[system]]",
        )
        truth = self.source(Source, self.table(content, "truth"), "[truth]")
        systems = [self.source(SystemSource, table, "[[system]]") for table in of_systems]
        recordings = [self.recording(table) for table in self.tables(content, "recording")]
        defaults = self.values(_DEFAULTS, self.table(content, "defaults"), "[defaults]")
        with self.errors_in("[defaults]"):
            defaults |= {"size": parse_size(defaults["size"])} if "size" in defaults else {}
        table = self.table_file(content, "recordings")
        compare = self.compare(self.table(content, "compare"))
        primary = self.values(_PRIMARY, self.table(content, "primary"), "[primary]")
        settings, filters = self.table(content, "parameters"), self.table(content, "protocol")
        with self.errors_in("[parameters]"):
            params = params_from(settings)
        with self.errors_in("[protocol]"):
            protocol = protocol_from(filters)
        published = [
            self.decode(PublishedPoint, table, "[[published]]")
            for table in self.tables(content, "published")
        ]
        codes = [
            self.decode(CodedInterval, table, "[[code]]") for table in self.tables(content, "code")
        ]
        written = self.table(content, "written")
        hashes = self.value(Mapping[str, str], written.get("sha256", {}), "[written]: sha256")
        pipes = self.value(tuple[str, ...], written.get("pipes", []), "[written]: pipes")
        added: dict[str, Any] = {
            name: self.decode(kind, self.table(content, name), f"[{name}]")
            for name, kind in TABLES_OF_SUBJECTS.items()
        }
        with self.errors_in("the session"):
            return Session(
                folder=self.path.resolve().parent,
                truth=truth,
                systems=tuple(systems),
                recordings=tuple(recordings),
                recordings_file=None if table is None else RecordingsFile(table),
                params=params,
                protocol=protocol,
                primary=primary_from(primary),
                published=tuple(published),
                codes=tuple(codes),
                codes_file=self.table_file(content, "codes"),
                hashes=hashes,
                pipes=pipes,
                **added,
                **defaults,
                **compare,
            )

    def compare(self, table: dict[str, Any]) -> dict[str, Any]:
        """The fields of `Settings` under [compare]; of objects a singular alone is enough."""
        if isinstance(table.get("objects"), str):
            table = {**table, "objects": [table["objects"]]}
        values = self.values(_COMPARE, table, "[compare]")
        with self.errors_in("[compare]: objects"):
            objects = objects_from(values.pop("objects", PEDESTRIAN.singular))
        with self.errors_in("[compare]"):
            values |= {"operating_point": operating_point(values.get("operating_point"))}
        only_tags, only = values.pop("tags", ()), values.pop("recordings", ())
        return {**values, "only_tags": only_tags, "only": only, "objects": objects}

    def recording(self, table: dict[str, Any]) -> RecordingEntry:
        """A recording; its traffic context may be a word."""
        if "context" in table:
            with self.errors_in("[[recording]]: context"):
                table = {**table, "context": parse_context(table["context"])}
        return self.decode(RecordingEntry, table, "[[recording]]")

    def table_file(self, content: dict[str, Any], key: str) -> str | None:
        """The CSV file that the session names for a table of it, if it does."""
        if key not in content:
            return None
        values = self.values(_TABLE_FILE, self.table(content, key), f"[{key}]")
        self.expect("path" in values, f"[{key}]: expected a path")
        self.expect(values["path"] != "", f"[{key}]: path: expected a file, found nothing")
        with self.errors_in(f"[{key}]"):
            check_path("path", values["path"])
        return str(values["path"])

    def source(self, kind: type[_T], table: dict[str, Any], where: str) -> _T:
        """A source; a single path or scale counts as a list of one."""
        path, scale = table.get("path"), table.get("scale")
        if isinstance(path, str):
            table = {**table, "path": [path]}
        if isinstance(scale, int | float):
            table = {**table, "scale": [scale, scale]}
        return self.decode(kind, table, where)

    def decode(self, kind: type[_T], table: dict[str, Any], where: str) -> _T:
        """A dataclass from the table with its fields."""
        values = self.values(get_type_hints(kind), table, where)
        for spec in fields(kind):  # type: ignore[arg-type]
            is_there = spec.name in values or spec.default is not MISSING
            self.expect(is_there, f"{where}: expected a {spec.name}")
        with self.errors_in(where):
            return kind(**values)

    def values(self, types: dict[str, Any], table: dict[str, Any], where: str) -> dict[str, Any]:
        """The values of a table with these keys, as these types."""
        self.check_keys(table, types, where)
        return {
            key: self.value(types[key], value, f"{where}: {key}") for key, value in table.items()
        }

    def value(self, kind: Any, value: object, where: str) -> Any:
        """A value as a field of this type holds it."""
        if get_origin(kind) is UnionType:  # or None, which TOML does not have
            kind = get_args(kind)[0]
        try:
            return _typed(kind, value)
        except (TypeError, ValueError) as error:
            raise self.fail(
                f"{where}: expected {_WORDS[kind]}, found {reprlib.repr(value)}"
            ) from error

    def check_keys(self, table: dict[str, Any], known: Collection[str], where: str) -> None:
        for key in table:
            if key not in known:
                hint = did_you_mean(key, known, f"its keys are {', '.join(sorted(known))}")
                raise self.fail(f"{where} has no key {key!r}; {hint}")

    def table(self, content: dict[str, Any], key: str) -> dict[str, Any]:
        table: dict[str, Any] = content.get(key, {})
        self.expect(isinstance(table, dict), f"expected [{key}] to be a table")
        return table

    def tables(self, content: dict[str, Any], key: str) -> list[dict[str, Any]]:
        tables: list[dict[str, Any]] = content.get(key, [])
        are_tables = isinstance(tables, list) and all(isinstance(part, dict) for part in tables)
        self.expect(are_tables, f"expected [[{key}]] to be a list of tables")
        return tables


def _typed(kind: Any, value: Any) -> Any:
    """The value as this type; TypeError or ValueError where it is of another."""
    origin, parts = get_origin(kind), get_args(kind)
    if origin is tuple and isinstance(value, list):
        kinds = parts[:1] * len(value) if parts[-1] is ... else parts
        return tuple(_typed(part, item) for part, item in zip(kinds, value, strict=True))
    if origin is Mapping and isinstance(value, dict):
        return {key: _typed(parts[1], item) for key, item in value.items()}
    is_number = kind is float and isinstance(value, int | float)
    is_bool = isinstance(value, bool)
    if origin or is_bool != (kind is bool) or not (is_number or isinstance(value, kind)):
        raise TypeError
    return kind(value)
