"""One comparison, one file: a `Session` as TOML, read and written.

    [[recording]]            facts that the data do not hold, by recording (all keys optional
    name = "urban_01"        but name)
    width = 640
    height = 480
    fps = 20
    frames = "0:299:1"       first:last[:step], or a file with one number a line
    horizon = 236.0
    pictures = "urban_01.mp4" a video, a folder, or an archive
    first_picture = 0        number of the frame that the first picture shows
    tags = ["night", "rain"] words by which recordings can be chosen

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

    [compare]
    x = "FIR"
    y = "NIR"

    [parameters]             any of nvcore.params.Params

    [protocol]               which pedestrians count in the detection figures: a named protocol,
    name = "reasonable"      filters of its own (see nvcore.protocols.Protocol), or both
    height_px = [50, inf]
    occlusion = [0, 1]
    border_px = [5, 5, 5, 5]
    aspect = [1.0, inf]
    tags = ["night"]
    recordings = ["drive_1"]
    expand = 1.25

Paths are relative to the session file. A session written by the program also holds the version
and the sha256 of every input.
"""

from __future__ import annotations

import glob
import os
import tomllib
from collections.abc import Callable
from dataclasses import fields
from pathlib import Path
from typing import Any, TypeVar

import tomli_w

from nvcore.errors import ParameterError, SessionError
from nvcore.inputs.session import (
    RecordingFacts,
    Session,
    Source,
    SystemSource,
    is_frame_range,
    parse_size,
)
from nvcore.params import params_from
from nvcore.protocols import protocol_from

_T = TypeVar("_T")


def read_session(path: Path) -> Session:
    """Read a session file.

    Raises
    ------
    SessionError
        If it cannot be opened, is not TOML, or says something that cannot be done; with the key.
    """
    try:
        content = tomllib.loads(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise SessionError(f"cannot be opened ({error.strerror})", file=path) from error
    except (tomllib.TOMLDecodeError, UnicodeDecodeError, RecursionError) as error:
        raise SessionError(f"is not TOML: {error}", file=path) from error
    return _Parser(path).session(content)


class _Parser:
    """Turns the content of one session file into a `Session`; knows the file for errors."""

    def __init__(self, path: Path):
        self.path = path

    def fail(self, message: str) -> SessionError:
        return SessionError(message, file=self.path)

    def session(self, content: dict[str, Any]) -> Session:
        known = {"recording", "defaults", "truth", "system", "compare", "parameters", "protocol"}
        self.known_keys(content, known | {"written"}, "the session")
        systems = self.tables(content, "system")
        if "truth" not in content or not systems:
            raise self.fail("expected a [truth] table and at least one [[system]]")
        defaults = self.table(content, "defaults")
        self.known_keys(defaults, {"size", "fps", "frames"}, "[defaults]")
        compare = self.table(content, "compare")
        self.known_keys(compare, {"x", "y"}, "[compare]")
        written = self.table(content, "written")
        try:
            params = params_from(self.table(content, "parameters"))
        except ParameterError as error:
            raise self.fail(f"[parameters]: {error}") from error
        try:
            protocol = protocol_from(self.table(content, "protocol"))
        except ParameterError as error:
            raise self.fail(f"[protocol]: {error}") from error
        size = self.value(defaults, "size", str, "[defaults]")
        try:
            parsed_size = None if size is None else parse_size(size)
        except ValueError as error:
            raise self.fail(f"[defaults]: {error}") from error
        hashes = written.get("sha256", {})
        if not isinstance(hashes, dict) or not all(isinstance(v, str) for v in hashes.values()):
            raise self.fail("[written]: expected sha256 to be a table of texts")
        return self.make(
            Session,
            "the session",
            folder=self.path.resolve().parent,
            truth=self.make(
                Source, "[truth]", **self.source(self.table(content, "truth"), "[truth]")
            ),
            systems=tuple(self.system(table) for table in systems),
            recordings=tuple(self.recording(table) for table in self.tables(content, "recording")),
            size=parsed_size,
            fps=self.number(defaults, "fps", "[defaults]"),
            frames=self.value(defaults, "frames", str, "[defaults]"),
            x=self.value(compare, "x", str, "[compare]"),
            y=self.value(compare, "y", str, "[compare]"),
            params=params,
            protocol=protocol,
            hashes=hashes,
        )

    def make(self, kind: Callable[..., _T], where: str, **values: Any) -> _T:
        """The part of a session; what it refuses is an error with the file and the table."""
        try:
            return kind(**values)
        except SessionError as error:
            raise self.fail(f"{where}: {error.message}") from error

    def source(
        self, table: dict[str, Any], where: str, more: frozenset[str] = frozenset()
    ) -> dict[str, Any]:
        self.known_keys(
            table, {"path", "format", "classes", "frame_base", "box_base"} | more, where
        )
        path = table.get("path")
        paths = [path] if isinstance(path, str) else path
        if not isinstance(paths, list) or not paths or not all(isinstance(p, str) for p in paths):
            raise self.fail(f"{where}: expected path to be a text or a list of texts")
        for key in ("frame_base", "box_base"):
            if self.value(table, key, int, where) not in (None, 0, 1):
                raise self.fail(f"{where}: expected {key} to be 0 or 1, found {table[key]!r}")
        return {
            "path": tuple(paths),
            "format": self.value(table, "format", str, where),
            "classes": self.texts(table, "classes", where),
            "frame_base": table.get("frame_base"),
            "box_base": table.get("box_base"),
        }

    def system(self, table: dict[str, Any]) -> SystemSource:
        where = "[[system]]"
        more = frozenset({"name", "threshold", "offset_frames", "offset_px", "scale"})
        scale = table.get("scale", 1.0)
        if isinstance(scale, int | float):
            scale = [scale, scale]
        return self.make(
            SystemSource,
            where,
            **self.source(table, where, more),
            name=self.value(table, "name", str, where),
            threshold=self.number(table, "threshold", where),
            offset_frames=self.value(table, "offset_frames", int, where) or 0,
            offset_px=self.pair(table.get("offset_px", [0, 0]), "offset_px", where),
            scale=self.pair(scale, "scale", where),
        )

    def recording(self, table: dict[str, Any]) -> RecordingFacts:
        where = "[[recording]]"
        self.known_keys(table, {one.name for one in fields(RecordingFacts)}, where)
        name = self.value(table, "name", str, where)
        numbers = {
            key: self.number(table, key, where) for key in ("width", "height", "fps", "horizon")
        }
        return self.make(
            RecordingFacts,
            where,
            name=name or "",
            frames=self.value(table, "frames", str, where),
            pictures=self.value(table, "pictures", str, where),
            first_picture=self.value(table, "first_picture", int, where),
            tags=self.texts(table, "tags", where) or (),
            **numbers,
        )

    def known_keys(self, table: dict[str, Any], known: set[str], where: str) -> None:
        for key in table:
            if key not in known:
                raise self.fail(
                    f"{where} has no key {key!r}; its keys are {', '.join(sorted(known))}"
                )

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

    def value(self, table: dict[str, Any], key: str, kind: type, where: str) -> Any:
        value = table.get(key)
        if value is not None and (not isinstance(value, kind) or isinstance(value, bool)):
            wanted = {str: "a text", int: "a whole number"}[kind]
            raise self.fail(f"{where}: expected {key} to be {wanted}, found {value!r}")
        return value

    def texts(self, table: dict[str, Any], key: str, where: str) -> tuple[str, ...] | None:
        texts = table.get(key)
        if texts is None:
            return None
        if not isinstance(texts, list) or not all(isinstance(text, str) for text in texts):
            raise self.fail(f"{where}: expected {key} to be a list of texts")
        return tuple(texts)

    def pair(self, value: object, key: str, where: str) -> tuple[float, float]:
        if (
            not isinstance(value, list)
            or len(value) != 2
            or not all(isinstance(v, int | float) and not isinstance(v, bool) for v in value)
        ):
            raise self.fail(f"{where}: expected {key} to be two numbers, found {value!r}")
        return float(value[0]), float(value[1])

    def number(self, table: dict[str, Any], key: str, where: str) -> float | None:
        value = table.get(key)
        if value is None:
            return None
        if isinstance(value, bool) or not isinstance(value, int | float):
            raise self.fail(f"{where}: expected {key} to be a number, found {value!r}")
        return float(value)


def write_session(session: Session, *, version: str, fingerprint: str) -> str:
    """The session as TOML text; reading it back gives the same comparison.

    Paths are written absolute, so that the file means the same wherever it lies.
    """
    folder = session.folder
    defaults = {
        "size": None if session.size is None else f"{session.size[0]}x{session.size[1]}",
        "fps": session.fps,
        "frames": _absolute_frames(session.frames, folder),
    }
    content: dict[str, Any] = {
        "written": {
            "version": version,
            "fingerprint": fingerprint,
            "sha256": dict(session.hashes),
        },
        "compare": _given({"x": session.x, "y": session.y}),
        "parameters": session.params.given(),
        "protocol": session.protocol.given(),
        "defaults": _given(defaults),
        "truth": _source_table(session.truth, folder),
    }
    recordings = [
        _given(
            {
                **vars(facts),
                "frames": _absolute_frames(facts.frames, folder),
                "pictures": None if facts.pictures is None else _absolute(facts.pictures, folder),
                "tags": list(facts.tags) or None,
            }
        )
        for facts in session.recordings
    ]
    systems = [
        {
            **_given({"name": system.name}),
            **_source_table(system, folder),
            **_given({"threshold": system.threshold}),
            **_corrections(system),
        }
        for system in session.systems
    ]
    parts = [tomli_w.dumps({key: value for key, value in content.items() if value})]
    # tomli_w would put short tables of a list on one line
    parts += [f"[[recording]]\n{tomli_w.dumps(table)}" for table in recordings]
    parts += [f"[[system]]\n{tomli_w.dumps(table)}" for table in systems]
    return "\n".join(parts)


def _given(values: dict[str, Any]) -> dict[str, Any]:
    return {key: value for key, value in values.items() if value is not None}


def _absolute(path: str, folder: Path) -> str:
    # normpath, not resolve: a glob stays a glob and a link stays a link
    is_glob = glob.has_magic(path) and not (folder / path).exists()
    start = Path(glob.escape(str(folder))) if is_glob else folder
    return Path(os.path.normpath(start / path)).as_posix()


def _absolute_frames(frames: str | None, folder: Path) -> str | None:
    if frames is None or is_frame_range(frames):
        return frames
    return _absolute(frames, folder)


def _source_table(source: Source, folder: Path) -> dict[str, Any]:
    paths = [_absolute(path, folder) for path in source.path]
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
