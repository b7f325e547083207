"""``nvcore train``: a detector trained on recordings with ground truth, or on folders."""

from __future__ import annotations

import shlex
from collections.abc import Sequence
from contextlib import AbstractContextManager, ExitStack, nullcontext
from pathlib import Path
from typing import Any, Final

import click

from nvcore.cli.options import (
    INPUTS,
    OUTPUT,
    GroupedCommand,
    examples,
    grouped_option,
    pair_of,
    part_options,
    refuse_without_session,
    with_options,
)
from nvcore.cli.program import program
from nvcore.cli.progress import ShareProgress, TerminalProgress
from nvcore.cli.steps import errors_of, part_from
from nvcore.inputs.session import Session
from nvcore.inputs.session_toml import read_session
from nvcore.wording import one_line

# As in nvcore/cli/__init__.py, numpy and OpenCV are imported by the command only.

MODEL: Final = "Model"
HELD_OUT: Final = "Held out"
FOLDERS: Final = "Folders of pictures"
PRESET_NAMES: Final = ("pedestrians", "signs", "as-in-report")
SPLITS: Final = ("auto", "object", "recording", "time")

_SELECTION: Final = (
    *("frames", "every", "hold_out", "split", "share", "gap", "least_height", "seed", "crops"),
    *("crop_share", "background"),
)
"""Options that say what is learned: fields of `nvcore.api.train.Selection`."""
_SUGGESTED: Final = 8
"""Recordings that the command for a first run names."""
_PathTo = click.Path(exists=True, file_okay=False, path_type=Path)

_OPTIONS: Final = (
    part_options("Only these of the evaluated frames"),
    grouped_option(
        INPUTS,
        "--every",
        type=click.IntRange(1),
        metavar="N",
        help="Only every Nth evaluated frame, neighbours being much alike. Default: so many that "
        "5,000 boxes are learned at most.",
    ),
    grouped_option(
        INPUTS,
        "--least-height",
        type=click.FloatRange(0),
        metavar="PX",
        help="Lower boxes are neither learned nor background. Default: those that the smallest "
        "scale is too large for.",
    ),
    grouped_option(
        FOLDERS,
        "--crops",
        type=_PathTo,
        metavar="DIR",
        help="Pictures with an object in the middle, or with those that boxes.csv in the folder "
        "lists (file,x,y,w,h, and class if there are several).",
    ),
    grouped_option(
        FOLDERS,
        "--crop-share",
        type=float,
        help="Share of a crop's height that its object takes. Default: as in the window.",
    ),
    grouped_option(
        FOLDERS, "--background", type=_PathTo, metavar="DIR", help="Pictures without an object."
    ),
    grouped_option(
        HELD_OUT,
        "--hold-out",
        multiple=True,
        metavar="RECORDING",
        help="This recording; may be given again.",
    ),
    grouped_option(
        HELD_OUT,
        "--split",
        type=click.Choice(SPLITS),
        default="auto",
        show_default=True,
        help="Without --hold-out: by physical object (tracks of the truth), by recording, or the "
        "end of each recording (time); auto: the first that is possible.",
    ),
    grouped_option(
        HELD_OUT,
        "--share",
        type=float,
        default=0.1,
        show_default=True,
        help="Of the objects, the recordings or the time.",
    ),
    grouped_option(
        HELD_OUT,
        "--gap",
        type=click.IntRange(0),
        default=20,
        show_default=True,
        metavar="N",
        help="Frames before the held-out end of a recording that are left out.",
    ),
    grouped_option(
        MODEL,
        "--preset",
        type=click.Choice(PRESET_NAMES),
        help="Settings to start from. Default: signs where the session is of speed signs, else "
        "pedestrians.",
    ),
    grouped_option(
        MODEL,
        "--set",
        "settings",
        multiple=True,
        metavar="KEY=VALUE",
        help="A setting of the detector, such as stride=6 or scales=1,1.2,1.4; may be given again. "
        "nvcore models icf explains them all.",
    ),
    grouped_option(
        MODEL, "--name", metavar="NAME", help="Name of the model. Default: that of its file."
    ),
    grouped_option(
        MODEL,
        "--seed",
        type=click.IntRange(0),
        default=0,
        show_default=True,
        help="Of all that is drawn at random: the same seed gives the same file.",
    ),
    grouped_option(
        OUTPUT,
        "--out",
        required=True,
        type=click.Path(path_type=Path),
        metavar="FILE",
        help="Write the model into this file (.npz).",
    ),
)


@click.command(
    cls=GroupedCommand,
    short_help="Train a detector on recordings, or on folders of pictures.",
    epilog=examples(
        "nvcore train night.toml --only urban_01 --only urban_02 --out night.npz",
        "nvcore train night.toml --frames :399 --set stride=6 --out night.npz",
        "nvcore train --preset signs --crops signs --background roads --out signs.npz",
    ),
)
@click.argument(
    "session_file",
    required=False,
    type=click.Path(dir_okay=False, path_type=Path),
    metavar="[SESSION_FILE]",
)
@with_options(*_OPTIONS)
def train(session_file: Path | None, **options: Any) -> None:
    """Train a detector (Integral Channel Features) on recordings, or on folders of pictures.

    SESSION_FILE (TOML) names the ground truth and the pictures of each recording; it need not name
    a system. Its boxes are learned; what is held out of them calibrates which windows are rejected
    early. The model notes all of it, and the audit says so where it is evaluated on that. Ctrl+C
    ends it and leaves nothing behind. nvcore detect then takes the file. Exit code 0: fine, 2: bad
    input.
    """
    from nvcore.api.train import Selection, training_job

    out: Path = options["out"]
    if session_file is None:
        refuse_without_session(options, "hold_out")
        session = None
        around: AbstractContextManager[None] = nullcontext()
    else:
        session = read_session(session_file, needs_system=False)
        around = errors_of(session)
    with around, ExitStack() as stack:
        with TerminalProgress(2 if session is None else 2 + len(session.systems)) as steps:
            job = stack.enter_context(
                training_job(
                    *(session, out, Selection(**{name: options[name] for name in _SELECTION})),
                    preset=options["preset"],
                    name=options["name"],
                    settings=dict(pair_of(text, "--set") for text in options["settings"]),
                    part=part_from({**options, "frames": None}),
                    inputs=[] if session_file is None else [session_file],
                    loading=steps,
                )
            )
        if out.exists():
            click.echo(one_line(f"{out} is there, and is replaced at the end"), err=True)
        with ShareProgress() as progress:
            training = job.run(progress)
    click.echo(training)
    click.echo(one_line(f"written to {out} ({out.stat().st_size / 1000:,.0f} kB)"), err=True)
    trained = {part.recording for part in training.model.trained_on}
    names = [] if session is None else _with_pictures(session)
    others = [name for name in names if name not in trained]
    click.echo(one_line(_next_step(out, session_file, others)), err=True)


def _with_pictures(session: Session) -> list[str]:
    """What the recordings are called that the session compares and has pictures of."""
    from nvcore.inputs.recordings_file import with_recordings_file

    return [
        entry.title or entry.name
        for entry in with_recordings_file(session).recordings
        if entry.pictures is not None
        and {*session.only_tags} <= {*entry.tags}
        and (not session.only or {entry.name, entry.title} & {*session.only})
    ]


def _next_step(out: Path, session_file: Path | None, others: Sequence[str]) -> str:
    """How to run the model on recordings that it was not trained on, as a command for a shell."""
    if session_file is not None and not others:
        return (
            "it was trained on all recordings of the session: run it on others, or train again "
            "with --only or --frames"
        )
    folder = out.with_suffix("") if out.suffix else Path(f"{out}_run")
    words = ["detect", "SESSION" if session_file is None else str(session_file)]
    words += ["--detector", str(out)]
    for name in others[:_SUGGESTED]:
        words += ["--only", name]
    return f"run it: {program()} {shlex.join([*words, '--out', str(folder)])}"
