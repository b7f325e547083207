"""The command line: parse, load, audit, analyse, report."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable
from dataclasses import fields, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from nvcore.errors import NvcoreError
from nvcore.params import Params, params_from
from nvcore.session import Session, Source, SystemSource, is_frame_range, parse_size
from nvcore.session_file import read_session
from nvcore.version import __version__

if TYPE_CHECKING:
    from nvcore.dataset import Dataset
    from nvcore.findings import Finding

# The commands import what they need: `nvcore --help` need not wait for numpy, pandas and numba.

EXIT_FINDINGS = 1
EXIT_BAD_INPUT = 2


class _BadInput(click.ClickException):
    exit_code = EXIT_BAD_INPUT


class _Group(click.Group):
    """Shows errors that a user can mend without a traceback, with exit code 2."""

    def invoke(self, ctx: click.Context) -> Any:
        try:
            return super().invoke(ctx)
        except NvcoreError as error:
            raise _BadInput(str(error)) from error


class _Steps:
    """Progress on the terminal, shown once the work has taken a second."""

    PATIENCE_S = 1.0

    def __init__(self, n_steps: int):
        self.n_steps = n_steps
        self.done = 0
        self.started = time.monotonic()
        self.bar: Any = None

    def __call__(self, label: str) -> None:
        is_late = time.monotonic() - self.started > self.PATIENCE_S
        if self.bar is None and is_late and sys.stderr.isatty():
            self.bar = click.progressbar(length=self.n_steps, file=sys.stderr, width=24)
            self.bar.__enter__()
            self.bar.update(self.done)
        if self.bar is not None:
            self.bar.label = label.ljust(28)
            self.bar.update(1)
        self.done += 1

    def close(self) -> None:
        if self.bar is not None:
            self.bar.finish()
            self.bar.__exit__(None, None, None)


def _flag(name: str) -> str:
    return "--" + name.replace("_", "-")


def _parameter_options(command: Callable[..., Any]) -> Callable[..., Any]:
    """Flags for all live parameters, made from the fields of `Params`."""
    for spec in reversed(fields(Params)):
        meta = spec.metadata
        default = "" if spec.default is None else f" Default: {spec.default}."
        if meta["choices"] is not None:
            kind: Any = click.Choice(meta["choices"])
            unit = ""
        else:
            kind = float
            unit = f" [{meta['unit']}]" if meta["unit"] else ""
        option = click.option(
            _flag(spec.name), spec.name, type=kind, default=None, help=meta["help"] + default + unit
        )
        command = option(command)
    return command


def _input_options(command: Callable[..., Any]) -> Callable[..., Any]:
    """Flags that name the inputs and the facts which they lack."""
    options = [
        click.argument("session_file", required=False, type=click.Path(path_type=Path)),
        click.option("--truth", multiple=True, metavar="PATH",
                     help="Ground truth: file, folder or quoted glob."),
        click.option("--x", "x_paths", multiple=True, metavar="PATH",
                     help="Detections of system X: file, folder or quoted glob."),
        click.option("--y", "y_paths", multiple=True, metavar="PATH",
                     help="Detections of system Y."),
        click.option("--name-x", help="Name of X. Default: told from the path, or the first "
                     "system of the session."),
        click.option("--name-y", help="Name of Y."),
        click.option("--format", "format_", metavar="FORMAT",
                     help="Format of all files. Default: told from their content."),
        click.option("--format-truth", metavar="FORMAT", help="Format of the ground truth."),
        click.option("--format-x", metavar="FORMAT", help="Format of X."),
        click.option("--format-y", metavar="FORMAT", help="Format of Y."),
        click.option("--classes", metavar="NAMES",
                     help="Class names or numbers that count as pedestrians, with commas. "
                     "Default: the format's usual ones."),
        click.option("--size", metavar="WxH", help="Image size in pixels, such as 640x480."),
        click.option("--fps", type=float, help="Frames per second."),
        click.option("--frames", metavar="FILE|F:L[:S]",
                     help="Evaluated frames: first:last[:step], or a file with a number a line."),
        click.option("--frame-base", type=click.Choice(["0", "1"]),
                     help="Number of the first frame, for formats that leave it open (csv)."),
        click.option("--box-base", type=click.Choice(["0", "1"]),
                     help="Coordinate of the first pixel, for Pascal VOC. Default: 1."),
        click.option("--offset-frames-x", type=int, default=0, help="Added to X's frame numbers."),
        click.option("--offset-frames-y", type=int, default=0, help="Added to Y's frame numbers."),
    ]  # fmt: skip
    for option in reversed(options):
        command = option(command)
    return command


@click.group(cls=_Group, context_settings={"help_option_names": ["-h", "--help"]})
@click.version_option(__version__, prog_name="nvcore")
def main() -> None:
    """Compare two pedestrian-detection systems by what the driver notices."""


@main.command()
@_input_options
@click.option(
    "--out",
    type=click.Path(file_okay=False, path_type=Path),
    metavar="DIR",
    help="Write the CSV tables, summary.json and session.toml into this folder.",
)
@click.option("--json", "as_json", is_flag=True, help="Print summary.json, not the scorecard.")
@click.option("--strict", is_flag=True, help="Warnings of the audit give exit code 1, too.")
@_parameter_options
def compare(
    out: Path | None, as_json: bool, strict: bool, **options: Any
) -> None:  # fmt: skip
    """Compare systems X and Y against the ground truth.

    Inputs come from SESSION_FILE (TOML) or from --truth, --x and --y. The audit of the inputs is
    printed first. Exit code 0: fine, 1: the audit found errors, 2: bad input.
    """
    from nvcore.analysis import analyse
    from nvcore.audit import audit
    from nvcore.export import summary_json, write_report
    from nvcore.loading import effective_params, load
    from nvcore.scorecard import render_findings, render_inputs, render_scorecard

    session = _session(options)
    steps = _Steps(6 + len(session.systems) + (8 if out is not None else 0))
    dataset = load(session, progress=steps)
    params = effective_params(session, dataset)
    x, y = _compared(session, dataset)
    steps("auditing the inputs")
    findings = audit(dataset, params, x=x, y=y)
    steps("analysing")
    result = analyse(dataset, params, x=x, y=y)
    steps("what fusion would do")
    text = summary_json(result) if as_json else render_scorecard(result)
    if out is not None:
        write_report(result, session, out, findings, progress=steps)
    steps.close()
    click.echo(render_inputs(result), err=as_json)
    click.echo("\n" + render_findings(findings) + "\n", err=as_json)
    click.echo(text, nl=not as_json)
    if out is not None:
        click.echo(f"\nwritten to {out}", err=as_json)
    _exit(findings, strict)


@main.command()
@_input_options
@click.option("--strict", is_flag=True, help="Warnings give exit code 1, too.")
@click.option("--threshold-x", type=float, help="Audit X at this threshold.")
@click.option("--threshold-y", type=float, help="Audit Y at this threshold.")
def check(
    strict: bool, threshold_x: float | None, threshold_y: float | None, **options: Any
) -> None:
    """Audit the inputs without scoring them.

    Exit code 0: no errors, 1: errors (with --strict: or warnings), 2: bad input.
    """
    from nvcore.audit import audit
    from nvcore.loading import effective_params, load
    from nvcore.scorecard import render_dataset, render_findings

    session = _session({**options, "threshold_x": threshold_x, "threshold_y": threshold_y})
    steps = _Steps(4 + len(session.systems))
    dataset = load(session, progress=steps)
    params = effective_params(session, dataset)
    steps("auditing the inputs")
    x, y = _compared(session, dataset)
    findings = audit(dataset, params, x=x, y=y)
    steps.close()
    click.echo(render_dataset(dataset))
    click.echo("\n" + render_findings(findings))
    _exit(findings, strict)


@main.command()
@click.argument("source", metavar="INPUT")
@click.argument("target", metavar="OUTPUT", type=click.Path(path_type=Path))
@click.option(
    "--to", "to", required=True, type=click.Choice(["csv", "coco", "mot"]), help="Format to write."
)
@click.option(
    "--role",
    type=click.Choice(["truth", "detections"]),
    default="truth",
    show_default=True,
    help="What the input holds.",
)
@click.option("--format", "format_", metavar="FORMAT", help="Format of the input.")
@click.option(
    "--truth", metavar="PATH", help="Ground truth, for results that name pictures by number."
)
@click.option("--classes", metavar="NAMES", help="Classes that count as pedestrians.")
@click.option("--size", metavar="WxH", help="Image size, for formats that need it.")
@click.option("--frame-base", type=click.Choice(["0", "1"]), help="Number of the first frame.")
@click.option("--box-base", type=click.Choice(["0", "1"]), help="First pixel, Pascal VOC.")
def convert(source: str, target: Path, to: str, role: str, **options: Any) -> None:
    """Convert any readable format to plain CSV, COCO or MOTChallenge.

    INPUT is a file, folder or quoted glob. MOTChallenge has one file a recording: OUTPUT is a
    folder where there are several.
    """
    from nvcore.loading import read_source
    from nvcore.writers import write

    common = _source_options(options)
    truth = None
    if options["truth"]:
        truth = read_source(Source((options["truth"],)), role="truth", size=_size(options))
    one = Source((source,), format=options["format_"], **common)
    reading = read_source(one, role=role, size=_size(options), truth=truth)  # type: ignore[arg-type]
    write(reading, to, target, role=role)  # type: ignore[arg-type]
    click.echo(f"{source}: {reading.conversion}", err=True)
    for finding in reading.findings:
        click.echo(f"{finding.severity.value}: {finding.message} ({finding.example})", err=True)
    click.echo(f"written to {target}: {len(reading.boxes)} boxes", err=True)


@main.command()
@click.argument("folder", default="sample_data", type=click.Path(file_okay=False, path_type=Path))
def sample(folder: Path) -> None:
    """Generate the sample recordings again, into FOLDER (default: sample_data)."""
    from nvcore.sample import generate

    generate(folder, progress=lambda text: click.echo(text, err=True))
    click.echo(f"written to {folder}", err=True)


def _size(options: dict[str, Any]) -> tuple[int, int] | None:
    if options["size"] is None:
        return None
    try:
        return parse_size(options["size"])
    except ValueError as error:
        raise click.BadParameter(str(error), param_hint="--size") from error


def _source_options(options: dict[str, Any]) -> dict[str, Any]:
    classes = options["classes"]
    bases = {
        key: None if options[key] is None else int(options[key])
        for key in ("frame_base", "box_base")
    }
    names = None if classes is None else tuple(name.strip() for name in classes.split(","))
    return {"classes": names, **bases}


def _session(options: dict[str, Any]) -> Session:
    """The session file, or one made from the flags; flags go before the file."""
    given = {
        spec.name: options[spec.name]
        for spec in fields(Params)
        if options.get(spec.name) is not None
    }
    if options["session_file"] is not None:
        if options["truth"] or options["x_paths"] or options["y_paths"]:
            raise click.UsageError("give a session file or --truth, --x and --y, not both")
        session = read_session(options["session_file"])
        facts: dict[str, Any] = {
            "size": _size(options) or session.size,
            "fps": options["fps"] or session.fps,
            "x": options["name_x"] or session.x,
            "y": options["name_y"] or session.y,
        }
        if options["frames"] is not None:
            facts |= {"frames": _frames(options["frames"]), "recordings": _unlisted(session)}
        params = params_from({**session.params.given(), **given})
        return replace(session, params=params, **facts)
    if not options["truth"] or not options["x_paths"]:
        raise click.UsageError("give a session file, or --truth, --x and --y")
    common = _source_options(options)
    whole = options["format_"]
    truth = Source(options["truth"], format=options["format_truth"] or whole, **common)
    systems = [
        SystemSource(
            options[f"{letter}_paths"],
            format=options[f"format_{letter}"] or whole,
            name=options[f"name_{letter}"],
            offset_frames=options[f"offset_frames_{letter}"],
            **common,
        )
        for letter in "xy"
        if options[f"{letter}_paths"]
    ]
    return Session(
        folder=Path.cwd(),
        truth=truth,
        systems=tuple(systems),
        size=_size(options),
        fps=options["fps"],
        frames=None if options["frames"] is None else _frames(options["frames"]),
        params=params_from(given),
    )


def _frames(text: str) -> str:
    """A frame list file named by flag is relative to where the command runs."""
    return text if is_frame_range(text) else str(Path(text).resolve())


def _unlisted(session: Session) -> tuple[Any, ...]:
    """The session's recordings without their own frame lists, which --frames replaces."""
    return tuple(replace(one, frames=None) for one in session.recordings)


def _compared(session: Session, dataset: Dataset) -> tuple[str, str | None]:
    """Names of X and Y."""
    others = [name for name in dataset.systems if name != session.x]
    x = session.x or dataset.systems[0]
    y = session.y or next((name for name in others if name != x), None)
    return x, y


def _exit(findings: tuple[Finding, ...], strict: bool) -> None:
    bad = {"error", "warning"} if strict else {"error"}
    if any(finding.severity.value in bad for finding in findings):
        raise SystemExit(EXIT_FINDINGS)
