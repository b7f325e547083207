"""``nvcore driver train`` and ``evaluate``: train and evaluate estimators on trials with people."""

from __future__ import annotations

import shlex
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import click

from nvcore.cli.options import (
    check_html_name,
    command,
    flag_of,
    grouped_option,
    options_of,
    with_options,
)
from nvcore.cli.progress import ShareProgress
from nvcore.driver.arguments import EvaluateArguments, TrainArguments
from nvcore.extras import needs
from nvcore.wording import one_line

if TYPE_CHECKING:
    from nvcore.driver.trials.table import TrainingTable

# As in nvcore/cli/__init__.py, numpy and scikit-learn are imported by the commands only.

_ANGLE: Final = ("distance_mm", "shown_width_mm", "picture_width_px")
_File = click.Path(dir_okay=False, path_type=Path)
_LENGTH = click.FloatRange(0, min_open=True)

_JUDGING: Final = (
    ("--square-px", _LENGTH, None, "PX", "Side of the square around the touch that has to overlap "
     "the middle of the pedestrian, in pixels of the picture. Default: 200."),
    ("--square-degrees", click.FloatRange(0, 90, min_open=True), None, "DEG", "The same as a "
     "visual angle, 5 in the paper; it needs the three lengths below."),
    ("--distance-mm", _LENGTH, None, "MM", "From the eye to the screen."),
    ("--shown-width-mm", _LENGTH, None, "MM", "Width of the picture on the screen."),
    ("--picture-width-px", _LENGTH, None, "PX", "Width of the picture in its own pixels."),
    ("--centre-share", click.FloatRange(0, 1), 0.5, None, "Size of that middle, as a share of the "
     "pedestrian's width and height."),
    ("--display-s", click.FloatRange(0, 60), 0.5, "S", "How long a picture is shown; the "
     "adaptation period ends with it."),
)  # fmt: skip
"""Flag, type, default, placeholder of its value and help text."""
_judging_options = with_options(
    *(
        grouped_option(
            "Which responses are right",
            flag,
            type=kind,
            default=default,
            show_default=default is not None,
            metavar=metavar,
            help=text,
        )
        for flag, kind, default, metavar, text in _JUDGING
    )
)


def say_how_to_leave_out(table: TrainingTable) -> None:
    """Print the flags that leave out subjects with odd responses, unless most are odd."""
    names = table.odd_subjects
    if 0 < len(names) <= table.n_subjects / 2:
        flags = shlex.join(part for name in names for part in ("--leave-out", name))
        click.echo(one_line(f"without odd subjects: {flags}"))


@command(
    "Train an estimator on trials with people.",
    "nvcore driver train trials.csv --features features.csv --boxes boxes.csv --out driver.npz",
)
@click.argument("trials", type=_File)
@_judging_options
@options_of(TrainArguments)
def train(trials: Path, out: Path, **options: Any) -> None:
    """Train an estimator of detectability: which share of drivers sees a pedestrian.

    TRIALS (CSV) has a row for each picture shown to a subject. Learned is a regression for each
    adaptation period, and one for all as the comparison; features and settings are chosen by
    cross-validation. Their errors on pedestrians left out stand beside those of a constant. Ctrl+C
    ends it and leaves nothing behind. Exit code 0: fine, 2: bad input.
    """
    with needs("driver", "nvcore driver train needs"):
        from nvcore.driver.estimator_report import render_training
        from nvcore.driver.face import train_driver

    with ShareProgress() as progress:
        training = train_driver(trials, out=out, progress=progress, **_judged(options))
    click.echo(render_training(training))
    say_how_to_leave_out(training.table)
    click.echo(one_line(f"written to {out} ({out.stat().st_size / 1000:,.0f} kB)"), err=True)
    command = shlex.join(["nvcore", "driver", "estimate", "SESSION", "--model", str(out)])
    click.echo(one_line(f"run it: {command} --out DIR"), err=True)


@command(
    "Say how well estimators do on unseen pedestrians.",
    "nvcore driver evaluate trials.csv --features features.csv --boxes boxes.csv --out tables",
    "nvcore driver evaluate trials.csv --features features.csv --html evaluation.html",
)
@click.argument("trials", type=_File)
@_judging_options
@options_of(EvaluateArguments)
def evaluate(trials: Path, out: Path | None, html: Path | None, **options: Any) -> None:
    """Evaluate estimators on TRIALS (CSV), leaving out one pedestrian at a time.

    Each pedestrian is estimated by regressions chosen and trained on all others: one for the
    adaptation period, one for all periods, and the mean of the others; then by each pair of
    features. With 51 pedestrians and 6 periods that is half an hour of processor time; with --quick
    a tenth. Exit code 0: fine, 2: bad input.
    """
    with needs("driver", "nvcore driver evaluate needs"):
        from nvcore.driver.estimator_report import render_evaluation
        from nvcore.driver.face import evaluate_driver

    if html is not None:
        check_html_name("--html", html)
    options = _judged(options)
    with ShareProgress() as progress:
        evaluation = evaluate_driver(trials, out=out, html=html, progress=progress, **options)
    click.echo(render_evaluation(evaluation))
    say_how_to_leave_out(evaluation.table)
    if out is not None:
        click.echo(one_line(f"tables written to {out}"), err=True)
    if html is not None:
        click.echo(one_line(f"figures written to {html}"), err=True)


def _judged(options: dict[str, Any]) -> dict[str, Any]:
    """Replace the options on judging responses by one `Judging`, converting an angle to pixels."""
    from nvcore.driver.trials import Judging, side_of_angle

    square_px, degrees = options.pop("square_px"), options.pop("square_degrees")
    lengths = {name: options.pop(name) for name in _ANGLE}
    flags = ", ".join(map(flag_of, _ANGLE))
    if degrees is None:
        if any(length is not None for length in lengths.values()):
            raise click.UsageError(f"{flags} belong to --square-degrees; give it, too")
        side = square_px or Judging.square_px
    elif square_px is not None:
        raise click.UsageError("give --square-px or --square-degrees, not both")
    elif any(length is None for length in lengths.values()):
        raise click.UsageError(f"--square-degrees needs {flags}")
    else:
        side = side_of_angle(degrees, **lengths)
    shares = {name: options.pop(name) for name in ("centre_share", "display_s")}
    return {**options, "judging": Judging(square_px=side, **shares)}
