"""A session file read."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any, Final, TypeVar

from nvcore.codes import CodedInterval
from nvcore.errors import ParameterError, SessionError
from nvcore.inputs.facts import parse_size
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
from nvcore.records import decode, values_of
from nvcore.settings import operating_point

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
_WRITTEN: Final = {"sha256": Mapping[str, str], "pipes": tuple[str, ...]}
_TABLE_FILE: Final = {"path": str}


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
    try:
        return _session(tables, path.resolve().parent, needs_system)
    except (SessionError, ParameterError, ValueError) as error:
        raise SessionError(str(error), file=path) from error


def _session(content: dict[str, Any], folder: Path, needs_system: bool) -> Session:
    values_of(dict.fromkeys(_TABLES, object), content, "the session")
    of_systems = _tables(content, "system")
    if len(of_systems) > MOST_SYSTEMS:
        raise ValueError(f"system: expected at most {MOST_SYSTEMS:,}")
    if "truth" not in content or (needs_system and not of_systems):
        raise ValueError("expected a [truth] table and at least one [[system]]")
    truth = _source(Source, _table(content, "truth"), "[truth]")
    systems = [_source(SystemSource, table, "[[system]]") for table in of_systems]
    recordings = [_recording(table) for table in _tables(content, "recording")]
    defaults = _values(_DEFAULTS, content, "defaults")
    with _errors_in("[defaults]"):
        defaults |= {"size": parse_size(defaults["size"])} if "size" in defaults else {}
    recordings_file = _table_file(content, "recordings")
    compare = _compare(content)
    primary = _values(_PRIMARY, content, "primary")
    settings, filters = _table(content, "parameters"), _table(content, "protocol")
    with _errors_in("[parameters]"):
        params = params_from(settings)
    with _errors_in("[protocol]"):
        protocol = protocol_from(filters)
    published = [
        decode(PublishedPoint, of, "[[published]]") for of in _tables(content, "published")
    ]
    codes = [decode(CodedInterval, of, "[[code]]") for of in _tables(content, "code")]
    written = _values(_WRITTEN, content, "written", known_only=False)
    added: dict[str, Any] = {
        name: decode(kind, _table(content, name), f"[{name}]")
        for name, kind in TABLES_OF_SUBJECTS.items()
    }
    with _errors_in("the session"):
        return Session(
            folder=folder,
            truth=truth,
            systems=tuple(systems),
            recordings=tuple(recordings),
            recordings_file=recordings_file,
            params=params,
            protocol=protocol,
            primary=primary_from(primary),
            published=tuple(published),
            codes=tuple(codes),
            codes_file=of.path if (of := _table_file(content, "codes")) else None,
            hashes=written.get("sha256", {}),
            pipes=written.get("pipes", ()),
            **added,
            **defaults,
            **compare,
        )


@contextmanager
def _errors_in(where: str) -> Iterator[None]:
    """Prefix errors of a part of a session with its name."""
    try:
        yield
    except (SessionError, ParameterError, ValueError) as error:
        raise ValueError(f"{where}: {error}") from error


def _values(
    types: Mapping[str, Any], content: dict[str, Any], key: str, *, known_only: bool = True
) -> dict[str, Any]:
    table = _table(content, key)
    return values_of(types, table, f"[{key}]", known_only=known_only)


def _compare(content: dict[str, Any]) -> dict[str, Any]:
    """Return the fields of `Settings` under [compare]. Objects may be a single word."""
    table = _table(content, "compare")
    if isinstance(table.get("objects"), str):
        content = {"compare": {**table, "objects": [table["objects"]]}}
    values = _values(_COMPARE, content, "compare")
    with _errors_in("[compare]: objects"):
        objects = objects_from(values.pop("objects", PEDESTRIAN.singular))
    with _errors_in("[compare]"):
        values |= {"operating_point": operating_point(values.get("operating_point"))}
    only_tags, only = values.pop("tags", ()), values.pop("recordings", ())
    return {**values, "only_tags": only_tags, "only": only, "objects": objects}


def _recording(table: dict[str, Any]) -> RecordingEntry:
    """Return a recording. Its traffic context may be a word."""
    if "context" in table:
        with _errors_in("[[recording]]: context"):
            table = {**table, "context": parse_context(table["context"])}
    return decode(RecordingEntry, table, "[[recording]]")


def _table_file(content: dict[str, Any], key: str) -> RecordingsFile | None:
    """Return the CSV file that the session names for a table of it, if any."""
    if key not in content:
        return None
    path = _values(_TABLE_FILE, content, key).get("path")
    with _errors_in(f"[{key}]"):
        if path is None:
            raise ValueError("expected a path")
        return RecordingsFile(path)


def _source(kind: type[_T], table: dict[str, Any], where: str) -> _T:
    """Return a source. A single path or scale counts as a list of one."""
    path, scale = table.get("path"), table.get("scale")
    if isinstance(path, str):
        table = {**table, "path": [path]}
    if isinstance(scale, int | float):
        table = {**table, "scale": [scale, scale]}
    return decode(kind, table, where)


def _table(content: dict[str, Any], key: str) -> dict[str, Any]:
    table: dict[str, Any] = content.get(key, {})
    if not isinstance(table, dict):
        raise ValueError(f"expected [{key}] to be a table")
    return table


def _tables(content: dict[str, Any], key: str) -> list[dict[str, Any]]:
    tables: list[dict[str, Any]] = content.get(key, [])
    if not isinstance(tables, list) or not all(isinstance(part, dict) for part in tables):
        raise ValueError(f"expected [[{key}]] to be a list of tables")
    return tables
