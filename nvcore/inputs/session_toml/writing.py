"""A session written as a session file."""

from __future__ import annotations

import glob
import os
from pathlib import Path
from typing import Any, Final

import tomli_w

from nvcore.inputs.pipes import is_pipe
from nvcore.inputs.session import (
    SYSTEM_KEYS_OF_SUBJECTS,
    TABLES_OF_SUBJECTS,
    RecordingEntry,
    Session,
    Source,
    SystemSource,
)
from nvcore.params.traffic import context_word

ADDED_KEYS: Final = ("threshold", "provenance", *SYSTEM_KEYS_OF_SUBJECTS)
"""Keys of a system that are written as they are, after those of its source."""


def write_session(session: Session, *, version: str, fingerprint: str) -> str:
    """The session as TOML text; reading it back gives the same comparison.

    Paths are written absolute, so that the file means the same wherever it lies. Those of pipes,
    which cannot be read again, are named as such.
    """
    folder = session.folder
    session = session.with_paths(lambda path: _absolute(path, folder), folder=folder)
    table = session.recordings_file
    pipes = [path for path in session.paths() if is_pipe(Path(path))]
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
                "tags": session.only_tags or None,
                "recordings": session.only or None,
                "objects": session.objects.given(),
                "accept": session.accept or None,
                "operating_point": session.operating_point,
            }
        ),
        "primary": session.primary.given(),
        "parameters": _given(session.params.stated()),
        "protocol": session.protocol.given(),
        "recordings": {} if table is None else {"path": table.path},
        "codes": {} if session.codes_file is None else {"path": session.codes_file},
        "defaults": _given(
            {
                "size": None if session.size is None else f"{session.size[0]}x{session.size[1]}",
                "fps": session.fps,
                "frames": session.frames,
            }
        ),
        "truth": _source_table(session.truth),
        **{name: _given(vars(getattr(session, name))) for name in TABLES_OF_SUBJECTS},
    }
    recordings = [_recording_table(entry) for entry in session.recordings]
    systems = [
        {
            **_given({"name": system.name}),
            **_source_table(system),
            **_given({name: getattr(system, name) for name in ADDED_KEYS}),
            **_corrections(system),
        }
        for system in session.systems
    ]
    parts = [tomli_w.dumps({key: value for key, value in content.items() if value})]
    # tomli_w would put short tables of a list on one line
    parts += [f"[[recording]]\n{tomli_w.dumps(table)}" for table in recordings]
    parts += [f"[[system]]\n{tomli_w.dumps(table)}" for table in systems]
    parts += [f"[[published]]\n{tomli_w.dumps(point.given())}" for point in session.published]
    parts += [f"[[code]]\n{tomli_w.dumps(of.given())}" for of in session.codes]
    return "\n".join(parts)


def _recording_table(entry: RecordingEntry) -> dict[str, Any]:
    context = None if entry.context is None else context_word(entry.context)
    own = {"context": context, "tags": entry.tags or None}
    first = {name: getattr(entry, name) for name in ("name", "visible", "visible_map")}
    return _given(first | vars(entry) | own)


def _given(values: dict[str, Any]) -> dict[str, Any]:
    return {key: value for key, value in values.items() if value is not None}


def _absolute(path: str, folder: Path) -> str:
    # normpath, not resolve: a glob stays a glob and a link stays a link
    is_there = os.path.exists(folder / path)  # noqa: PTH110  # False also of a name that is too long
    is_glob = glob.has_magic(path) and not is_there
    start = Path(glob.escape(str(folder))) if is_glob else folder
    return Path(os.path.normpath(start / path)).as_posix()


def _source_table(source: Source) -> dict[str, Any]:
    paths = source.path
    names = ("format", "classes", "frame_base", "box_base", "boxes", "frame_names")
    own = {name: getattr(source, name) for name in names}
    return _given({"path": paths[0] if len(paths) == 1 else paths, **own})


def _corrections(system: SystemSource) -> dict[str, Any]:
    across, down = system.scale
    table: dict[str, Any] = {
        "frame_step": system.frame_step,
        "offset_frames": system.offset_frames,
        "offset_px": system.offset_px,
        "scale": across if across == down else system.scale,
    }
    usual = {"frame_step": 1, "offset_frames": 0, "offset_px": (0, 0), "scale": 1}
    return {name: value for name, value in table.items() if value != usual[name]}
