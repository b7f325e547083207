"""``nvcore driver features``: how well each pedestrian can be seen in the pictures."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from nvcore.arguments import INPUTS
from nvcore.cli.options import (
    GroupedCommand,
    examples,
    grouped_option,
    options_of,
    refuse_without_session,
)
from nvcore.cli.progress import ShareProgress
from nvcore.driver.arguments import FeatureArguments
from nvcore.driver.commands.options import run_on_session, setting_options
from nvcore.wording import one_line


@click.command(
    cls=GroupedCommand,
    short_help="How well each pedestrian can be seen in the pictures.",
    epilog=examples(
        "nvcore driver features night.toml --out features",
        "nvcore driver features --images study --boxes study/boxes.csv --out features.csv",
    ),
)
@click.argument(
    "session_file",
    required=False,
    type=click.Path(dir_okay=False, path_type=Path),
    metavar="[SESSION_FILE]",
)
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
@setting_options
def features(
    session_file: Path | None, images: Path | None, boxes: Path | None, **options: Any
) -> None:
    """How well each pedestrian can be seen: eight features of each in every frame, and the light.

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
    from nvcore.driver.face import features_job

    written = run_on_session(session_file, FeatureArguments, features_job, options)
    click.echo(str(written.run))
    click.echo(one_line(f"written to {written.features} and {written.record}"), err=True)
