"""``nvcore changed``: what a new version of a system changed."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from nvcore.cli.options import command, grouped_option, input_options, parameter_options
from nvcore.cli.progress import TerminalProgress
from nvcore.cli.session_options import session_from
from nvcore.cli.steps import check_output_folder, errors_of, say_written, shown_findings
from nvcore.common.arguments import FOLDER, OUTPUT

# As in nvcore/cli/__init__.py, numpy is imported by the command only.


@command(
    "What a new version of a system changed.",
    "nvcore changed night.toml",
    "nvcore changed night.toml --old NIR --new 'NIR 2' --out changes",
)
@input_options
@grouped_option("Versions", "--old", metavar="NAME", help="Old version.")
@grouped_option("Versions", "--new", metavar="NAME", help="New version.")
@grouped_option(
    OUTPUT, "--out", type=FOLDER, help="Write changes.csv and significance.csv into this folder."
)
@parameter_options
def changed(old: str | None, new: str | None, out: Path | None, **options: Any) -> None:
    """List what two versions do differently: newly missed, newly false, fixed, gone.

    Inputs as for compare. The versions are the last two that the session file declares
    (version_of), or X (old) and Y (new) if it declares none. Then come the paired tests, and the
    measures of all versions with the rules of the session's gate. Exit code 0: fine, 2: bad input.
    """
    from nvcore.inputs.load import load
    from nvcore.report.terminal import render_findings
    from nvcore.subjects.releases.calls import FILES, what_changed

    session = session_from(options, needs_y=True)
    if out is not None:
        check_output_folder(out, FILES, session, options["session_file"])
    with errors_of(session), TerminalProgress(3 + len(session.systems)) as steps:
        changes = what_changed(load(session, progress=steps), old, new)
        if out is not None:
            changes.write(out)
        comparison, text = changes.comparison, str(changes)
    shown = shown_findings(session, comparison.dataset, comparison.findings)
    click.echo(render_findings(shown) + "\n", err=True)
    click.echo(text)
    say_written(out)
