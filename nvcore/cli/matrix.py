"""``nvcore matrix``: pairwise comparison of all systems of a session."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from nvcore.cli.options import (
    command,
    grouped_option,
    input_options,
    parameter_options,
    strict_option,
)
from nvcore.cli.progress import TerminalProgress
from nvcore.cli.session_options import session_from
from nvcore.cli.steps import (
    check_output_folder,
    errors_of,
    exit_on_findings,
    say_written,
    shown_findings,
)
from nvcore.common.arguments import FOLDER, OUTPUT

# As in nvcore/cli/__init__.py, numpy and pandas are imported by the command only.


@command(
    "Compare every two systems of a session.",
    "nvcore matrix three.toml",
    "nvcore matrix three.toml --alpha 0.8 --out pairs",
    "nvcore matrix three.toml --json",
)
@input_options
@grouped_option(
    OUTPUT, "--out", type=FOLDER, help="Write matrix.csv and matrix.json into this folder."
)
@grouped_option(
    OUTPUT, "--json", "as_json", is_flag=True, help="Print matrix.json, not the tables."
)
@strict_option
@parameter_options
def matrix(out: Path | None, as_json: bool, strict: bool, **options: Any) -> None:
    """Say of every two systems who detects more, and who has the higher similarity.

    Inputs as for compare; a session file may name any number of systems. Each is compared at its
    own threshold; --threshold-x and --threshold-y are for X and Y. p is corrected for all pairs.
    Pairs at unequal operating points are tested at equal false alarms. Exit code 0: fine, 1: the
    audit found errors (with --strict: or warnings), 2: bad input.
    """
    from nvcore.auditing import audit
    from nvcore.evidence.pairwise import pairwise_table, thresholds_in_use
    from nvcore.inputs.load import load
    from nvcore.report.matrix import MATRIX_FILES, matrix_json, render_matrix, write_matrix
    from nvcore.report.terminal import render_findings

    session = session_from(options, needs_y=True)
    if out is not None:
        check_output_folder(out, MATRIX_FILES, session)
    n_systems = len(session.systems)
    n_steps = 4 + n_systems + n_systems * (n_systems - 1) // 2
    with errors_of(session), TerminalProgress(n_steps) as steps:
        dataset = load(session, progress=steps)
        steps.begin("auditing the inputs")
        findings = audit(dataset)
        params = dataset.params_of()
        thresholds = thresholds_in_use(dataset, params)
        table = pairwise_table(dataset, params, thresholds=thresholds, progress=steps)
        if out is not None:
            write_matrix(out, dataset, params, table)
    shown = shown_findings(session, dataset, findings)
    click.echo(render_findings(shown) + "\n", err=as_json)
    text = matrix_json(dataset, params, table) if as_json else render_matrix(table)
    click.echo(text, nl=not as_json)
    say_written(out)
    exit_on_findings(findings, strict)
