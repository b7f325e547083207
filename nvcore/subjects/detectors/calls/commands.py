"""``nvcore detect`` and ``nvcore train``: run a detector over recordings, or train it on them."""

from __future__ import annotations

import shlex
from collections.abc import Sequence
from pathlib import Path
from typing import Any, Final

import click

from nvcore.cli.options import command, options_of, refuse_without_session, session_argument
from nvcore.cli.program import program
from nvcore.cli.progress import ShareProgress
from nvcore.cli.steps import job_on
from nvcore.common.wording import one_line
from nvcore.inputs.session import Session
from nvcore.subjects.detectors.calls.arguments import DetectArguments, TrainArguments

# As in nvcore/cli/__init__.py, numpy and OpenCV are imported by the command only.

_SUGGESTED: Final = 8
"""Recordings that the command for a first run names."""


@command(
    "Run a detector over the recordings of a session.",
    "nvcore detect night.toml --detector hog --out hog",
    "nvcore detect night.toml --detector yolo.onnx --set threshold=0.3 --out yolo",
    "nvcore compare hog/session.toml",
)
@session_argument()
@options_of(DetectArguments)
def detect(session_file: Path, **options: Any) -> None:
    """Run a detector over the recordings of a session, and add its boxes as a system.

    SESSION_FILE (TOML) names the ground truth and the pictures of each recording; it need not name
    a system. The detector is given the evaluated frames. How long that will take is said first;
    Ctrl+C ends it and leaves nothing behind. nvcore compare then takes DIR/session.toml. Exit code
    0: fine, 2: bad input.
    """
    from nvcore.subjects.detectors.calls.python import detector_job

    with job_on(session_file, DetectArguments, detector_job, options) as job:
        for caution in job.cautions():
            click.echo(one_line(caution), err=True)
        click.echo(job.expect(), err=True)
        with ShareProgress() as progress:
            written = job.run(progress)
    click.echo(written.run)
    click.echo(one_line(f"written to {options['out']} as {written.name}"), err=True)
    session_path = shlex.quote(str(written.session))
    if len(job.dataset.systems):
        click.echo(one_line(f"compare: {program()} compare {session_path}"), err=True)
    else:
        click.echo(one_line(f"a second system: {program()} detect {session_path} ..."), err=True)


@command(
    "Train a detector on recordings, or on folders of pictures.",
    "nvcore train night.toml --only urban_01 --only urban_02 --out night.npz",
    "nvcore train night.toml --frames :399 --set stride=6 --out night.npz",
    "nvcore train --preset signs --crops signs --background roads --out signs.npz",
)
@session_argument(required=False)
@options_of(TrainArguments)
def train(session_file: Path | None, **options: Any) -> None:
    """Train a detector (Integral Channel Features) on recordings, or on folders of pictures.

    SESSION_FILE (TOML) names the ground truth and the pictures of each recording; it need not name
    a system. Its boxes are learned; what is held out of them calibrates which windows are rejected
    early. The model notes all of it, and the audit says so where it is evaluated on that. Ctrl+C
    ends it and leaves nothing behind. nvcore detect then takes the file. Exit code 0: fine, 2: bad
    input.
    """
    from nvcore.subjects.detectors.calls.python import training_job

    if session_file is None:
        refuse_without_session(options, "hold_out")
    out: Path = options["out"]
    with job_on(session_file, TrainArguments, training_job, options) as job:
        if out.exists():
            click.echo(one_line(f"{out} is there, and is replaced at the end"), err=True)
        with ShareProgress() as progress:
            training = job.run(progress)
    click.echo(training)
    click.echo(one_line(f"written to {out} ({out.stat().st_size / 1000:,.0f} kB)"), err=True)
    trained = {part.recording for part in training.model.trained_on}
    names = _with_pictures(job.session) if isinstance(job.session, Session) else []
    others = [name for name in names if name not in trained]
    click.echo(one_line(_next_step(out, session_file, others)), err=True)


def _with_pictures(session: Session) -> list[str]:
    """Return the names of the compared recordings that have pictures."""
    from nvcore.inputs.session.recordings_file import with_recordings_file

    return [
        entry.title or entry.name
        for entry in with_recordings_file(session).recordings
        if entry.pictures is not None
        and {*session.only_tags} <= {*entry.tags}
        and (not session.only or {entry.name, entry.title} & {*session.only})
    ]


def _next_step(out: Path, session_file: Path | None, others: Sequence[str]) -> str:
    """Return a shell command that runs the model on other recordings, or why there are none."""
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
    n_more = len(others) - _SUGGESTED
    more = f" (or any of {n_more} more recordings)" if n_more > 0 else ""
    return f"run it: {program()} {shlex.join([*words, '--out', str(folder)])}{more}"
