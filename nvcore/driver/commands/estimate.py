"""``nvcore driver estimate``: estimate how likely the driver sees each pedestrian unaided."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from nvcore.cli.options import GroupedCommand, examples, options_of
from nvcore.driver.arguments import EstimateArguments
from nvcore.driver.commands.options import run_on_session, setting_options
from nvcore.wording import one_line


@click.command(
    cls=GroupedCommand,
    short_help="Estimate how likely the driver sees each pedestrian.",
    epilog=examples(
        "nvcore driver estimate night.toml --model driver.npz --out seen",
        "nvcore compare seen/session.toml",
    ),
)
@click.argument("session_file", type=click.Path(dir_okay=False, path_type=Path))
@options_of(EstimateArguments)
@setting_options
def estimate(session_file: Path, **options: Any) -> None:
    """Estimate how likely the driver sees each pedestrian unaided, in every frame.

    SESSION_FILE (TOML) names what nvcore driver features needs. DIR/session.toml is the same
    session with the estimates, which nvcore compare takes. Features are computed with the settings
    of those that the model was trained on; others are refused. Exit code 0: fine, 2: bad input.
    """
    from nvcore.driver.face import estimate_job

    written = run_on_session(session_file, EstimateArguments, estimate_job, options)
    click.echo(str(written.run))
    click.echo(one_line(f"written to {options['out']}"), err=True)
    click.echo(one_line(f"compare: nvcore compare {written.session}"), err=True)
