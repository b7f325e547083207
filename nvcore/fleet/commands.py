"""Commands of the fleet: ``nvcore ingest``, ``scan``, ``top`` and ``open``."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import click

from nvcore.arguments import pairs_of
from nvcore.cli.options import (
    GroupedCommand,
    examples,
    grouped_option,
    input_flags,
    options_of,
    parameter_options,
)
from nvcore.cli.program import EXIT_BAD_INPUT
from nvcore.cli.progress import ShareProgress, step_lines
from nvcore.cli.session_options import session_from
from nvcore.cli.steps import EXIT_FINDINGS, errors_of
from nvcore.errors import InputError
from nvcore.fleet.arguments import RUN, ScanArguments
from nvcore.params import SETTINGS, params_from
from nvcore.wording import count_text, one_line

if TYPE_CHECKING:
    from nvcore.dataset import Dataset

# As in nvcore/cli/__init__.py, numpy and what stores need are imported by the commands only.

STORE: Final = "Store"


@click.command(
    cls=GroupedCommand,
    short_help="Append recordings to a store of many.",
    epilog=examples(
        "nvcore ingest night.toml --store fleet",
        "nvcore ingest drives --store s3://ours/fleet --partition route --label FIR=2026-03",
        "nvcore ingest --truth gt.csv --x fir.csv --size 640x480 --fps 20 --store fleet",
    ),
)
@click.argument("inputs", nargs=-1, type=click.Path(path_type=Path))
@grouped_option(
    STORE,
    "--store",
    required=True,
    metavar="URI",
    help="A folder, or s3://bucket/folder with what the environment says of the server "
    "(AWS_ENDPOINT_URL, ...); made if there is none.",
)
@grouped_option(
    STORE,
    "--partition",
    metavar="KEY",
    help="How a new store is divided: by month, unit, or the key of a tag, such as route where "
    "recordings have tags such as route=A9. Default: not.",
)
@grouped_option(
    STORE,
    "--label",
    "labels",
    multiple=True,
    callback=pairs_of,
    metavar="SYSTEM=NAME",
    help="What to call this version of a system, or of the truth; may be given again.",
)
@grouped_option(
    STORE,
    "--truth-kind",
    type=click.Choice(["annotated", "automatic", "absent"]),
    default="annotated",
    show_default=True,
    help="Whether people annotated the ground truth, a program did, or there is none.",
)
@input_flags
def ingest(
    inputs: tuple[Path, ...],
    store: str,
    partition: str | None,
    labels: dict[str, str],
    truth_kind: str,
    **options: Any,
) -> None:
    """Append recordings with truth and systems to a store.

    INPUTS are session files, or folders that are searched for them; in their place, flags name the
    files of one comparison. What the store has already is left out, and what has changed is a new
    version: nothing is overwritten. How they are compared is said later. Exit code 0: fine, 1: some
    inputs could not be used, the others are in the store, 2: bad input.
    """
    from nvcore.fleet.ingest import ingest_all, session_files
    from nvcore.fleet.location import Location
    from nvcore.fleet.store import Store
    from nvcore.inputs.load import load

    def loaded(file: Path | None) -> Dataset:
        try:
            session = session_from({**options, "session_file": file}, needs_y=False)
        except click.UsageError as error:
            if file is None:
                raise
            raise InputError(error.message) from error  # the next file may be one
        with errors_of(session):
            return load(session)

    def every() -> Iterator[tuple[str, Callable[[], Dataset]]]:
        for given in inputs:
            for path in session_files(given):
                yield str(path), partial(loaded, path)
        if not inputs:
            yield options["truth"][0] if options["truth"] else "", partial(loaded, None)

    done = ingest_all(
        every(),
        Store(Location(store), partition=partition),
        truth_kind=truth_kind,
        labels=labels,
        progress=step_lines(),
    )
    for name, findings in done.findings.items():
        codes = ", ".join(dict.fromkeys(finding.code for finding in findings))
        click.echo(one_line(f"note: {name}: {codes} (nvcore check says more)"), err=True)
    for kind, n in done.not_stored.items():
        times = count_text(n, "input", "inputs")
        click.echo(one_line(f"note: {kind} are not stored ({times} with them)"), err=True)
    for error in done.errors.values():
        click.echo(one_line(f"error: {error}"), err=True)
    recordings, sources = done.recordings, done.sources
    known = f"; {count_text(done.n_known, 'source was', 'sources were')} there already"
    click.echo(
        one_line(
            f"{count_text(len(recordings), 'recording', 'recordings')} "
            f"({count_text(int(recordings['n_rows'].sum()), 'frame', 'frames')}), "
            f"{count_text(len(sources), 'source', 'sources')} "
            f"({count_text(int(sources['n_rows'].sum()), 'box', 'boxes')}) appended to {store}"
            f"{known if done.n_known else ''}"
        )
    )
    if done.errors:
        is_empty = recordings.empty and sources.empty and not done.n_known
        raise SystemExit(EXIT_BAD_INPUT if is_empty else EXIT_FINDINGS)


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
    from nvcore.fleet.scan import end_on_request

    end_on_request()
    given = {name: value for name in SETTINGS if (value := options.pop(name)) is not None}
    with ShareProgress() as progress:
        done = run_scan(**options, params=params_from(given), progress=progress)
    click.echo(done)
    click.echo(one_line(f"written to {options['out']}"), err=True)
    if done.status.n_quarantined:
        raise SystemExit(EXIT_FINDINGS)


COMMANDS: Final[tuple[Any, ...]] = (ingest, scan)
