"""Commands of the fleet: ``nvcore ingest``, ``scan``, ``top`` and ``open``."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import click

from nvcore.arguments import pairs_of
from nvcore.cli.options import GroupedCommand, examples, grouped_option, input_flags
from nvcore.cli.program import EXIT_BAD_INPUT
from nvcore.cli.progress import step_lines
from nvcore.cli.session_options import session_from
from nvcore.cli.steps import EXIT_FINDINGS, errors_of
from nvcore.errors import InputError
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


COMMANDS: Final[tuple[Any, ...]] = (ingest,)
