"""Read and write a `Session` as TOML.

docs/formats.md lists the keys, each with an example. Subjects add theirs
(`nvcore.subjects.driver.inputs.session`). Paths are relative to the session file. A session written
by the program also holds the version, the sha256 of every input, and which of the paths were pipes.
"""

from __future__ import annotations

import glob
import os
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import fields
from pathlib import Path
from typing import Any, Final, TypeVar

import tomli_w

from nvcore.common.errors import ParameterError, SessionError
from nvcore.common.records import decode, values_of
from nvcore.inputs.facts import check_path, parse_size
from nvcore.inputs.files.pipes import is_pipe
from nvcore.inputs.session import (
    SYSTEM_KEYS_OF_SUBJECTS,
    TABLES_OF_SUBJECTS,
    RecordingEntry,
    RecordingsFile,
    Session,
    Source,
    SystemSource,
)
from nvcore.inputs.session.toml_text import parse_toml
from nvcore.settings.codes import CodedInterval
from nvcore.settings.defaults import operating_point
from nvcore.settings.objects import PEDESTRIAN, objects_from
from nvcore.settings.params import params_from
from nvcore.settings.params.traffic import context_word, parse_context
from nvcore.settings.primary import primary_from
from nvcore.settings.protocols import protocol_from
from nvcore.settings.published import PublishedPoint

_T = TypeVar("_T")

MAX_BYTES: Final = 16 << 20
"""Size of a session with the hashes of a hundred thousand inputs."""
MOST_SYSTEMS: Final = 1000
_TYPES: Final[Mapping[str, Mapping[str, Any]]] = {
    "recordings": {"path": str},
    "defaults": {"size": str, "fps": float, "frames": str},
    "compare": {
        "x": str,
        "y": str,
        "tags": tuple[str, ...],
        "recordings": tuple[str, ...],
        "objects": tuple[str, ...],
        "accept": tuple[str, ...],
        "operating_point": str,
    },
    "primary": {"measure": str, "fixed_at": str, "fingerprint": str, "changed": bool},
    "gate": {"rules": tuple[str, ...]},
    "codes": {"path": str},
    "written": {"sha256": Mapping[str, str], "pipes": tuple[str, ...]},
}
"""Types of the keys of tables that are not dataclasses."""
_FIELDS: Final = {"tags": "only_tags", "recordings": "only"}
"""Fields of a session for keys of [compare] with another name."""
_PARTS: Final = ("truth", "system", "recording", "parameters", "protocol", "published", "code")
_FIRST_OF_SYSTEM: Final = (
    "name",
    *(spec.name for spec in fields(Source)),
    *("threshold", "provenance", *SYSTEM_KEYS_OF_SUBJECTS),
)
"""Keys of a system in the order in which they are written, before all others."""


def read_session(path: str | Path, *, needs_system: bool = True) -> Session:
    """Read a session file.

    Parameters
    ----------
    needs_system
        Whether to refuse a session without systems. A detector may be about to add the first.

    Raises
    ------
    SessionError
        If it cannot be opened, is not TOML, or has an invalid value, with the key.
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
    known = dict.fromkeys((*_PARTS, *_TYPES, *TABLES_OF_SUBJECTS), object)
    values_of(known, content, "the session")
    of_systems = _tables(content, "system")
    if len(of_systems) > MOST_SYSTEMS:
        raise ValueError(f"system: expected at most {MOST_SYSTEMS:,}")
    if "truth" not in content or (needs_system and not of_systems):
        raise ValueError("expected a [truth] table and at least one [[system]]")
    values: dict[str, Any] = {
        "folder": folder,
        "truth": _source(Source, _table(content, "truth"), "[truth]"),
        "systems": tuple(_source(SystemSource, table, "[[system]]") for table in of_systems),
        "recordings": tuple(map(_recording, _tables(content, "recording"))),
        **_values(content, "defaults"),
        **_values(content, "gate"),
    }
    with _errors_in("[defaults]"):
        values |= {"size": parse_size(values["size"])} if "size" in values else {}
    table = _table_file(content, "recordings")
    values |= _compare(content)
    primary = _values(content, "primary")
    settings, filters = _table(content, "parameters"), _table(content, "protocol")
    with _errors_in("[parameters]"):
        values["params"] = params_from(settings)
    with _errors_in("[protocol]"):
        values["protocol"] = protocol_from(filters)
    for name, key, kind in (
        ("published", "published", PublishedPoint),
        ("codes", "code", CodedInterval),
    ):
        values[name] = tuple(decode(kind, of, f"[[{key}]]") for of in _tables(content, key))
    written = _values(content, "written", known_only=False)
    for name, of_subject in TABLES_OF_SUBJECTS.items():
        values[name] = decode(of_subject, _table(content, name), f"[{name}]")
    with _errors_in("the session"):
        return Session(
            **values,
            recordings_file=None if table is None else RecordingsFile(table),
            primary=primary_from(primary),
            codes_file=_table_file(content, "codes"),
            hashes=written.get("sha256", {}),
            pipes=written.get("pipes", ()),
        )


@contextmanager
def _errors_in(where: str) -> Iterator[None]:
    """Prefix errors of a part of a session with its name."""
    try:
        yield
    except (SessionError, ParameterError, ValueError) as error:
        raise ValueError(f"{where}: {error}") from error


def _values(content: dict[str, Any], key: str, *, known_only: bool = True) -> dict[str, Any]:
    return values_of(_TYPES[key], _table(content, key), f"[{key}]", known_only=known_only)


def _compare(content: dict[str, Any]) -> dict[str, Any]:
    """Return the fields of `Settings` under [compare]. Objects may be a single word."""
    table = _table(content, "compare")
    if isinstance(table.get("objects"), str):
        content = {"compare": {**table, "objects": [table["objects"]]}}
    values = {_FIELDS.get(key, key): value for key, value in _values(content, "compare").items()}
    with _errors_in("[compare]: objects"):
        values["objects"] = objects_from(values.get("objects", PEDESTRIAN.singular))
    with _errors_in("[compare]"):
        values["operating_point"] = operating_point(values.get("operating_point"))
    return values


def _recording(table: dict[str, Any]) -> RecordingEntry:
    """Return a recording. Its traffic context may be a word."""
    if "context" in table:
        with _errors_in("[[recording]]: context"):
            table = {**table, "context": parse_context(table["context"])}
    return decode(RecordingEntry, table, "[[recording]]")


def _table_file(content: dict[str, Any], key: str) -> str | None:
    """Return the CSV file that the session names for a table of it, if any."""
    if key not in content:
        return None
    path = _values(content, key).get("path")
    with _errors_in(f"[{key}]"):
        if path is None:
            raise ValueError("expected a path")
        if path == "":
            raise ValueError("path: expected a file, found nothing")
        check_path("path", path)
    return str(path)


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


def write_session(session: Session, *, version: str, fingerprint: str) -> str:
    """Serialize the session as TOML that gives the same comparison when it is read.

    Paths are absolute, so that the file can be moved. Pipes cannot be read again, so the file
    lists them.
    """
    folder = session.folder
    session = session.with_paths(lambda path: _absolute(path, folder), folder=folder)
    listed, size = session.recordings_file, session.size
    compare = {key: getattr(session, _FIELDS.get(key, key)) for key in _TYPES["compare"]}
    content: dict[str, dict[str, Any]] = {
        "written": {
            "version": version,
            "fingerprint": fingerprint,
            "pipes": [path for path in session.paths() if is_pipe(Path(path))],
            "sha256": dict(session.hashes),
        },
        "compare": {**compare, "objects": session.objects.given()},
        "primary": session.primary.given(),
        "gate": {"rules": session.rules},
        "parameters": session.params.stated(),
        "protocol": session.protocol.given(),
        "recordings": {"path": None if listed is None else listed.path},
        "codes": {"path": session.codes_file},
        "defaults": {
            "size": None if size is None else f"{size[0]}x{size[1]}",
            "fps": session.fps,
            "frames": session.frames,
        },
        "truth": _stated(session.truth),
        **{name: _stated(getattr(session, name)) for name in TABLES_OF_SUBJECTS},
    }
    given = {
        key: {name: value for name, value in table.items() if value not in (None, (), [])}
        for key, table in content.items()
    }
    lists = {
        "recording": [_stated(of, "name", "visible", "visible_map") for of in session.recordings],
        "system": [_stated(of, *_FIRST_OF_SYSTEM) for of in session.systems],
        "published": [point.given() for point in session.published],
        "code": [of.given() for of in session.codes],
    }
    parts = [tomli_w.dumps({key: table for key, table in given.items() if table})]
    # tomli_w would put short tables of a list on one line
    parts += [f"[[{key}]]\n{tomli_w.dumps(of)}" for key, tables in lists.items() for of in tables]
    return "\n".join(parts)


def _stated(part: Any, *first: str) -> dict[str, Any]:
    """Return the fields of a part that differ from the default, with `first` before others."""
    default = {spec.name: spec.default for spec in fields(part)}
    values = {name: getattr(part, name) for name in dict.fromkeys([*first, *default])}
    table = {name: value for name, value in values.items() if value != default[name]}
    if len(table.get("path", ())) == 1:
        table["path"] = part.path[0]
    if len({*table.get("scale", ())}) == 1:
        table["scale"] = part.scale[0]
    if "context" in table:
        table["context"] = context_word(part.context)
    return table


def _absolute(path: str, folder: Path) -> str:
    # normpath, not resolve: a glob stays a glob and a link stays a link
    is_there = os.path.exists(folder / path)  # noqa: PTH110  # False also of a name that is too long
    is_glob = glob.has_magic(path) and not is_there
    start = Path(glob.escape(str(folder))) if is_glob else folder
    return Path(os.path.normpath(start / path)).as_posix()
