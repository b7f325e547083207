"""Commands of the fleet: ``nvcore ingest``, ``scan``, ``top`` and ``open``."""

from __future__ import annotations

from typing import Any, Final

import click

from nvcore.cli.options import (
    GroupedCommand,
    examples,
    grouped_option,
    options_of,
    parameter_options,
)
from nvcore.cli.progress import ShareProgress
from nvcore.cli.steps import EXIT_FINDINGS
from nvcore.fleet.arguments import RUN, ScanArguments
from nvcore.params import SETTINGS, params_from
from nvcore.wording import one_line

# As in nvcore/cli/__init__.py, numpy is imported by the command only.


def _show_status(context: click.Context, _: click.Parameter, out: str | None) -> None:
    """Callback of the flag that asks how far a scan is, and for no scan."""
    if out is not None:
        from nvcore.fleet.face import scan_status

        click.echo(scan_status(out))
        context.exit()


@click.command(
    cls=GroupedCommand,
    short_help="Compare two systems on all recordings of a store.",
    epilog=examples(
        "nvcore scan fleet --out night --x FIR --y NIR",
        "nvcore scan fleet --out night --x FIR --y NIR@2 --alpha 0.8 --workers 8",
        "nvcore scan s3://drives/fleet --out s3://drives/night --x FIR --y NIR --shard 17/300",
        "nvcore scan --status night",
    ),
)
@click.argument("store", metavar="STORE")
@options_of(ScanArguments)
@grouped_option(
    RUN,
    "--status",
    metavar="URI",
    is_eager=True,
    expose_value=False,
    callback=_show_status,
    help="Say how far the scan is whose results are written there, and end.",
)
@parameter_options
def scan(**options: Any) -> None:
    """Compare X and Y on all recordings of STORE, a folder or URI that nvcore ingest wrote.

    Batches of recordings are compared by processes of this machine, by the tasks of an array job,
    or by a Dask cluster; whichever it is, the results are the same. A scan that was stopped goes
    on where it was. Exit code 0: fine, 1: some recordings could not be compared (table quarantine),
    2: bad input.
    """
    from nvcore.fleet.face import scan as run_scan

    given = {name: value for name in SETTINGS if (value := options.pop(name)) is not None}
    with ShareProgress() as progress:
        done = run_scan(**options, params=params_from(given), progress=progress)
    click.echo(done)
    click.echo(one_line(f"written to {options['out']}"), err=True)
    if done.status.n_quarantined:
        raise SystemExit(EXIT_FINDINGS)


COMMANDS: Final[tuple[Any, ...]] = (scan,)
