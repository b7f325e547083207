"""``nvcore detect`` and ``nvcore models``: detectors run over recordings, and what there is."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import click

from nvcore.cli.options import (
    INPUTS,
    OUTPUT,
    GroupedCommand,
    examples,
    grouped_option,
    only_option,
    pair_of,
    tag_option,
)
from nvcore.cli.progress import ShareProgress, TerminalProgress
from nvcore.cli.session_options import frames_option
from nvcore.cli.steps import errors_of, refuse_among_inputs, refuse_to_replace
from nvcore.extras import needs
from nvcore.inputs.session import override_recordings
from nvcore.inputs.session_toml import read_session
from nvcore.wording import one_line

if TYPE_CHECKING:
    from nvcore.dataset.provenance import TrainedOn
    from nvcore.detectors.base import Detector

# As in nvcore/cli/__init__.py, numpy and OpenCV are imported by the command only.

DETECTOR: Final = "Detector"
SYSTEM: Final = "System"

_detector_options = (
    grouped_option(
        DETECTOR,
        "--set",
        "settings",
        multiple=True,
        metavar="KEY=VALUE",
        help="A setting of the detector, such as upscale=2; may be given again. nvcore models "
        "DETECTOR lists them.",
    ),
    grouped_option(
        DETECTOR,
        "--trained-on",
        multiple=True,
        metavar="RECORDING[=F:L]",
        help="A recording, or frames of it, on which the model was trained, where it does not say "
        "so itself; may be given again.",
    ),
)


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
@grouped_option(
    DETECTOR,
    "--detector",
    required=True,
    metavar="NAME|FILE",
    help="hog, hog:daimler, icf:sample, or a model: one that was trained here (.npz) or an ONNX "
    "file (.onnx).",
)
@_detector_options[0]
@_detector_options[1]
@grouped_option(
    DETECTOR,
    "--threads",
    type=click.IntRange(1, 256),
    help="Pictures at a time. Default: as many as there are cores.",
)
@grouped_option(
    OUTPUT,
    "--out",
    required=True,
    type=click.Path(file_okay=False, path_type=Path),
    metavar="DIR",
    help="Write the boxes, how they were made, and session.toml into this folder.",
)
@grouped_option(
    SYSTEM, "--name", metavar="NAME", help="Name of the new system. Default: the detector's."
)
@grouped_option(
    SYSTEM, "--threshold", type=float, help="Its score threshold. Default: the detector's."
)
@grouped_option(
    SYSTEM,
    "--against",
    metavar="SYSTEM",
    help="The system that it is compared with, as X. Default: the session's X.",
)
@tag_option()
@only_option()
@grouped_option(
    INPUTS,
    "--frames",
    metavar="FILE|F:L[:S]",
    help="Evaluated frames: first:last[:step], or a file with a number a line. Default: the "
    "session's.",
)
def detect(
    session_file: Path,
    detector: str,
    settings: Sequence[str],
    trained_on: Sequence[str],
    threads: int | None,
    out: Path,
    name: str | None,
    threshold: float | None,
    against: str | None,
    tags: tuple[str, ...],
    only: tuple[str, ...],
    frames: str | None,
) -> None:
    """Run a detector over the recordings of a session; its boxes are one system more.

    SESSION_FILE (TOML) names the ground truth and the pictures of each recording; it need not name
    a system. The detector is given the evaluated frames. How long that will take is said first;
    Ctrl+C ends it and leaves nothing behind. nvcore compare then takes DIR/session.toml. Exit code
    0: fine, 2: bad input.
    """
    with needs("detectors", "nvcore detect needs"):
        from nvcore.detectors.run import expect, run_detector
        from nvcore.detectors.writing import check_target, outputs, write_detections
        from nvcore.pictures import session_pictures
    from nvcore.inputs.load import load
    from nvcore.inputs.recordings_file import with_recordings_file
    from nvcore.report.detectors import render_expectation, render_run

    session = with_recordings_file(read_session(session_file, needs_system=False))
    session = replace(session, only_tags=tags or session.only_tags, only=only or session.only)
    session = override_recordings(session, frames=frames and frames_option(frames))
    with errors_of(session):
        opened = _opened(detector, settings, trained_on)
        with TerminalProgress(2 + len(session.systems)) as steps:
            dataset = load(session, progress=steps)
        refuse_among_inputs(out, session)
        check_target(dataset, out, name=name, against=against)
        refuse_to_replace(outputs(out, dataset), _inputs(session_file, session, detector))
        pictures = session_pictures(dataset.settings, dataset)  # type: ignore[arg-type]
        try:
            expectation = expect(opened, pictures, n_threads=threads)
            n_recordings = len(pictures.sources)
            click.echo(render_expectation(expectation, n_recordings), err=True)
            with ShareProgress() as progress:
                run = run_detector(opened, dataset, pictures, n_threads=threads, progress=progress)
        finally:
            pictures.close()
        written = write_detections(
            run, dataset, out, name=name, threshold=threshold, against=against
        )
    click.echo(render_run(run))
    click.echo(one_line(f"written to {out} as {written.name}"), err=True)
    if len(dataset.systems):
        click.echo(one_line(f"compare: nvcore compare {written.session}"), err=True)
    else:
        click.echo(one_line(f"a second system: nvcore detect {written.session} ..."), err=True)


def _opened(detector: str, settings: Sequence[str], trained_on: Sequence[str]) -> Detector:
    """The detector that the flags name, with what they say of its training."""
    from nvcore.detectors.registry import open_detector

    opened = open_detector(detector, dict(pair_of(text, "--set") for text in settings))
    if trained_on:
        about = opened.about
        parts = (*about.trained_on, *(_part(text) for text in trained_on))
        opened.about = replace(about, trained_on=parts)
    return opened


def _part(text: str) -> TrainedOn:
    """A recording of the training, with its frames if they are given."""
    from nvcore.dataset.provenance import TrainedOn

    match = re.fullmatch(r"(.+)=(-?\d{0,15}):(-?\d{0,15})", text, re.DOTALL)
    if match is None:
        return TrainedOn(recording=text)
    name, *ends = match.groups()
    first, last = (int(end) if end else None for end in ends)
    return TrainedOn(recording=name, first_frame=first, last_frame=last)


def _inputs(session_file: Path, session: Any, detector: str) -> list[Path]:
    """What is read, and must not be replaced."""
    from nvcore.report.protect_inputs import files_read

    return [session_file, Path(detector), *files_read(session)]


@click.command(
    cls=GroupedCommand,
    short_help="List the detectors, or describe a model.",
    epilog=examples("nvcore models", "nvcore models hog:daimler", "nvcore models yolo.onnx"),
)
@click.argument("detector", required=False, metavar="[DETECTOR]")
@_detector_options[0]
def models(detector: str | None, settings: Sequence[str]) -> None:
    """List the detectors that are built in, or describe DETECTOR: a name, or a model's file.

    What a model detects, what it was trained on, and its settings with their meaning.
    """
    with needs("detectors", "nvcore models needs"):
        from nvcore.report.detectors import render_about, render_detectors

    if detector is None:
        if settings:
            raise click.UsageError("--set is about a detector; name it")
        click.echo(render_detectors())
        return
    click.echo(render_about(_opened(detector, settings, ())))
