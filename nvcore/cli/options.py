"""Flags of the command line that name inputs and settings, and the `Session` they make."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from nvcore.errors import InputError
from nvcore.inputs.session import (
    Session,
    Source,
    SystemSource,
    is_frame_range,
    parse_size,
    with_facts,
)
from nvcore.inputs.session_toml import read_session
from nvcore.params import SETTINGS, params_from
from nvcore.protocols import PROTOCOLS

if TYPE_CHECKING:
    from nvcore.findings import Finding
    from nvcore.inputs.readers.base import Role

# Nothing here imports numpy, pandas or numba: `nvcore --help` need not wait for them.

FORMAT_NAMES = (
    "bbgt", "coco", "coco-results", "csv", "cvat-images", "cvat-video", "kaist-results",
    "kitti-detections", "kitti-object", "kitti-tracking", "mot", "voc", "yolo",
)  # fmt: skip
"""Names of all formats; a test compares them with the registry."""


INPUTS, READING, FACTS, CORRECTIONS, OUTPUT = (
    "Inputs", "How files are read", "What the files do not say", "Corrections", "Output",
)  # fmt: skip
"""Headings of the help, beside those of the parameters and click's own."""


class GroupedOption(click.Option):
    """An option that stands under a heading of its own in the help."""

    def __init__(self, *arguments: Any, group: str, **settings: Any):
        super().__init__(*arguments, **settings)
        self.group = group


class GroupedCommand(click.Command):
    """A command whose help has a heading for each group of options, in order of appearance."""

    def format_options(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """Write the options, group by group."""
        groups: dict[str, list[tuple[str, str]]] = {}
        for param in self.get_params(ctx):
            record = param.get_help_record(ctx)
            if isinstance(param, click.Option) and record is not None:
                groups.setdefault(getattr(param, "group", "Other"), []).append(record)
        for name, records in groups.items():
            with formatter.section(name):
                formatter.write_dl(records)


def grouped_option(group: str, *names: str, **settings: Any) -> Callable[..., Any]:
    """`click.option` with the heading that it stands under."""
    return click.option(*names, cls=GroupedOption, group=group, **settings)


class _Pair(click.ParamType[tuple[float, float]]):
    """One or two numbers with a comma between them."""

    def __init__(self, name: str, *, may_be_one: bool = False):
        self.name = name
        self.may_be_one = may_be_one

    def convert(
        self, value: Any, param: click.Parameter | None, ctx: click.Context | None
    ) -> tuple[float, float]:
        parts = value.split(",")
        try:
            numbers = [float(part) for part in parts]
        except ValueError:
            numbers = []
        if len(numbers) == 1 and self.may_be_one:
            numbers *= 2
        if len(numbers) != 2:
            wanted = "one number, or two" if self.may_be_one else "two numbers"
            self.fail(f"expected {wanted} with a comma between, found {value!r}", param, ctx)
        return numbers[0], numbers[1]


def flag_of(name: str) -> str:
    """The flag of a parameter."""
    return "--" + name.replace("_", "-")


def parameter_options(command: Callable[..., Any]) -> Callable[..., Any]:
    """Flags for all live parameters, made from the fields of `Params`."""
    for name, setting in reversed(SETTINGS.items()):
        kind: Any = float if setting.words is None else click.Choice(list(setting.words))
        text = setting.meaning
        if setting.default is not None:  # else it says what is taken in its place
            text += f" Default: {setting.default} {setting.unit}".rstrip() + "."
        option = grouped_option(setting.stage.group, flag_of(name), name, type=kind, help=text)
        command = option(command)
    return command


protocol_option = grouped_option(
    "Detection figures",
    "--protocol",
    type=click.Choice(list(PROTOCOLS)),
    help="Which pedestrians count in the detection figures, such as the log-average miss rate "
    "(docs/detection.md). Default: the session file's, or all.",
)
"""The flag for the protocol of the detection figures."""

format_option = grouped_option(
    READING,
    "--format",
    "format_",
    metavar="FORMAT",
    help="Format of all files, one of " + ", ".join(FORMAT_NAMES) + ". Default: told from their "
    "content.",
)
"""The flag for the format of all inputs."""

reading_options = (
    grouped_option(
        READING,
        "--classes",
        metavar="NAMES",
        help="Class names or numbers that count as pedestrians, with commas. Default: the format's "
        "usual ones.",
    ),
    grouped_option(
        FACTS,
        "--size",
        metavar="WxH",
        help="Image size in pixels, such as 640x480. Default: told by the data.",
    ),
    grouped_option(
        READING,
        "--frame-base",
        type=click.Choice(["0", "1"]),
        help="Number of the first frame, for formats that leave it open (csv).",
    ),
    grouped_option(
        READING,
        "--box-base",
        type=click.Choice(["0", "1"]),
        help="Coordinate of the first pixel, for Pascal VOC. Default: 1.",
    ),
)
"""Flags that say how files are read."""


def input_options(command: Callable[..., Any]) -> Callable[..., Any]:
    """Flags that name the inputs and the facts which they lack."""
    options = [
        click.argument("session_file", required=False, type=click.Path(path_type=Path)),
        grouped_option(INPUTS, "--truth", multiple=True, metavar="PATH",
                       help="Ground truth: file, folder or quoted glob; may be given again."),
        grouped_option(INPUTS, "--x", "x_paths", multiple=True, metavar="PATH",
                       help="Detections of system X: file, folder or quoted glob; may be given "
                       "again."),
        grouped_option(INPUTS, "--y", "y_paths", multiple=True, metavar="PATH",
                       help="Detections of system Y, likewise."),
        grouped_option(INPUTS, "--name-x", metavar="NAME",
                       help="Name of X; with a session file: which of its systems is X. Default: "
                       "told from the path, or the first of the session."),
        grouped_option(INPUTS, "--name-y", metavar="NAME", help="Name of Y, likewise."),
        format_option,
        grouped_option(READING, "--format-truth", metavar="FORMAT",
                       help="Format of the ground truth, where it differs."),
        grouped_option(READING, "--format-x", metavar="FORMAT", help="Format of X, likewise."),
        grouped_option(READING, "--format-y", metavar="FORMAT", help="Format of Y, likewise."),
        *reading_options,
        grouped_option(FACTS, "--fps", type=float,
                       help="Frames per second. Default: told by the data."),
        grouped_option(FACTS, "--frames", metavar="FILE|F:L[:S]",
                       help="Evaluated frames: first:last[:step], or a file with a number a line. "
                       "Default: the truth's own list, or from its first to its last annotated "
                       "frame."),
    ]  # fmt: skip
    for letter in "xy":
        system = letter.upper()
        options += [
            grouped_option(CORRECTIONS, f"--offset-frames-{letter}", type=int, metavar="N",
                           help=f"Added to {system}'s frame numbers."),
            grouped_option(CORRECTIONS, f"--offset-px-{letter}", type=_Pair("DX,DY"),
                           metavar="DX,DY",
                           help=f"Added to {system}'s x and y, in pixels, after scaling."),
            grouped_option(CORRECTIONS, f"--scale-{letter}", type=_Pair("S", may_be_one=True),
                           metavar="S|SX,SY",
                           help=f"By which {system}'s boxes are multiplied (across, down)."),
        ]  # fmt: skip
    for option in reversed(options):
        command = option(command)
    return command


def session_from(options: dict[str, Any], *, needs_y: bool) -> Session:
    """The session file, or one made from the flags; flags go before the file.

    Raises
    ------
    click.UsageError
        If the flags do not go together.
    NvcoreError
        If the session file or a value cannot be used.
    """
    given = {name: options[name] for name in SETTINGS if options.get(name) is not None}
    if options["session_file"] is not None:
        return _from_file(options, given)
    if not options["truth"] or not options["x_paths"] or (needs_y and not options["y_paths"]):
        wanted = (
            "--truth, --x and --y; to audit a single system use nvcore check"
            if needs_y
            else "--truth and --x; one system is enough, --y may be added"
        )
        raise click.UsageError(f"give a session file, or {wanted}")
    whole = options["format_"]
    common = source_options(options)
    truth = Source(options["truth"], format=options["format_truth"] or whole, **common)
    systems = [
        SystemSource(
            options[f"{letter}_paths"],
            format=options[f"format_{letter}"] or whole,
            name=options[f"name_{letter}"],
            **common,
            **_corrections(options, letter),
        )
        for letter in "xy"
        if options[f"{letter}_paths"]
    ]
    return Session(
        folder=Path.cwd(),
        truth=truth,
        systems=tuple(systems),
        size=size_option(options),
        fps=options["fps"],
        frames=None if options["frames"] is None else _frames(options["frames"]),
        params=params_from(given),
        protocol=PROTOCOLS[options.get("protocol") or "all"],
    )


def _from_file(options: dict[str, Any], given: dict[str, Any]) -> Session:
    if options["truth"] or options["x_paths"] or options["y_paths"]:
        raise click.UsageError("give a session file or --truth, --x and --y, not both")
    for name in ("format_", "format_truth", "format_x", "format_y", "classes", "frame_base",
                 "box_base"):  # fmt: skip
        if options[name] is not None:
            flag = flag_of(name.rstrip("_"))
            raise click.UsageError(
                f"{flag} is for files named by flags; in a session file write it under [truth] "
                "or [[system]]"
            )
    # a flag goes before what the file says, of single recordings, too
    session = with_facts(
        read_session(options["session_file"]),
        size=size_option(options),
        fps=options["fps"],
        frames=None if options["frames"] is None else _frames(options["frames"]),
    )
    protocol = options.get("protocol")
    session = replace(
        session,
        x=options["name_x"] or session.x,
        y=options["name_y"] or session.y,
        params=params_from({**session.params.given(), **given}),
        protocol=session.protocol if protocol is None else PROTOCOLS[protocol],
    )
    return replace(session, systems=_corrected(session, options))


def _corrected(session: Session, options: dict[str, Any]) -> tuple[SystemSource, ...]:
    """The session's systems with the corrections of the flags in place of their own."""
    systems = list(session.systems)
    chosen = {"x": session.x, "y": session.y}
    for letter, default in (("x", 0), ("y", 1)):
        corrections = _corrections(options, letter)
        if not corrections:
            continue
        named = [system.name for system in systems]
        wanted = chosen[letter]
        if wanted is None and not any(chosen.values()) and default < len(systems):
            at = default
        elif wanted is not None and wanted in named:
            at = named.index(wanted)
        else:
            raise click.UsageError(
                f"cannot tell which system of the session is {letter.upper()}, to correct it; name "
                "both systems in the file and under [compare], or by --name-x and --name-y"
            )
        systems[at] = replace(systems[at], **corrections)
    return tuple(systems)


def _corrections(options: dict[str, Any], letter: str) -> dict[str, Any]:
    names = ("offset_frames", "offset_px", "scale")
    return {
        name: options[f"{name}_{letter}"]
        for name in names
        if options[f"{name}_{letter}"] is not None
    }


def size_option(options: dict[str, Any]) -> tuple[int, int] | None:
    """Width and height given by ``--size``."""
    if options["size"] is None:
        return None
    try:
        return parse_size(options["size"])
    except ValueError as error:
        raise click.BadParameter(str(error), param_hint="--size") from error


def source_options(options: dict[str, Any]) -> dict[str, Any]:
    """Fields of `Source` that the flags give."""
    classes = options["classes"]
    bases = {
        key: None if options[key] is None else int(options[key])
        for key in ("frame_base", "box_base")
    }
    names = None if classes is None else tuple(name.strip() for name in classes.split(","))
    return {"classes": names, **bases}


def _frames(text: str) -> str:
    """A frame list file named by flag is relative to where the command runs."""
    return text if is_frame_range(text) else str(Path.cwd() / text)


def sources_of(session: Session) -> list[tuple[Source, Role]]:
    """The session's sources, each with what it holds."""
    systems: list[tuple[Source, Role]] = [(system, "detections") for system in session.systems]
    return [(session.truth, "truth"), *systems]


@contextmanager
def pasteable_errors(folder: Path, sources: list[tuple[Source, Role]]) -> Iterator[None]:
    """Within it, errors name a file by a path that can be pasted into the terminal."""
    try:
        yield
    except InputError as error:
        from nvcore.inputs.files import paths_to_show

        path = None if error.file is None else paths_to_show(folder, sources).get(error.file)
        if path is None:
            raise
        raise InputError(error.message, file=path, line=error.line) from error


def findings_at_paths(findings: tuple[Finding, ...], shown: dict[str, str]) -> tuple[Finding, ...]:
    """Findings that name their files as `nvcore.inputs.files.paths_to_show` says."""
    return tuple(replace(one, file=shown.get(one.file, one.file)) for one in findings)
