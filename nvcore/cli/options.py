"""Flags of the command line that name inputs and settings."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import MISSING, fields
from pathlib import Path
from typing import Any

import click

from nvcore.common.arguments import (
    CORRECTIONS,
    FACTS,
    FILE,
    FRAMES,
    INPUTS,
    OTHER,
    OUTPUT,
    READING,
    Arguments,
    Part,
)
from nvcore.common.subject import subjects
from nvcore.common.wording import listed, one_line
from nvcore.inputs.facts import FRAME_NAMES
from nvcore.settings.defaults import POINTS
from nvcore.settings.objects import PEDESTRIAN
from nvcore.settings.params import AUDIT_SETTINGS, SETTINGS
from nvcore.settings.primary import DEFAULT
from nvcore.settings.protocols import PROTOCOLS

# Nothing here imports numpy, pandas or numba, so that `nvcore --help` need not wait for them.

DETECTION = "Detection measures"
"""Heading of the help, besides those of `nvcore.common.arguments` and of the parameters."""


class GroupedOption(click.Option):
    """Option with a heading in the help."""

    def __init__(self, *arguments: Any, group: str, **settings: Any):
        super().__init__(*arguments, **settings)
        self.group = group


class GroupedCommand(click.Command):
    """Command whose help has a heading for each group of options.

    Options that every run needs come first, settings of the measures last.
    """

    def format_options(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """Write the options, group by group."""
        groups: dict[str, list[tuple[str, str]]] = {}
        for param in self.get_params(ctx):
            record = param.get_help_record(ctx)
            if isinstance(param, click.Option) and record is not None:
                groups.setdefault(getattr(param, "group", OTHER), []).append(record)
        # a stable sort: groups of the same place keep their order
        for name, records in sorted(groups.items(), key=lambda item: _place(item[0])):
            with formatter.section(name):
                formatter.write_dl(records)


def _place(group: str) -> int:
    """Return a group's place in the help. A command's own groups come after its inputs."""
    last = (DETECTION, *(setting.group for setting in SETTINGS.values()), OTHER)
    order = (INPUTS, "", OUTPUT, FACTS, READING, CORRECTIONS, *last)
    return order.index(group if group in order else "")


def examples(*lines: str) -> str:
    """Return the end of a help text: example command lines, which click does not wrap."""
    title = "Example:" if len(lines) == 1 else "Examples:"
    return "\n".join(["\b", title, *(f"  {line}" for line in lines)])


def command(
    short_help: str, *lines: str, name: str | None = None
) -> Callable[[Callable[..., Any]], click.Command]:
    """Declare a command with its line in the list of commands, and the examples in its help."""
    return click.command(name, GroupedCommand, short_help=short_help, epilog=examples(*lines))


def session_argument(*, required: bool = True) -> Callable[[Callable[..., Any]], Any]:
    """Return the argument that names a session file."""
    return click.argument(
        "session_file",
        required=required,
        type=FILE,
        metavar="SESSION_FILE" if required else "[SESSION_FILE]",
    )


def check_html_name(flag: str, file: Path) -> None:
    """Check that an output is named as an HTML file, which protects inputs named by mistake.

    Raises
    ------
    click.UsageError
        If the name has another ending.
    """
    if file.suffix.lower() not in (".html", ".htm"):
        raise click.UsageError(
            f"{flag}: expected a file that ends in .html, got {one_line(str(file))}"
        )


def grouped_option(group: str, *names: str, **settings: Any) -> Callable[..., Any]:
    """Declare a `click.option` under a heading of the help."""
    return click.option(*names, cls=GroupedOption, group=group, **settings)


def with_options(
    *options: Callable[..., Any],
) -> Callable[[Callable[..., Any]], Callable[..., Any]]:
    """Add flags to a command, in this order."""

    def decorate(command: Callable[..., Any]) -> Callable[..., Any]:
        for option in reversed(options):
            command = option(command)
        return command

    return decorate


def options_of(kind: type, *names: str) -> Callable[[Callable[..., Any]], Callable[..., Any]]:
    """Add flags for the fields of an arguments class that were made by `argument`.

    Parameters
    ----------
    names
        Only these fields. Empty: all.
    """
    options = []
    flags = {spec.name: flag_of(spec.name) for spec in fields(kind)}
    for spec in sorted(fields(kind), key=lambda spec: spec.kw_only is True):
        if "flag" not in spec.metadata or (names and spec.name not in names):
            continue
        facts = dict(spec.metadata["facts"])
        facts["help"] = facts["help"].format(again="may be given again", **flags)
        if spec.default is MISSING:
            facts["required"] = True
        elif spec.default != ():  # None as well: it is the third value of a flag with a negation
            facts |= {"default": spec.default, "show_default": spec.default not in (None, "")}
        flag = spec.metadata["flag"] or flag_of(spec.name)
        options.append(grouped_option(facts.pop("group"), flag, spec.name, **facts))
    return with_options(*options)


def arguments_of(kind: type[Arguments], options: Mapping[str, Any]) -> Arguments:
    """Collect the arguments of this class from the options of a command."""
    return kind(**{spec.name: options[spec.name] for spec in fields(kind)})  # type: ignore[arg-type]


def refuse_without_session(options: Mapping[str, Any], *more: str) -> None:
    """Refuse the flags of `Part`, and `more` such flags, if no session is named."""
    names = (*(spec.name for spec in fields(Part)), *more)
    if any(options[name] for name in names):
        flags = listed([flag_of("tag" if name == "tags" else name) for name in names])
        raise click.UsageError(f"{flags} are about a session; name its file")


class PairOf(click.ParamType[tuple[float, float]]):
    """Type of a flag that takes two numbers separated by a comma, or one if `may_be_one`."""

    def __init__(self, name: str, *, may_be_one: bool = False):
        self.name = name
        self.may_be_one = may_be_one

    def convert(
        self, value: Any, param: click.Parameter | None, ctx: click.Context | None
    ) -> tuple[float, float]:
        """Parse the numbers."""
        parts = value.split(",")
        try:
            numbers = [float(part) for part in parts]
        except ValueError:
            numbers = []
        if len(numbers) == 1 and self.may_be_one:
            numbers *= 2
        if len(numbers) != 2:
            expected = "one number, or two" if self.may_be_one else "two numbers"
            self.fail(f"expected {expected} with a comma between, found {value!r}", param, ctx)
        return numbers[0], numbers[1]


def flag_of(name: str) -> str:
    """Return the flag of a parameter."""
    return "--" + name.replace("_", "-")


def parameter_options(command: Callable[..., Any]) -> Callable[..., Any]:
    """Add flags for all live parameters, made from the fields of `Params`."""
    return _with_parameters(command, SETTINGS)


def audit_options(command: Callable[..., Any]) -> Callable[..., Any]:
    """Add flags for the parameters that affect the audit of the inputs."""
    return _with_parameters(command, AUDIT_SETTINGS)


def _with_parameters(command: Callable[..., Any], names: Iterable[str]) -> Callable[..., Any]:
    for name, setting in reversed([(name, SETTINGS[name]) for name in names]):
        number = int if setting.is_whole else float
        kind: Any = number if setting.words is None else click.Choice(list(setting.words))
        text = PEDESTRIAN.say(setting.meaning)
        if setting.default is not None:  # otherwise the meaning names the replacement
            text += f" Default: {setting.default} {setting.unit}".rstrip() + "."
        option = grouped_option(setting.group, flag_of(name), name, type=kind, help=text)
        command = option(command)
    return command


protocol_option = grouped_option(
    DETECTION,
    "--protocol",
    type=click.Choice(list(PROTOCOLS)),
    help="Which pedestrians count in the detection measures, such as the log-average miss rate "
    "(docs/detection.md). Default: the session file's, or all.",
)
"""Flag for the protocol of the detection measures."""

strict_option = grouped_option(
    OUTPUT, "--strict", is_flag=True, help="Warnings of the audit give exit code 1, too."
)
"""Flag that makes warnings affect the exit code."""

format_option = grouped_option(
    READING,
    "--format",
    metavar="FORMAT",
    help="Format of all files, such as csv, coco or kitti-tracking (all: docs/formats.md). "
    "Default: by their content.",
)
"""Flag for the format of all inputs."""

objects_option = grouped_option(
    READING,
    "--objects",
    metavar="NAME[,PLURAL]",
    help="What the boxes are of: 'speed sign', or any other singular, and its plural if an s does "
    "not make it. Default: the session file's, or pedestrian.",
)
"""Flag for the kind of objects."""

reading_options = (
    grouped_option(
        READING,
        "--classes",
        metavar="NAMES",
        help="Class names or numbers that count, with commas. Default: the usual ones of the "
        "format and of --objects.",
    ),
    options_of(Part, "size"),
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
    grouped_option(
        READING,
        "--boxes",
        metavar="LAYOUT",
        help="What the four numbers of a box are: sizes (left, top, width, height), corners (left, "
        "top, right, bottom) or centres (centre x, centre y, width, height); -yx behind it: the "
        "vertical number first; -shares, -percent, -thousandths: of the picture, as in "
        "corners-yx-shares. Default: as the format has them.",
    ),
    grouped_option(
        READING,
        "--frame-names",
        type=click.Choice(FRAME_NAMES),
        help="What names of pictures and large frame numbers are: numbers of frames; times; "
        "nothing, and the pictures follow in their order; numbers of several scenes, each a "
        "recording; several numbers, the counter before the last. Default: by what they look like.",
    ),
)
"""Flags for reading files."""


verdict_options = (
    grouped_option(
        INPUTS,
        "--primary",
        metavar="KEY",
        help="The measure by which to decide, to be chosen before the verdict is seen: it is "
        "tested by itself, and others are claimed only if it shows a difference; such as "
        "mean_similarity or encounters_detected. Default: the session's, or "
        f"{DEFAULT}.",
    ),
    grouped_option(
        INPUTS,
        "--operating-point",
        type=click.Choice(POINTS),
        help="Where X and Y are set to unequally many false alarms: their numbers as set, or "
        "with one threshold moved, so that both have equally many. Claims are about these "
        "either way. delivered: the thresholds are those of products; numbers and claims are as "
        "set, and the better system may not have clearly more false alarms. Default: the "
        "session's, or as-set (of a report: equal-alarms).",
    ),
    grouped_option(
        OUTPUT,
        "--accept",
        multiple=True,
        metavar="CODE",
        help="An error of the audit that is meant, such as no-match: it is a warning; may be "
        "given again.",
    ),
)
"""Flags for judging X and Y."""


def input_options(command: Callable[..., Any]) -> Callable[..., Any]:
    """Add the argument for a session file, and flags for inputs, missing facts and verdict."""
    session = click.argument("session_file", required=False, type=click.Path(path_type=Path))
    for option in reversed(verdict_options):
        command = option(command)
    return session(input_flags(command))


def input_flags(command: Callable[..., Any]) -> Callable[..., Any]:
    """Add the flags for inputs and facts only."""
    options = [
        grouped_option(
            INPUTS,
            "--truth",
            multiple=True,
            metavar="PATH",
            help="Ground truth: file, folder or quoted glob; may be given again.",
        ),
        grouped_option(
            INPUTS,
            "--x",
            "x_paths",
            multiple=True,
            metavar="PATH",
            help="Detections of system X: file, folder or quoted glob; may be given again.",
        ),
        grouped_option(
            INPUTS,
            "--y",
            "y_paths",
            multiple=True,
            metavar="PATH",
            help="Detections of system Y, likewise.",
        ),
        grouped_option(
            INPUTS,
            "--name-x",
            metavar="NAME",
            help="Name of X; with a session file: which of its systems is X. Default: "
            "from the path, or the first of the session.",
        ),
        grouped_option(INPUTS, "--name-y", metavar="NAME", help="Name of Y, likewise."),
        format_option,
        *reading_options,
        *(
            grouped_option(
                READING, f"--{kind}-{end}", help=f"As --{kind}, of {whose} alone.", **values
            )
            for kind, values in (
                ("format", {"metavar": "FORMAT"}),
                ("classes", {"metavar": "NAMES"}),
                ("boxes", {"metavar": "LAYOUT"}),
                ("frame-names", {"type": click.Choice(FRAME_NAMES), "metavar": "WAY"}),
            )
            for end, whose in (("truth", "the ground truth"), ("x", "X"), ("y", "Y"))
        ),
        objects_option,
        options_of(Part, "fps"),
        grouped_option(
            FACTS,
            "--recordings",
            metavar="FILE",
            help="CSV file with a line for each recording: recording,width,height,fps,context,"
            "speed_kmh,horizon,tags,title,unit,pictures,first_picture (docs/formats.md). --size "
            "and --fps go before it.",
        ),
        grouped_option(
            FACTS,
            "--codes",
            metavar="FILE",
            help="CSV file of stretches with a code, such as glare: recording,start_s,end_s,code "
            "(docs/formats.md); in place of the session's.",
        ),
        grouped_option(
            FACTS,
            "--frames",
            metavar="FILE|F:L[:S]",
            help=f"Evaluated frames: {FRAMES} Default: the truth's own list, or from its first to "
            "its last annotated frame.",
        ),
        grouped_option(
            INPUTS,
            "--tag",
            "tags",
            multiple=True,
            metavar="TAG",
            help="Compare only recordings with this tag; may be given again: with all of them.",
        ),
        grouped_option(
            INPUTS,
            "--only",
            multiple=True,
            metavar="RECORDING",
            help="Compare only this recording; may be given again.",
        ),
    ]
    for letter in "xy":
        system = letter.upper()
        options += [
            grouped_option(
                INPUTS,
                f"{flag_of(spec.name)}-{letter}",
                metavar="FILE",
                help=spec.metadata["meaning"].format(system=system),
            )
            for subject in subjects()
            for kind in subject.session_keys().system
            for spec in fields(kind)
            if spec.metadata["meaning"]
        ]
        options += [
            grouped_option(
                CORRECTIONS,
                f"--frame-step-{letter}",
                type=float,
                metavar="FACTOR",
                help=f"By which {system}'s frame numbers are multiplied, where it counts at "
                "another rate.",
            ),
            grouped_option(
                CORRECTIONS,
                f"--offset-frames-{letter}",
                type=int,
                metavar="N",
                help=f"Added to {system}'s frame numbers.",
            ),
            grouped_option(
                CORRECTIONS,
                f"--offset-px-{letter}",
                type=PairOf("DX,DY"),
                metavar="DX,DY",
                help=f"Added to {system}'s x and y, in pixels, after scaling.",
            ),
            grouped_option(
                CORRECTIONS,
                f"--scale-{letter}",
                type=PairOf("S", may_be_one=True),
                metavar="S|SX,SY",
                help=f"By which {system}'s boxes are multiplied (across, down).",
            ),
        ]
    return with_options(*options)(command)
