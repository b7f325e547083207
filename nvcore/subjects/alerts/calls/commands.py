"""``nvcore alerts``: detections that reach the driver as alerts, and how useful these are."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from nvcore.cli.options import command, grouped_option, input_options, parameter_options
from nvcore.cli.session_options import session_from
from nvcore.cli.steps import (
    check_output_folder,
    compare_session,
    errors_of,
    say_written,
    shown_findings,
)
from nvcore.common.arguments import FOLDER, OUTPUT
from nvcore.inputs.session.toml import read_session

# As in nvcore/cli/__init__.py, numpy is imported by the command only.


@command(
    "Which detections reach the driver as alerts, which were worth it.",
    "nvcore alerts night.toml",
    "nvcore alerts night.toml --policy eager --out alerts",
    "nvcore alerts night.toml --policy ours.toml --alert-pause-s 5",
)
@input_options
@grouped_option(
    "Policy",
    "--policy",
    metavar="NAME|FILE",
    help="By which detections become alerts: cautious, balanced, eager, or a TOML file of settings "
    "(docs/alerts.md); flags go before it. Default: each system's own log where the session names "
    "one, else the settings.",
)
@grouped_option(
    OUTPUT,
    "--out",
    type=FOLDER,
    help="Write alerts.csv, alert_curve.csv and, with speed signs, speeding.csv into this folder.",
)
@parameter_options
def alerts(policy: str | None, out: Path | None, **options: Any) -> None:
    """Judge the alerts of X and Y: how many of each kind, and whom they are in time for.

    Inputs as for compare; what the audit of these found goes to stderr. Then comes what other score
    thresholds would give: unwanted alerts, and urgent encounters alerted in time. Exit code 0:
    fine, 2: bad input.
    """
    from nvcore.report.terminal import render_findings
    from nvcore.subjects.alerts.calls.python import FILES, write_alerts
    from nvcore.subjects.alerts.policy import policy_from
    from nvcore.subjects.alerts.section import render_alerts
    from nvcore.subjects.alerts.steps import alerts_in

    file = options["session_file"]
    if policy is not None:
        values = {"alerts": "policy", **policy_from(policy)}
        options |= {name: value for name, value in values.items() if options[name] is None}
    elif options["alerts"] is None:
        is_asked = file is not None and read_session(file).params.alerts != "off"
        options["alerts"] = None if is_asked else "log"
    session = session_from(options, needs_y=True)
    if out is not None:
        policy_file = None if policy is None else Path(policy)
        check_output_folder(out, FILES, session, file, policy_file)
    with errors_of(session):
        result, findings = compare_session(session)
        view = alerts_in(result)
    if not view.is_asked:
        raise click.UsageError("--alerts off: there is nothing to judge; leave it out")
    shown = shown_findings(session, result.dataset, findings)
    click.echo(render_findings(shown) + "\n", err=True)
    click.echo(render_alerts(view))
    if out is not None:
        write_alerts(out, view)
        say_written(out)
