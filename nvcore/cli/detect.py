"""``nvcore detect`` and ``nvcore models``: detectors run over recordings, and what there is."""

from __future__ import annotations

import shlex
from contextlib import ExitStack
from pathlib import Path
from typing import Any

import click

from nvcore.cli.options import GroupedCommand, examples, options_of
from nvcore.cli.program import program
from nvcore.cli.progress import ShareProgress, TerminalProgress
from nvcore.cli.steps import errors_of
from nvcore.detectors.arguments import DetectArguments
from nvcore.extras import needs
from nvcore.inputs.session_toml import read_session
from nvcore.wording import one_line

# As in nvcore/cli/__init__.py, numpy and OpenCV are imported by the command only.


@click.command(
    cls=GroupedCommand,
    short_help="Run a detector over the recordings of a session.",
    epilog=examples(
        "nvcore detect night.toml --detector hog --out hog",
        "nvcore detect night.toml --detector yolo.onnx --set threshold=0.3 --out yolo",
        "nvcore compare hog/session.toml",
    ),
)
@click.argument("session_file", type=click.Path(dir_okay=False, path_type=Path))
@options_of(DetectArguments)
def detect(session_file: Path, **options: Any) -> None:
    """Run a detector over the recordings of a session; its boxes are one system more.

    SESSION_FILE (TOML) names the ground truth and the pictures of each recording; it need not name
    a system. The detector is given the evaluated frames. How long that will take is said first;
    Ctrl+C ends it and leaves nothing behind. nvcore compare then takes DIR/session.toml. Exit code
    0: fine, 2: bad input.
    """
    from nvcore.api.detect import detector_job

    session = read_session(session_file, needs_system=False)
    with errors_of(session), ExitStack() as stack:
        with TerminalProgress(2 + len(session.systems)) as steps:
            arguments = DetectArguments(session, **options)
            job = stack.enter_context(detector_job(arguments, inputs=[session_file], loading=steps))
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


@click.command(
    cls=GroupedCommand,
    short_help="List the models, or describe one.",
    epilog=examples(
        "nvcore models",
        "nvcore models hog:daimler",
        "nvcore models yolo.onnx",
        "nvcore models estimator.npz",
    ),
)
@click.argument("detector", required=False, metavar="[NAME|FILE]")
@options_of(DetectArguments, "settings")
def models(detector: str | None, settings: dict[str, str]) -> None:
    """List the models that are built in, or describe one: by its NAME, or the FILE it is in.

    Of a detector: what it detects, what it was trained on, and its settings with their meaning;
    icf: every setting of nvcore train. Of an estimator of what the driver sees: what it was trained
    on and which features it takes.
    """
    with needs("detectors", "nvcore models needs"):
        from nvcore.detectors.registry import DETECTORS, open_detector
        from nvcore.driver.estimators.model_file import (
            estimator_path,
            is_estimator_file,
            read_estimator,
        )
        from nvcore.report.detectors import (
            render_about,
            render_detectors,
            render_training_settings,
        )
        from nvcore.report.driver import render_estimator, render_estimators

    if detector is None:
        if settings:
            raise click.UsageError("--set is about a detector; name it")
        click.echo(render_detectors())
        click.echo(render_estimators())
        return
    if detector == "icf":
        if settings:
            raise click.UsageError("--set is about a model; icf is a kind of them")
        click.echo(render_training_settings())
        return
    is_built_in = any(detector in kind.built_in for kind in DETECTORS.values())
    if not is_built_in and is_estimator_file(path := estimator_path(detector)):
        if settings:
            raise click.UsageError("--set is about a detector; this is an estimator")
        click.echo(render_estimator(read_estimator(path)))
        return
    click.echo(render_about(open_detector(detector, settings), detector))
