"""Builds a `Session` from a session file and flags of the command line."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any, Final

import click

from nvcore.cli.options import flag_of
from nvcore.common.errors import SessionError
from nvcore.common.wording import one_line
from nvcore.inputs.facts import frames_from, parse_size
from nvcore.inputs.session import SYSTEM_KEYS_OF_SUBJECTS, Session, Source, SystemSource
from nvcore.inputs.session.toml import read_session
from nvcore.settings.objects import Objects, objects_from
from nvcore.settings.params import SETTINGS, Params, params_from
from nvcore.settings.protocols import PROTOCOLS

OF_FILES: Final = (
    *("frame_base", "box_base"),
    *(
        name + end
        for name in ("format", "classes", "boxes", "frame_names")
        for end in ("", "_truth", "_x", "_y")
    ),
)
"""Flags for reading files that are named by flags."""


def session_from(options: dict[str, Any], *, needs_y: bool) -> Session:
    """Build a session from the session file and flags, or from flags alone.

    Flags override the file. Settings without effect are reported on standard error.

    Raises
    ------
    click.UsageError
        If flags are missing or contradict each other.
    NvcoreError
        If the session file or a value cannot be used.
    """
    from nvcore.comparison.measures.table import choose_primary

    given = {name: options[name] for name in SETTINGS if options.get(name) is not None}
    make = _from_flags if options["session_file"] is None else _from_file
    session = make(options, given, needs_y=needs_y)
    session = replace(
        session,
        primary=choose_primary(session.primary, options.get("primary")),
        operating_point=options.get("operating_point") or session.operating_point,
    )
    for name in session.params.without_effect:
        click.echo(_without_effect(name, session.params), err=True)
    return session


def _without_effect(name: str, params: Params) -> str:
    """Describe a setting without effect, and the choice with which it would have one."""
    used_with = SETTINGS[name].used_with
    assert used_with is not None
    choice, values = used_with
    return (
        f"note: {flag_of(name)} {getattr(params, name)} has no effect: it is used with "
        f"{flag_of(choice)} {' or '.join(values)}, not {getattr(params, choice)}"
    )


def _from_flags(options: dict[str, Any], given: dict[str, Any], *, needs_y: bool) -> Session:
    if not options["truth"] or not options["x_paths"] or (needs_y and not options["y_paths"]):
        expected = (
            "--truth, --x and --y; to audit a single system use nvcore check"
            if needs_y
            else "--truth and --x; one system is enough, --y may be added"
        )
        raise click.UsageError(f"give a session file, or {expected}")
    format_of_all = options["format"]
    truth = Source(
        options["truth"],
        format=options["format_truth"] or format_of_all,
        **source_options(options, "truth"),
    )
    systems = [
        SystemSource(
            options[f"{letter}_paths"],
            format=options[f"format_{letter}"] or format_of_all,
            name=options[f"name_{letter}"],
            **source_options(options, letter),
            **_corrections(options, letter),
        )
        for letter in "xy"
        if options[f"{letter}_paths"]
    ]
    session = Session(
        folder=Path.cwd(),
        truth=truth,
        systems=tuple(systems),
        params=params_from(given),
        protocol=PROTOCOLS[options.get("protocol") or "all"],
    )
    return _with_facts(session, options)


def _with_facts(session: Session, options: dict[str, Any]) -> Session:
    """Apply the flags about recordings, which override files, to a session."""
    from nvcore.inputs.session.recordings_file import with_facts

    accepted = dict.fromkeys([*session.accept, *options.get("accept", ())])
    return with_facts(
        replace(session, accept=tuple(accepted)),
        **{name: options[name] for name in ("recordings", "codes", "tags", "only", "fps")},
        objects=objects_from_option(options),
        size=size_option(options),
        frames=frames_from(options["frames"]),
    )


def _from_file(options: dict[str, Any], given: dict[str, Any], *, needs_y: bool) -> Session:
    if options["truth"] or options["x_paths"] or options["y_paths"]:
        raise click.UsageError("give a session file or --truth, --x and --y, not both")
    for name in OF_FILES:
        if options[name] is not None:
            flag = flag_of(name)
            raise click.UsageError(
                f"{flag} is for files named by flags; in a session file write it under [truth] "
                "or [[system]]"
            )
    session = _with_facts(_read(options["session_file"], needs_y=needs_y), options)
    protocol = options.get("protocol")
    x, y = session.names(options["name_x"], options["name_y"])
    session = replace(
        session,
        x=x,
        y=y,
        params=params_from({**session.params.given(), **given}),
        protocol=session.protocol if protocol is None else PROTOCOLS[protocol],
    )
    return replace(session, systems=_corrected(session, options))


def _read(path: Path, *, needs_y: bool) -> Session:
    """Read the session file. For annotations in its place, name the flag that they need."""
    try:
        return read_session(path)
    except SessionError as error:
        is_no_toml = isinstance(error.__cause__, ValueError | IsADirectoryError)
        advice = _advice_on(path, needs_y=needs_y) if is_no_toml else None
        if advice is None:
            raise
        raise click.UsageError(one_line(f"{path} is no session file (TOML): {advice}")) from error


def _advice_on(path: Path, *, needs_y: bool) -> str | None:
    """Describe a file that is not a session file, and its flag if any (None: unknown kind)."""
    from nvcore.common.file_kinds import binary_kind
    from nvcore.inputs.session.proposals import looks_like

    likeness = looks_like(path)
    if likeness is None:
        if not path.is_file():
            return None
        with path.open("rb") as stream:
            kind = binary_kind(stream.read(4096))
        return None if kind is None else f"it is {kind}"
    file_format, role = likeness
    others = "--x FILE and --y FILE" if needs_y else "--x FILE"
    if role == "truth":
        use = f"use --truth {path}, with the detections as {others}"
    else:
        use = f"use --x {path}, with the ground truth as --truth FILE"
    return f"it looks like {file_format.title}: {use}"


def _corrected(session: Session, options: dict[str, Any]) -> tuple[SystemSource, ...]:
    """Return the session's systems, with corrections from the flags in place of their own."""
    systems = list(session.systems)
    names = {"x": session.x, "y": session.y}
    for letter, default in (("x", 0), ("y", 1)):
        corrections = _corrections(options, letter)
        if not corrections:
            continue
        session_names = [system.name for system in systems]
        name = names[letter]
        if name is None and not any(names.values()) and default < len(systems):
            index = default
        elif name is not None and name in session_names:
            index = session_names.index(name)
        else:
            raise click.UsageError(
                f"cannot tell which system of the session is {letter.upper()}, to correct it; name "
                "both systems in the file and under [compare], or by --name-x and --name-y"
            )
        systems[index] = replace(systems[index], **corrections)
    return tuple(systems)


def _corrections(options: dict[str, Any], letter: str) -> dict[str, Any]:
    """Collect the values of a system's own flags: corrections, and files of subjects."""
    names = ("frame_step", "offset_frames", "offset_px", "scale", *SYSTEM_KEYS_OF_SUBJECTS)
    given = {name: options.get(f"{name}_{letter}") for name in names}
    return {
        name: str(Path.cwd() / value) if name in SYSTEM_KEYS_OF_SUBJECTS else value
        for name, value in given.items()
        if value is not None
    }


def size_option(options: dict[str, Any]) -> tuple[int, int] | None:
    """Return width and height given by ``--size``."""
    if options["size"] is None:
        return None
    try:
        return parse_size(options["size"])
    except ValueError as error:
        raise click.BadParameter(str(error), param_hint="--size") from error


def objects_from_option(options: dict[str, Any]) -> Objects | None:
    """Return the objects given by ``--objects``."""
    if options["objects"] is None:
        return None
    try:
        return objects_from([name.strip() for name in options["objects"].split(",")])
    except ValueError as error:
        raise click.BadParameter(str(error), param_hint="--objects") from error


def source_options(options: dict[str, Any], side: str = "") -> dict[str, Any]:
    """Return the fields of `Source` from flags. Flags for one side override those for all."""
    classes, boxes, frame_names = (
        options.get(f"{name}_{side}") or options[name]
        for name in ("classes", "boxes", "frame_names")
    )
    bases = {
        key: None if options[key] is None else int(options[key])
        for key in ("frame_base", "box_base")
    }
    names = None if classes is None else tuple(name.strip() for name in classes.split(","))
    return {"classes": names, "boxes": boxes, "frame_names": frame_names, **bases}
