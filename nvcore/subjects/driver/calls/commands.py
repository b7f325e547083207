"""``nvcore driver``: estimate what the driver would have seen unaided."""

from __future__ import annotations

import shlex
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import click

from nvcore.cli.options import (
    PairOf,
    check_html_name,
    command,
    flag_of,
    grouped_option,
    options_of,
    refuse_without_session,
    session_argument,
    with_options,
)
from nvcore.cli.progress import ShareProgress
from nvcore.cli.steps import job_on, say_written
from nvcore.common.arguments import FILE, INPUTS
from nvcore.common.extras import needs
from nvcore.common.wording import one_line
from nvcore.subjects.driver.calls.arguments import (
    VIEW,
    EstimateArguments,
    EvaluateArguments,
    FeatureArguments,
    TrainArguments,
)

if TYPE_CHECKING:
    from nvcore.subjects.driver.trials.table import TrainingTable

# Nothing here imports numpy, pandas, OpenCV or scikit-learn, to keep `nvcore --help` fast.

LIGHT: Final = "Light"
_SETTINGS: Final = {
    ("--surround", "FACTOR", VIEW): "Sides of the region around a pedestrian, as a multiple of the "
    "box's. Default: 2.",
    ("--bin-distance", None, VIEW): "Distance of neighbouring bins in the Earth Mover's Distance "
    "of colours. Default: 1.",
    ("--fixation", "X,Y", VIEW): "Where the driver is assumed to look without a gaze file, as "
    "shares of the picture's width and height. Default: 0.5,0.5, its middle.",
    ("--drop-factor", "FACTOR", LIGHT): "By so much the light falls in a change from bright to "
    "dark. Default: 10.",
    ("--picture-drop-factor", "FACTOR", LIGHT): "The same of the pictures' mean luminance, where "
    "it stands in for a light meter. Default: 3.",
    ("--drop-within within_s", "S", LIGHT): "In so many seconds. Default: 2.",
    ("--bright-for bright_for_s", "S", LIGHT): "So long it must have been bright before: an "
    "oncoming lamp is not. Default: 3.",
    ("--smooth smooth_s", "S", LIGHT): "Width of the median that takes out flicker. Default: 0.5.",
    ("--least-lux", "LUX", LIGHT): "What a light meter reads below that counts as that. Default: "
    "0.1.",
}
"""Help texts by names of the flag, placeholder of its value, and heading."""


def _gather(context: click.Context, option: click.Parameter, value: Any) -> None:
    """Put the value into the command's ``settings``."""
    if value is not None:
        context.params.setdefault("settings", {})[option.name] = value


def _run(session_file: Path, kind: Any, options: dict[str, Any]) -> Any:
    """Return what `driver_job` writes, and show its progress."""
    from nvcore.subjects.driver.calls.python import driver_job

    with job_on(session_file, kind, driver_job, options) as job, ShareProgress() as progress:
        return job(progress)


_setting_options = with_options(
    *(
        grouped_option(
            group,
            *names.split(),
            type=PairOf("X,Y") if metavar == "X,Y" else float,
            metavar=metavar,
            help=text,
            callback=_gather,
            expose_value=False,
        )
        for (names, metavar, group), text in _SETTINGS.items()
    )
)


@command(
    "How well each pedestrian can be seen in the pictures.",
    "nvcore driver features night.toml --out features",
    "nvcore driver features --images study --boxes study/boxes.csv --out features.csv",
)
@session_argument(required=False)
@grouped_option(
    INPUTS,
    "--images",
    type=click.Path(exists=True, file_okay=False, path_type=Path),
    metavar="FOLDER",
    help="Single pictures, such as those of a study, in place of a session.",
)
@grouped_option(
    INPUTS,
    "--boxes",
    type=FILE,
    help="Their pedestrians: image,pedestrian,x,y,w,h[,fixation_x,fixation_y] (CSV).",
)
@options_of(FeatureArguments)
@_setting_options
def features(
    session_file: Path | None, images: Path | None, boxes: Path | None, **options: Any
) -> None:
    """Compute eight features of each pedestrian in every frame, and the light.

    SESSION_FILE (TOML) names the ground truth and for each recording the pictures of visible light
    (visible, else pictures), a light meter (light) and where the driver looked (gaze). Exit code 0:
    fine, 2: bad input.
    """
    if (session_file is None) == (images is None):
        raise click.UsageError("give a session file, or --images with --boxes")
    if (images is None) != (boxes is None):
        raise click.UsageError("--images and --boxes belong together; give both")
    if images is not None and boxes is not None:
        refuse_without_session(options)
        from nvcore.subjects.driver.calls.python import image_features

        with ShareProgress() as progress:
            table = image_features(
                images,
                boxes,
                options["out"],
                settings=options.get("settings"),
                n_threads=options["n_threads"],
                progress=progress,
            )
        click.echo(str(table))
        say_written(options["out"])
        return
    assert session_file is not None
    written = _run(session_file, FeatureArguments, options)
    click.echo(str(written.run))
    click.echo(one_line(f"written to {written.features} and {written.record}"), err=True)


@command(
    "Estimate how likely the driver sees each pedestrian.",
    "nvcore driver estimate night.toml --model driver.npz --out seen",
    "nvcore compare seen/session.toml",
)
@session_argument()
@options_of(EstimateArguments)
@_setting_options
def estimate(session_file: Path, **options: Any) -> None:
    """Estimate how likely the driver sees each pedestrian unaided, in every frame.

    SESSION_FILE (TOML) names what nvcore driver features needs. DIR/session.toml is the same
    session with the estimates, which nvcore compare takes. Features are computed with the settings
    of those that the model was trained on; others are refused. Exit code 0: fine, 2: bad input.
    """
    written = _run(session_file, EstimateArguments, options)
    click.echo(str(written.run))
    say_written(options["out"])
    click.echo(one_line(f"compare: nvcore compare {written.session}"), err=True)


_ANGLE: Final = ("distance_mm", "shown_width_mm", "picture_width_px")
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
"""Flag, type, default, placeholder of the value and help text."""
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
@click.argument("trials", type=FILE)
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
        from nvcore.subjects.driver.calls.python import train_driver
        from nvcore.subjects.driver.evaluation.estimator_report import render_training

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
@click.argument("trials", type=FILE)
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
        from nvcore.subjects.driver.calls.python import evaluate_driver
        from nvcore.subjects.driver.evaluation.estimator_report import render_evaluation

    if html is not None:
        check_html_name("--html", html)
    options = _judged(options)
    with ShareProgress() as progress:
        evaluation = evaluate_driver(trials, out=out, html=html, progress=progress, **options)
    click.echo(render_evaluation(evaluation))
    say_how_to_leave_out(evaluation.table)
    say_written(out, "tables ")
    say_written(html, "figures ")


def _judged(options: dict[str, Any]) -> dict[str, Any]:
    """Replace the options on judging responses by one `Judging`, converting an angle to pixels."""
    from nvcore.subjects.driver.trials import Judging, side_of_angle

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


@click.group(short_help="Estimate what the driver would have seen unaided.")
def driver() -> None:
    """Estimate whether the driver would have seen each pedestrian unaided."""


for part in (features, train, evaluate, estimate):
    driver.add_command(part)
