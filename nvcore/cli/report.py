"""``nvcore report``: the comparison as one HTML file."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from nvcore.cli.options import (
    arguments_of,
    check_html_name,
    command,
    grouped_option,
    input_options,
    options_of,
    parameter_options,
    protocol_option,
    strict_option,
)
from nvcore.cli.progress import step_lines
from nvcore.cli.session_options import session_from
from nvcore.cli.steps import (
    as_loaded,
    compare_session,
    errors_of,
    exit_on_findings,
    say_written,
    shown_findings,
)
from nvcore.common.arguments import FILE, OUTPUT
from nvcore.common.arguments.report import HtmlArguments, Inscription
from nvcore.common.extras import needs


@command("Write the comparison as one HTML file.", "nvcore report night.toml --out night.html")
@input_options
@protocol_option
@options_of(HtmlArguments, "stability", "looks")
@options_of(Inscription)
@grouped_option(
    OUTPUT,
    "--out",
    type=FILE,
    metavar="FILE.html",
    default=Path("report.html"),
    show_default=True,
    help="The file to write.",
)
@strict_option
@parameter_options
def report(out: Path, strict: bool, **options: Any) -> None:
    """Write the comparison of X and Y as one HTML file.

    Inputs as for compare. Its first page has title, question, verdict, four measures, two frames
    and what the data do not show; then come figures, evidence frames, tables, parameters and
    hashes of the inputs; it needs neither network nor this program, and browsers print it to PDF.
    Exit code 0: fine, 1: the audit found errors (with --strict: or warnings), 2: bad input.
    """
    from nvcore.auditing import opened_pictures
    from nvcore.common.findings import worst_first
    from nvcore.evidence.looks import add_look
    from nvcore.report.protect_inputs import files_read, refuse_to_replace
    from nvcore.report.terminal import render_findings

    with needs("report", "the HTML report needs"):
        from nvcore.report.html import write_html_report

    check_html_name("--out", out)
    session = session_from(options, needs_y=True)
    refuse_to_replace([out], files_read(session))
    progress = step_lines()
    with errors_of(session):
        result, findings = compare_session(session, "equal-alarms", progress=progress)
        with opened_pictures(result.dataset) as (pictures, of_pictures):
            findings = worst_first([*findings, *of_pictures])
            write_html_report(
                *(result, as_loaded(session, result.dataset), findings, out),
                pictures=pictures,
                stability=options["stability"],
                inscription=arguments_of(Inscription, options),
                look=add_look(options["looks"], result, session.protocol),
                progress=progress,
            )
    click.echo(render_findings(shown_findings(session, result.dataset, findings)))
    say_written(out)
    exit_on_findings(findings, strict)
