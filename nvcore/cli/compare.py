"""``nvcore compare`` and ``nvcore check``: load, audit, analyse, report."""

from __future__ import annotations

import shlex
from collections.abc import Iterable
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click
from click.core import ParameterSource

from nvcore.cli.options import (
    GroupedCommand,
    audit_options,
    examples,
    grouped_option,
    input_options,
    parameter_options,
    protocol_option,
    strict_option,
)
from nvcore.cli.program import program
from nvcore.cli.progress import TerminalProgress
from nvcore.cli.session_options import session_from
from nvcore.cli.steps import (
    as_loaded,
    check_output_folder,
    errors_of,
    exit_on_findings,
    say_written,
    shown_findings,
    shown_paths,
)
from nvcore.common.arguments import FOLDER, OUTPUT
from nvcore.common.wording import one_line
from nvcore.inputs.session import Session

if TYPE_CHECKING:
    from nvcore.dataset import Dataset
    from nvcore.report.files import TableFormat

AT_EQUAL_ALARMS = (
    "all numbers at equal false alarms, as on the pages of the app: --operating-point equal-alarms"
)
KEEPING = {"session_file", "out", "tables", "matches", "full", "plan", "as_json", "strict"}
"""Options that do not affect any number."""
LONGEST_NAME = 70
"""Maximum length of a session file's path in a suggested command, in characters."""
MAX_CONVERSION = 160
"""Maximum length of a conversion's text in `compare --full`: about two lines with the path."""


@click.command(
    cls=GroupedCommand,
    epilog=examples(
        "nvcore compare night.toml",
        "nvcore compare --truth gt.csv --x fir.csv --y nir.csv --size 640x480 --fps 20 --out night",
        "nvcore compare --truth drives --x 'drives/*/fir/det.txt' --y 'drives/*/nir/det.txt'",
        "nvcore compare night.toml --alpha 0.8 --proximity distance --json",
    ),
)
@input_options
@grouped_option(
    OUTPUT,
    "--out",
    type=FOLDER,
    help="Write the tables, summary.json and session.toml into this folder.",
)
@grouped_option(
    OUTPUT,
    "--tables",
    type=click.Choice(["csv", "parquet"]),
    help="Format of the tables in that folder. Default: csv.",
)
@grouped_option(
    OUTPUT,
    "--matches",
    is_flag=True,
    help="Write matches.parquet there, too: every box, and whom it matches (docs/report.md).",
)
@grouped_option(
    OUTPUT,
    "--full",
    is_flag=True,
    help="Print what was read, every finding, every measure, the sections of the report on them, "
    "and the verdict with its reasons.",
)
@grouped_option(
    OUTPUT,
    "--plan",
    is_flag=True,
    help="Plan how many recordings would show a difference, as nvcore plan does. Takes seconds.",
)
@grouped_option(
    OUTPUT,
    "--looks",
    type=click.Path(path_type=Path, dir_okay=False),
    metavar="FILE",
    help="Record this verdict in FILE, and correct for all that were looked at before "
    "(docs/claims.md).",
)
@grouped_option(
    OUTPUT, "--json", "as_json", is_flag=True, help="Print summary.json, not the scorecard."
)
@strict_option
@protocol_option
@parameter_options
def compare(
    out: Path | None,
    tables: TableFormat | None,
    matches: bool,
    full: bool,
    plan: bool,
    looks: Path | None,
    as_json: bool,
    strict: bool,
    **options: Any,
) -> None:
    """Compare systems X and Y against the ground truth.

    Inputs come from SESSION_FILE (TOML) or from --truth, --x and --y. One screen is printed: the
    worst findings of the audit, leading measures, verdict, moments to look at; with --full all of
    it. Exit code 0: fine, 1: the audit found errors (with --strict: or warnings), 2: bad input.
    """
    from nvcore.auditing import audit, picture_findings
    from nvcore.common.findings import worst_first
    from nvcore.comparison.compare import compare
    from nvcore.evidence.looks import add_look
    from nvcore.evidence.operating_points import are_unequal, at_operating_point
    from nvcore.inputs.load import load
    from nvcore.report.brief import MOST_LINES, render_brief
    from nvcore.report.files import REPORT_FILES, summary_json, write_report
    from nvcore.report.plan import planned_verdict
    from nvcore.report.terminal import render_findings, render_inputs, render_scorecard

    if out is None and (tables is not None or matches):
        flag = "--matches" if tables is None else "--tables"
        raise click.UsageError(f"{flag} is about the files that --out writes; give --out DIR, too")
    session = session_from(options, needs_y=True)
    _protect_inputs(session, options["session_file"], out, REPORT_FILES)
    n_steps = 7 + len(session.systems) + (11 if out is not None else 0)
    with errors_of(session), TerminalProgress(n_steps) as steps:
        dataset = load(session, progress=steps)
        session = as_loaded(session, dataset)
        steps.begin("auditing the inputs")
        findings = audit(dataset)
        steps.begin("looking at the pictures")
        findings = worst_first([*findings, *picture_findings(dataset)])
        steps.begin("analysing")
        result = at_operating_point(compare(dataset), session.operating_point or "as-set")
        steps.begin("what fusion would do")
        shown = shown_findings(session, dataset, findings)
        look = add_look(looks, result, session.protocol)
        if as_json:
            text = summary_json(result)
        else:
            name = _session_name(options["session_file"], out)
            plan_command = "" if plan else f"{program()} plan {name or 'SESSION_FILE'}"
            conclusion = planned_verdict(
                result, findings, session.protocol, plan_command=plan_command, look=look
            )
            next_steps = _next_steps(name, is_full=full)
            if full:
                text = "\n".join([render_scorecard(result, conclusion), "", *next_steps])
            else:
                n_more = 2 * are_unequal(result) + (out is not None)  # lines on the error stream
                room = MOST_LINES - n_more
                text = render_brief(
                    result, shown, conclusion, next_steps=next_steps, most_lines=room
                )
        if out is not None:
            kinds: dict[str, Any] = {"tables": tables or "csv", "matches": matches, "look": look}
            write_report(result, session, out, findings, progress=steps, **kinds)
    if full or as_json:
        short = _for_terminal(session, dataset, longest=MAX_CONVERSION)
        click.echo(render_inputs(replace(result, dataset=short)), err=as_json)
        click.echo("\n" + render_findings(shown) + "\n", err=as_json)
    click.echo(text, nl=not as_json)
    if look.factor > 1:
        click.echo(
            f"\nsetting {look.number} tried: each p is multiplied by {look.factor}", err=True
        )
    if are_unequal(result):
        click.echo(f"\n{AT_EQUAL_ALARMS}", err=True)
    say_written(out)
    exit_on_findings(findings, strict)


def _session_name(session_file: Path | None, out: Path | None) -> str:
    """Name the session file with these inputs and settings as an argument, if there is one."""
    from nvcore.report.files import SESSION_FILE

    context = click.get_current_context()
    given = {
        name
        for name in context.params
        if context.get_parameter_source(name) is ParameterSource.COMMANDLINE
    }
    file = out / SESSION_FILE if out else None if given - KEEPING else session_file
    name = "" if file is None else shlex.quote(one_line(str(file)))
    return name if len(name) <= LONGEST_NAME else "SESSION_FILE"


def _next_steps(name: str, *, is_full: bool) -> list[str]:
    """Return suggestions of commands that show more of a session file, each with its purpose."""
    from nvcore.report.terminal import WIDTH

    steps = [
        (f"{program()} compare {name} --full", "all findings, measures and reasons"),
        (f"{program()} app {name}", "these moments with boxes, in the dashboard"),
        (f"{program()} report {name}", "all of it as one HTML file"),
    ]
    if not name:
        steps = [("add --full", steps[0][1]), ("add --out DIR", "tables, and a session file")]
    steps = steps[is_full:]
    lines = [f"  {step}  # {shown}" for step, shown in steps]
    lines = [line if len(line) <= WIDTH else line.partition("  #")[0] for line in lines]
    return ["Next:", *lines]


def _protect_inputs(
    session: Session, file: Path | None, out: Path | None, names: Iterable[str]
) -> None:
    """Raise an error if an output would replace an input or be written into a folder of inputs.

    A session.toml that the program wrote may be replaced.
    """
    if out is None:
        return
    from nvcore.report.files import SESSION_FILE

    names = [*names]
    is_written_by_hand = not session.hashes
    if (
        file is not None
        and is_written_by_hand
        and SESSION_FILE in names
        and file.resolve() == (out / SESSION_FILE).resolve()
    ):
        raise click.UsageError("the report would replace the session file; give another --out")
    check_output_folder(out, names, session)


@click.command(
    cls=GroupedCommand,
    epilog=examples(
        "nvcore check night.toml --out audit",
        "nvcore check --truth drives/A/gt/gt.txt --x fir.txt --size 640x480 --fps 20 --strict",
    ),
)
@input_options
@grouped_option(
    OUTPUT,
    "--out",
    type=FOLDER,
    help="Write findings.csv and finding_entries.csv, the whole audit, into this folder, and "
    "estimated horizons as horizons.csv, which --recordings reads.",
)
@grouped_option(OUTPUT, "--strict", is_flag=True, help="Warnings give exit code 1, too.")
@audit_options
def check(out: Path | None, strict: bool, **options: Any) -> None:
    """Audit the inputs without scoring them.

    Exit code 0: no errors, 1: errors (with --strict: or warnings), 2: bad input.
    """
    from nvcore.auditing import audit, opened_pictures
    from nvcore.common.findings import worst_first
    from nvcore.inputs.load import load
    from nvcore.report.files import AUDIT_FILES, write_audit
    from nvcore.report.terminal import (
        render_dataset,
        render_findings,
        render_horizons,
        render_pictures,
    )
    from nvcore.tables.pictures import pictures_table

    session = session_from(options, needs_y=False)
    _protect_inputs(session, options["session_file"], out, AUDIT_FILES)
    with errors_of(session), TerminalProgress(5 + len(session.systems)) as steps:
        dataset = load(session, progress=steps)
        steps.begin("auditing the inputs")
        findings = audit(dataset)
        steps.begin("looking at the pictures")
        with opened_pictures(dataset) as (opened, of_pictures):
            findings = worst_first([*findings, *of_pictures])
            pictures = "" if opened is None else render_pictures(pictures_table(dataset, opened))
        if out is not None:
            write_audit(out, dataset, findings)
    click.echo(render_dataset(_for_terminal(session, dataset)))
    for text in (pictures, render_horizons(dataset)):
        if text:
            click.echo(text)
    click.echo("\n" + render_findings(shown_findings(session, dataset, findings)))
    say_written(out)
    exit_on_findings(findings, strict)


def _for_terminal(session: Session, dataset: Dataset, *, longest: int | None = None) -> Dataset:
    """Replace file paths and conversions in a dataset's inputs by their texts for the terminal."""
    path = shown_paths(session.folder, session.sources, dataset.systems)
    inputs = dataset.inputs
    changed = inputs.assign(
        file=[path(*names) for names in zip(inputs["subject"], inputs["file"], strict=True)],
        conversion=[_shortened(text, longest) for text in inputs["conversion"]],
    )
    return replace(dataset, inputs=changed)


def _shortened(text: str, longest: int | None) -> str:
    """Cut the description of a conversion after the last fact that fits."""
    if longest is None or len(text) <= longest:
        return text
    end = text.rfind("; ", 0, longest)
    return (text[:end] if end > 0 else text[:longest]) + "; ... (in full: nvcore check)"
