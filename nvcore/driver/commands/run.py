"""``nvcore driver features`` and ``estimate``: how well each pedestrian can be seen, and is."""

from __future__ import annotations

from pathlib import Path
from typing import Any, Final

import click

from nvcore.arguments import INPUTS
from nvcore.cli.options import (
    PairOf,
    command,
    grouped_option,
    options_of,
    refuse_without_session,
    session_argument,
    with_options,
)
from nvcore.cli.progress import ShareProgress
from nvcore.cli.steps import job_on
from nvcore.driver.arguments import VIEW, EstimateArguments, FeatureArguments
from nvcore.wording import one_line

# Nothing here imports numpy, pandas or OpenCV: `nvcore --help` need not wait for them.

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
    from nvcore.driver.face import driver_job

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
    type=click.Path(dir_okay=False, path_type=Path),
    metavar="FILE",
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
        from nvcore.driver.face import image_features

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
        click.echo(one_line(f"written to {options['out']}"), err=True)
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
    click.echo(one_line(f"written to {options['out']}"), err=True)
    click.echo(one_line(f"compare: nvcore compare {written.session}"), err=True)
