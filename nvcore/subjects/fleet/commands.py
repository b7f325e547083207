"""Fleet commands: ``nvcore ingest``, ``scan``, ``top`` and ``open``."""

from __future__ import annotations

import shlex
import socket
import tempfile
import time
import webbrowser
from contextlib import suppress
from functools import partial
from pathlib import Path
from threading import Thread
from typing import TYPE_CHECKING, Any, Final
from urllib.parse import urlencode

import click

from nvcore.cli.app import serve
from nvcore.cli.options import command, grouped_option, input_flags, options_of, parameter_options
from nvcore.cli.program import EXIT_BAD_INPUT, program
from nvcore.cli.progress import ShareProgress, step_lines
from nvcore.cli.session_options import session_from
from nvcore.cli.steps import EXIT_FINDINGS, errors_of, say_written
from nvcore.common.arguments import FILE, OUTPUT, pairs_of
from nvcore.common.errors import InputError
from nvcore.common.output.files import write_whole
from nvcore.common.wording import count_text, one_line
from nvcore.settings.params import SETTINGS, params_from
from nvcore.subjects.fleet.calls import RUN, OpenArguments, ScanArguments, TopArguments

if TYPE_CHECKING:
    from nvcore.dataset import Dataset

# As in nvcore/cli/__init__.py, only the commands import numpy and the packages that stores need.

STORE: Final = "Store"


@command(
    "Append recordings to a store of many.",
    "nvcore ingest night.toml --store fleet",
    "nvcore ingest drives --store s3://ours/fleet --label FIR=2026-03",
    "nvcore ingest --truth gt.csv --x fir.csv --size 640x480 --fps 20 --store fleet",
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
    help="Whether people annotated the ground truth, a program did, or there is none. Default: as "
    "the store has it, else annotated.",
)
@grouped_option(
    STORE, "--newest", is_flag=True, help="Make versions that the store has the newest again."
)
@input_flags
def ingest(
    inputs: tuple[Path, ...],
    store: str,
    labels: dict[str, str],
    truth_kind: str | None,
    newest: bool,
    **options: Any,
) -> None:
    """Append recordings with truth and systems to a store.

    INPUTS are session files, or folders that are searched for them; in their place, flags name the
    files of one comparison. What the store has already is left out, and what has changed is a new
    version: nothing is overwritten. How they are compared is said later. Exit code 0: fine, 1: some
    inputs could not be used, the others are in the store, 2: bad input.
    """
    from nvcore.inputs.load import load
    from nvcore.subjects.fleet.ingest import ingest_all, sessions_in
    from nvcore.subjects.fleet.location import Location
    from nvcore.subjects.fleet.store import Store

    def loaded(file: Path | None) -> Dataset:
        try:
            session = session_from({**options, "session_file": file}, needs_y=False)
        except click.UsageError as error:
            if file is None:
                raise
            raise InputError(error.message) from error  # the next file may be usable
        with errors_of(session):
            return load(session)

    every = sessions_in(inputs, loaded)
    if not inputs:
        every = iter([(options["truth"][0] if options["truth"] else "", partial(loaded, None))])
    done = ingest_all(
        every,
        Store(Location(store)),
        truth_kind=truth_kind or "",
        labels=labels,
        newest=newest,
        progress=step_lines(),
    )
    lines = [
        f"note: {name}: {', '.join(dict.fromkeys(of.code for of in findings))} "
        "(nvcore check says more)"
        for name, findings in done.findings.items()
    ]
    lines += [
        f"note: {key} is not stored ({count_text(n, 'input states it', 'inputs state it')})"
        for key, n in done.not_stored.items()
    ]
    lines += [
        f"note: {source or 'metadata'} of {count_text(n, 'recording')} is there as version "
        f"{version}; version {last} stays the newest (--newest changes that)"
        for source, version, last, n in done.older.itertuples(index=False)
    ]
    lines += [
        f"error: {error}" if name in str(error) else f"error: {name}: {error}"
        for name, error in done.errors.items()
    ]
    for line in lines:
        click.echo(one_line(line), err=True)
    noted = " (label or kind of truth noted)" if done.n_known and (labels or truth_kind) else ""
    click.echo(f"{done}{noted}")
    if done.errors:
        raise SystemExit(EXIT_FINDINGS if len(done.sources) or done.n_known else EXIT_BAD_INPUT)


def _show_status(context: click.Context, _: click.Parameter, out: str | None) -> None:
    """Print the progress of a scan instead of running one."""
    if out is not None:
        from nvcore.subjects.fleet.calls import scan_status

        status = scan_status(out)
        click.echo(status)
        context.exit(EXIT_FINDINGS if status.n_quarantined else 0)


@command(
    "Compare two systems on all recordings of a store.",
    "nvcore scan fleet --out night --x FIR --y NIR",
    "nvcore scan fleet --out night --x FIR --y NIR@2 --alpha 0.8 --workers 8",
    "nvcore scan s3://drives/fleet --out s3://drives/night --x FIR --y NIR --shard 17/300",
    "nvcore scan --status night",
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
    on where it was. Exit code 0: fine, 1: some recordings could not be compared (table quarantine;
    also with --status, and of tasks of an array job), 2: bad input.
    """
    from nvcore.subjects.fleet.calls import scan as run_scan
    from nvcore.subjects.fleet.scan import end_on_request

    end_on_request()
    given = {name: value for name in SETTINGS if (value := options.pop(name)) is not None}
    try:
        with ShareProgress() as progress:
            done = run_scan(**options, params=params_from(given), progress=progress)
    except KeyboardInterrupt:
        click.echo("the same command goes on where it was", err=True)
        raise
    click.echo(done)
    say_written(options["out"])
    if done.status.n_quarantined:
        raise SystemExit(EXIT_FINDINGS)


@command(
    "The worst moments of a scan, and how to open them.",
    "nvcore top night -n 5",
    "nvcore top night --by severity_y --where \"tag.road = 'rural' and n_frames > 10\"",
    "nvcore top night --table intervals --where tag.night --out worst.csv",
)
@click.argument("results", metavar="RESULTS")
@options_of(TopArguments)
@grouped_option(
    OUTPUT,
    "--out",
    type=FILE,
    metavar="CSV",
    help="Write the rows with all columns into this file.",
)
def top(out: Path | None, **options: Any) -> None:
    """Show the worst rows of RESULTS, a folder or URI that nvcore scan wrote.

    Of each row the command is shown that opens its recording in the dashboard, at the frame to
    look at. Exit code 0: fine, 2: bad input.
    """
    from nvcore.common.output.csv_text import to_csv_bytes
    from nvcore.subjects.fleet.calls import top as find_top

    found = find_top(**options)
    lines = str(found).splitlines()
    commands = [""]
    for name, frame in zip(found.table["recording"], found.frames, strict=True):
        place = [] if frame is None else ["--at", str(frame)]
        # a name that looks like a flag goes last
        words = (
            [*place, "--", found.results, name] if name.startswith("-") else [found.results, name]
        )
        words += [] if name.startswith("-") else place
        commands.append(f"  {program()} open {shlex.join(words)}")
    for line, opening in zip(lines, commands, strict=True):
        click.echo(one_line(line + opening))
    if out is not None:
        write_whole(out, to_csv_bytes(found.table))
        say_written(out)


@command(
    "Open a recording of a store in the dashboard.",
    "nvcore open night 'drive 7' --at 1234",
    "nvcore open fleet 'drive 7' --x FIR@1 --y FIR@2",
    "nvcore open night 'drive 7' --out seven",
    name="open",
)
@click.argument("source", metavar="RESULTS|STORE")
@click.argument("recording")
@options_of(OpenArguments)
@grouped_option(RUN, "--at", type=int, metavar="FRAME", help="The frame to show.")
@grouped_option(
    RUN, "--port", type=click.IntRange(1, 65535), help="Default: 8501, or the next free one."
)
@grouped_option(RUN, "--no-browser", is_flag=True, help="Start without opening a browser.")
def open_(at: int | None, port: int | None, no_browser: bool, **options: Any) -> None:
    """Open RECORDING by itself in the dashboard, on this computer; Ctrl+C ends it.

    RESULTS is what nvcore scan wrote: its systems, settings and versions are shown. Of a STORE
    the newest versions are, with the settings by default. Exit code 0: ended, 2: bad input.
    """
    from nvcore.subjects.fleet.calls import export_recording

    if options["out"] is not None:
        if at is not None or port is not None or no_browser:
            raise click.UsageError("--out starts nothing; leave out --at, --port, --no-browser")
        session = export_recording(**options)
        say_written(session)
        return
    with tempfile.TemporaryDirectory(prefix="nvcore-") as folder:
        session = export_recording(**options | {"out": folder})
        place = {"recording": options["recording"], **({} if at is None else {"frame": at})}
        port = port or _free_port()
        link = f"http://localhost:{port}/timeline?{urlencode(place)}"
        click.echo(one_line(f"opens at {link}"))
        if not no_browser:
            Thread(target=_open_when_served, args=(port, link), daemon=True).start()
        serve([f"--session={session}"], address="localhost", port=port, no_browser=True)


def _free_port() -> int:
    """Return the first free port, starting with Streamlit's default."""
    for port in range(8501, 8601):
        with suppress(OSError), socket.socket() as there:
            there.bind(("localhost", port))
            return port
    raise click.UsageError("the ports 8501 to 8600 are in use; give --port")


def _open_when_served(port: int, link: str) -> None:
    """Open a link in the browser as soon as a server is listening."""
    for _ in range(600):
        with suppress(OSError), socket.create_connection(("localhost", port), timeout=1):
            webbrowser.open(link)
            return
        time.sleep(0.1)
