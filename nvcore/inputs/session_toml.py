"""One comparison, one file: a `Session` as TOML, read and written.

    [[recording]]            what the data do not say, by recording (only name is required)
    name = "urban_01"
    width = 640
    height = 480
    fps = 20
    frames = "0:299:1"       first:last[:step], or a file with one number a line
    horizon = 236.0
    context = "urban"        of the traffic: "urban", "rural", or a number from 0 to 1
    speed_kmh = 50           speed of the car
    pictures = "urban_01.mp4" a video, a folder, or an archive
    first_picture = 0        number of the frame that the first picture shows
    tags = ["night", "rain"] words by which recordings can be chosen
    title = "Night drive 1"  what it is called, in place of its name in the data
    visible = "visible.mp4"  and what else is known of the driver: nvcore.inputs.session_driver

    [recordings]             the same as a table (see nvcore.inputs.recordings_file)
    path = "recordings.csv"

    [defaults]               the same facts for all recordings: size, fps, frames
    size = "640x480"

    [truth]
    path = "truth.csv"       file, folder, glob, or a list of them
    format = "csv"
    classes = ["person"]
    frame_base = 0
    box_base = 1

    [[system]]               the first is X, the second Y, unless [compare] says otherwise
    name = "FIR"
    path = "fir.csv"
    threshold = 0.5
    offset_frames = 0        added to the frame numbers
    offset_px = [0, 0]       added to x and y, after scaling
    scale = 1.0              by which coordinates are multiplied, or [x, y]
    provenance = "fir.json"  a record of how they were made (docs/detectors.md)

    [compare]
    x = "FIR"
    y = "NIR"
    tags = ["night"]         only recordings that have all of these tags
    recordings = ["urban_01"] only these, by title or name, of those with the tags
    objects = "speed sign"   what the boxes are of, if not pedestrians; of kinds that the program
                             does not know singular and plural: ["child", "children"]

    [parameters]             any of nvcore.params.Params

    [protocol]               which pedestrians count in the detection measures: a named protocol,
    name = "reasonable"      filters of its own (see nvcore.protocols.Protocol), or both
    height_px = [50, inf]
    occlusion = [0, 1]
    border_px = [5, 5, 5, 5]
    aspect = [1.0, inf]
    tags = ["night"]
    recordings = ["drive_1"]
    expand = 1.25

    [[published]]            operating points of others, drawn beside the curves: recall or
    name = "Report 2015"     miss_rate, and precision, fppi or fppw
    recall = 0.939
    precision = 0.215

Paths are relative to the session file. A session written by the program also holds the version,
the sha256 of every input, and which of the paths were pipes.

The tables are decoded by hand, by the types of the dataclasses' fields. The alternatives, weighed
by licence, size and dependencies: msgspec rejects unknown keys only for its own classes, so that
every field would be declared twice; cattrs converts anything to text or numbers unless told
otherwise for each type; pydantic adds 11 MB. Each would need its errors translated into plain
words, which takes as much code as decoding here.
"""

from __future__ import annotations

import glob
import os
import reprlib
import tomllib
from collections.abc import Collection, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import MISSING, fields
from pathlib import Path
from types import UnionType
from typing import Any, Final, TypeVar, get_args, get_origin, get_type_hints

import tomli_w

from nvcore.errors import ParameterError, SessionError
from nvcore.inputs.facts import parse_size
from nvcore.inputs.pipes import is_pipe
from nvcore.inputs.session import (
    RecordingEntry,
    RecordingsFile,
    Session,
    Source,
    SystemSource,
)
from nvcore.inputs.session_driver import DriverTable
from nvcore.params import params_from
from nvcore.params.traffic import context_word, parse_context
from nvcore.protocols import protocol_from
from nvcore.published import PublishedPoint
from nvcore.wording import did_you_mean
from nvcore.wording.objects import PEDESTRIAN, objects_from

_T = TypeVar("_T")

MAX_BYTES: Final = 16 << 20
"""With the hashes of a hundred thousand inputs."""
_TABLES: Final = frozenset(
    {
        "recording",
        "recordings",
        "defaults",
        "truth",
        "system",
        "compare",
        "parameters",
        "protocol",
        "published",
        "driver",
        "written",
    }
)
_DEFAULTS: Final = {"size": str, "fps": float, "frames": str}
_COMPARE: Final = {
    "x": str,
    "y": str,
    "tags": tuple[str, ...],
    "recordings": tuple[str, ...],
    "objects": tuple[str, ...],
}
_RECORDINGS: Final = {"path": str}
_WORDS: Final = {
    str: "a text",
    int: "a whole number",
    float: "a number",
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
        content = tomllib.loads(path.read_text(encoding="utf-8"))
        _check_integers(content)
    except OSError as error:
        raise SessionError(f"cannot be opened ({error.strerror})", file=path) from error
    except (ValueError, RecursionError) as error:  # bad UTF-8, bad TOML, thousands of digits
        raise SessionError(f"is not TOML: {error}", file=path) from error
    return _Decoder(path).session(content, needs_system)


def _check_integers(value: object) -> None:
    if isinstance(value, dict | list):
        for part in value.values() if isinstance(value, dict) else value:
            _check_integers(part)
    elif isinstance(value, int) and not -(2**63) <= value < 2**63:
        raise ValueError("an integer of more than 64 bits")


class _Decoder:
    """Turns the content of one session file into a `Session`; knows the file for errors."""

    def __init__(self, path: Path):
        self.path = path

    def fail(self, message: str) -> SessionError:
        return SessionError(message, file=self.path)

    @contextmanager
    def errors_in(self, where: str) -> Iterator[None]:
        """What a part of a session refuses is an error with the file and the table."""
        try:
            yield
        except (SessionError, ParameterError, ValueError) as error:
            raise self.fail(f"{where}: {error}") from error

    def session(self, content: dict[str, Any], needs_system: bool) -> Session:
        self.check_keys(content, _TABLES, "the session")
        if "truth" not in content or (needs_system and not self.tables(content, "system")):
            raise self.fail("expected a [truth] table and at least one [[system]]")
        truth = self.source(Source, self.table(content, "truth"), "[truth]")
        systems = [
            self.source(SystemSource, table, "[[system]]")
            for table in self.tables(content, "system")
        ]
        recordings = [self.recording(table) for table in self.tables(content, "recording")]
        defaults = self.values(_DEFAULTS, self.table(content, "defaults"), "[defaults]")
        with self.errors_in("[defaults]"):
            defaults |= {"size": parse_size(defaults["size"])} if "size" in defaults else {}
        compare = self.compare(self.table(content, "compare"))
        settings, filters = self.table(content, "parameters"), self.table(content, "protocol")
        with self.errors_in("[parameters]"):
            params = params_from(settings)
        with self.errors_in("[protocol]"):
            protocol = protocol_from(filters)
        published = [
            self.decode(PublishedPoint, table, "[[published]]")
            for table in self.tables(content, "published")
        ]
        written = self.table(content, "written")
        hashes = self.value(Mapping[str, str], written.get("sha256", {}), "[written]: sha256")
        pipes = self.value(tuple[str, ...], written.get("pipes", []), "[written]: pipes")
        with self.errors_in("the session"):
            return Session(
                folder=self.path.resolve().parent,
                truth=truth,
                systems=tuple(systems),
                recordings=tuple(recordings),
                recordings_file=self.recordings_file(content),
                params=params,
                protocol=protocol,
                published=tuple(published),
                driver=self.decode(DriverTable, self.table(content, "driver"), "[driver]"),
                hashes=hashes,
                pipes=pipes,
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
        only_tags, only = values.pop("tags", ()), values.pop("recordings", ())
        return {**values, "only_tags": only_tags, "only": only, "objects": objects}

    def recording(self, table: dict[str, Any]) -> RecordingEntry:
        """A recording; its traffic context may be a word."""
        if "context" in table:
            with self.errors_in("[[recording]]: context"):
                table = {**table, "context": parse_context(table["context"])}
        return self.decode(RecordingEntry, table, "[[recording]]")

    def recordings_file(self, content: dict[str, Any]) -> RecordingsFile | None:
        """The table of recordings that the session names, if it does."""
        if "recordings" not in content:
            return None
        values = self.values(_RECORDINGS, self.table(content, "recordings"), "[recordings]")
        if not values:
            raise self.fail("[recordings]: expected a path")
        with self.errors_in("[recordings]"):
            return RecordingsFile(**values)

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
            if spec.default is MISSING and spec.name not in values:
                raise self.fail(f"{where}: expected a {spec.name}")
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
            words = f"expected {_WORDS[kind]}, found {reprlib.repr(value)}"
            raise self.fail(f"{where}: {words}") from error

    def check_keys(self, table: dict[str, Any], known: Collection[str], where: str) -> None:
        for key in table:
            if key not in known:
                hint = did_you_mean(key, known, f"its keys are {', '.join(sorted(known))}")
                raise self.fail(f"{where} has no key {key!r}; {hint}")

    def table(self, content: dict[str, Any], key: str) -> dict[str, Any]:
        table = content.get(key, {})
        if not isinstance(table, dict):
            raise self.fail(f"expected [{key}] to be a table")
        return table

    def tables(self, content: dict[str, Any], key: str) -> list[dict[str, Any]]:
        tables = content.get(key, [])
        if not isinstance(tables, list) or not all(isinstance(table, dict) for table in tables):
            raise self.fail(f"expected [[{key}]] to be a list of tables")
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
    if origin or isinstance(value, bool) or not (is_number or isinstance(value, kind)):
        raise TypeError
    return kind(value)


def write_session(session: Session, *, version: str, fingerprint: str) -> str:
    """The session as TOML text; reading it back gives the same comparison.

    Paths are written absolute, so that the file means the same wherever it lies. Those of pipes,
    which cannot be read again, are named as such.
    """
    folder = session.folder
    session = session.with_paths(lambda path: _absolute(path, folder), folder=folder)
    table = session.recordings_file
    pipes = [path for path in session.paths() if is_pipe(Path(path))]
    defaults = {
        "size": None if session.size is None else f"{session.size[0]}x{session.size[1]}",
        "fps": session.fps,
        "frames": session.frames,
    }
    content: dict[str, Any] = {
        "written": {
            "version": version,
            "fingerprint": fingerprint,
            **({"pipes": pipes} if pipes else {}),
            "sha256": dict(session.hashes),
        },
        "compare": _given(
            {
                "x": session.x,
                "y": session.y,
                "tags": list(session.only_tags) or None,
                "recordings": list(session.only) or None,
                "objects": session.objects.given(),
            }
        ),
        "parameters": session.params.given(),
        "protocol": session.protocol.given(),
        "recordings": {} if table is None else {"path": table.path},
        "defaults": _given(defaults),
        "truth": _source_table(session.truth),
        "driver": _given(vars(session.driver)),
    }
    recordings = [_recording_table(entry) for entry in session.recordings]
    systems = [
        {
            **_given({"name": system.name}),
            **_source_table(system),
            **_given({"threshold": system.threshold, "provenance": system.provenance}),
            **_corrections(system),
        }
        for system in session.systems
    ]
    parts = [tomli_w.dumps({key: value for key, value in content.items() if value})]
    # tomli_w would put short tables of a list on one line
    parts += [f"[[recording]]\n{tomli_w.dumps(table)}" for table in recordings]
    parts += [f"[[system]]\n{tomli_w.dumps(table)}" for table in systems]
    parts += [f"[[published]]\n{tomli_w.dumps(point.given())}" for point in session.published]
    return "\n".join(parts)


def _recording_table(entry: RecordingEntry) -> dict[str, Any]:
    context = None if entry.context is None else context_word(entry.context)
    own = {"context": context, "tags": list(entry.tags) or None}
    return _given({"name": entry.name, **vars(entry), **own})


def _given(values: dict[str, Any]) -> dict[str, Any]:
    return {key: value for key, value in values.items() if value is not None}


def _absolute(path: str, folder: Path) -> str:
    # normpath, not resolve: a glob stays a glob and a link stays a link
    is_glob = glob.has_magic(path) and not (folder / path).exists()
    start = Path(glob.escape(str(folder))) if is_glob else folder
    return Path(os.path.normpath(start / path)).as_posix()


def _source_table(source: Source) -> dict[str, Any]:
    paths = list(source.path)
    return _given(
        {
            "path": paths[0] if len(paths) == 1 else paths,
            "format": source.format,
            "classes": None if source.classes is None else list(source.classes),
            "frame_base": source.frame_base,
            "box_base": source.box_base,
        }
    )


def _corrections(system: SystemSource) -> dict[str, Any]:
    table: dict[str, Any] = {}
    if system.offset_frames:
        table["offset_frames"] = system.offset_frames
    if any(system.offset_px):
        table["offset_px"] = list(system.offset_px)
    if system.scale != (1, 1):
        across, down = system.scale
        table["scale"] = across if across == down else [across, down]
    return table
