"""``nvcore driver estimate``: how likely the driver sees each pedestrian by himself."""

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
    run_on_session,
)
from nvcore.cli.options import (
    GroupedCommand,
    examples,
    grouped_option,
    with_options,
)
from nvcore.wording import one_line


@click.command(
    cls=GroupedCommand,
    short_help="How likely the driver sees each pedestrian by himself.",
    epilog=examples(
        "nvcore driver estimate night.toml --model driver.npz --out seen",
        "nvcore compare seen/session.toml",
    ),
)
@click.argument("session_file", type=click.Path(dir_okay=False, path_type=Path))
@grouped_option(
    INPUTS,
    "--model",
    required=True,
    type=click.Path(dir_okay=False, path_type=Path),
    metavar="FILE",
    help="An estimator that nvcore driver train wrote (.npz), or sample: that of the sample's "
    "simulated observer.",
)
@grouped_option(
    INPUTS,
    "--interpolate",
    is_flag=True,
    help="Between the estimators of the adaptation periods before and after. Default: that of the "
    "nearest.",
)
@grouped_option(
    OUTPUT,
    "--out",
    required=True,
    type=click.Path(file_okay=False, path_type=Path),
    metavar="DIR",
    help="Write detectability.csv, features.csv, driver.json, and session.toml into this folder.",
)
@with_options(*RUN_OPTIONS, *SETTING_OPTIONS, *LIGHT_OPTIONS)
def estimate(session_file: Path, model: Path, out: Path, **options: Any) -> None:
    """How likely the driver sees each pedestrian by himself, in every frame.

    SESSION_FILE (TOML) names what nvcore driver features needs. DIR/session.toml is the same
    session with the estimates, which nvcore compare takes. Features are computed with the settings
    of those that the model was trained on; others are refused. Exit code 0: fine, 2: bad input.
    """
    from nvcore.api.driver_run import estimate_job

    job_of = partial(estimate_job, model=model, out=out, interpolate=options["interpolate"])
    written = run_on_session(session_file, job_of, options)
    click.echo(str(written.run))
    click.echo(one_line(f"written to {out}"), err=True)
    click.echo(one_line(f"compare: nvcore compare {written.session}"), err=True)
