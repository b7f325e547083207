"""``nvcore detect``: run a detector over recordings. The commands of detectors."""

from __future__ import annotations

import shlex
from pathlib import Path
from typing import Any, Final

import click

from nvcore.cli.options import command, options_of, session_argument
from nvcore.cli.program import program
from nvcore.cli.progress import ShareProgress
from nvcore.cli.steps import job_on
from nvcore.detectors.arguments import DetectArguments
from nvcore.detectors.training.command import train
from nvcore.wording import one_line

# As in nvcore/cli/__init__.py, numpy and OpenCV are imported by the command only.


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
    from nvcore.detectors.face import detector_job

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


COMMANDS: Final = (train, detect)
