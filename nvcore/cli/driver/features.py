"""``nvcore driver features``: how well each pedestrian can be seen in the pictures."""

from __future__ import annotations

from functools import partial
from pathlib import Path
from typing import Any

import click

from nvcore.arguments import INPUTS, OUTPUT
from nvcore.cli.driver.options import (
    LIGHT_OPTIONS,
    RUN_OPTIONS,
    SETTING_OPTIONS,
    given_settings,
    run_on_session,
)
from nvcore.cli.options import (
    GroupedCommand,
    examples,
    grouped_option,
    refuse_without_session,
    with_options,
)
from nvcore.cli.progress import ShareProgress
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
@grouped_option(
    OUTPUT,
    "--out",
    required=True,
    type=click.Path(path_type=Path),
    metavar="DIR|FILE",
    help="Write features.csv and driver.json into this folder; of --images the features into this "
    "file, and how they were made beside it.",
)
@with_options(*RUN_OPTIONS, *SETTING_OPTIONS, *LIGHT_OPTIONS)
def features(session_file: Path | None, images: Path | None, out: Path, **options: Any) -> None:
    """How well each pedestrian can be seen: eight features of each in every frame, and the light.

    SESSION_FILE (TOML) names the ground truth and for each recording the pictures of visible light
    (visible, else pictures), a light meter (light) and where the driver looked (gaze). Exit code 0:
    fine, 2: bad input.
    """
    if (session_file is None) == (images is None):
        raise click.UsageError("give a session file, or --images with --boxes")
    if (images is None) != (options["boxes"] is None):
        raise click.UsageError("--images and --boxes belong together; give both")
    if images is not None:
        _of_images(images, out, options)
        return
    assert session_file is not None
    from nvcore.api.driver_run import features_job

    written = run_on_session(session_file, partial(features_job, out=out), options)
    click.echo(str(written.run))
    click.echo(one_line(f"written to {written.features} and {written.record}"), err=True)


def _of_images(images: Path, out: Path, options: dict[str, Any]) -> None:
    refuse_without_session(options)
    from nvcore.api.driver_run import image_features

    with ShareProgress() as progress:
        table = image_features(
            images,
            options["boxes"],
            out,
            settings=given_settings(options),
            n_threads=options["n_threads"],
            progress=progress,
        )
    click.echo(str(table))
    click.echo(one_line(f"written to {out}"), err=True)
