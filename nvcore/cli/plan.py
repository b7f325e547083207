"""``nvcore plan``: number of recordings needed to show a difference or non-inferiority."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from nvcore.cli.options import (
    arguments_of,
    command,
    flag_of,
    grouped_option,
    input_options,
    options_of,
    parameter_options,
    protocol_option,
    strict_option,
)
from nvcore.cli.session_options import session_from
from nvcore.cli.steps import (
    compare_session,
    errors_of,
    exit_on_findings,
    say_written,
    shown_findings,
)
from nvcore.common.arguments import FILE, OUTPUT
from nvcore.common.arguments.plan import PlanArguments
from nvcore.common.output.files import write_whole
from nvcore.common.wording import one_line

# As in nvcore/cli/__init__.py, numpy and pandas are imported by the command only.


@command(
    "Say how many recordings would show a difference.",
    "nvcore plan night.toml --measure encounters_detected --difference 3%",
    "nvcore plan night.toml --measure mean_similarity --margin 0.01 --out plan.json",
)
@input_options
@options_of(PlanArguments)
@grouped_option(
    OUTPUT, "--out", type=FILE, metavar="FILE.json", help="Write the plan as JSON into this file."
)
@grouped_option(OUTPUT, "--json", "as_json", is_flag=True, help="Print the plan as JSON.")
@strict_option
@protocol_option
@parameter_options
def plan(out: Path | None, as_json: bool, strict: bool, **options: Any) -> None:
    """Say how many recordings like these would show a difference between X and Y.

    Inputs as for compare. Studies are simulated by drawing whole recordings from these, of which 6
    or more are needed. With --margin: how many would show that the candidate is at most that much
    worse, and whether these do. Exit code 0: fine, 1: the audit found errors (with --strict: or
    warnings), 2: bad input, or fewer than 6 recordings.
    """
    from nvcore.common.errors import InputError
    from nvcore.evidence.planning import plan_key, plan_recordings
    from nvcore.evidence.planning.pilot import MIN_PILOT
    from nvcore.evidence.units import WHOLE
    from nvcore.report.plan import plan_json, render_plan
    from nvcore.report.protect_inputs import files_read, refuse_to_replace
    from nvcore.report.terminal import render_findings

    session = session_from(options, needs_y=True)
    key = plan_key(options["measure"] or session.primary.key)
    for name in ("difference", "margin"):
        options[name] = _amount(flag_of(name), options[name], key)
    asked = arguments_of(PlanArguments, options)
    if out is not None and out.suffix.lower() != ".json":  # protects inputs named by mistake
        raise click.UsageError(
            f"--out: expected a file that ends in .json, got {one_line(str(out))}"
        )
    if out is not None:
        refuse_to_replace([out], files_read(session))
    with errors_of(session):
        result, findings = compare_session(session, "equal-alarms")
    protocol = result.dataset.settings.protocol
    plan = plan_recordings(result, asked, protocol=protocol)
    row = plan.evidence
    if row.unit not in WHOLE or row.n < MIN_PILOT:
        raise InputError(plan.sizes[0].reason)
    if out is not None:
        write_whole(out, plan_json(plan).encode())
    shown = shown_findings(session, result.dataset, findings)
    click.echo(render_findings(shown) + "\n", err=as_json)
    click.echo(plan_json(plan) if as_json else render_plan(plan), nl=not as_json)
    say_written(out)
    exit_on_findings(findings, strict)


def _amount(flag: str, text: str | None, key: str) -> float | None:
    """Parse the number of a flag. 3% is 0.03, for measures that are shares."""
    from nvcore.comparison.measures.table import inference_of

    if text is None:
        return None
    is_percent = text.strip().endswith("%")
    if is_percent and not inference_of(key).scale.is_share:
        raise click.UsageError(
            f"{flag}: {text} of what? Expected a number in the unit of the measure, which is no "
            "share"
        )
    try:
        return float(text.strip().removesuffix("%")) / (100 if is_percent else 1)
    except ValueError as error:
        raise click.UsageError(
            f"{flag}: expected a number, such as 0.5 or 3%, found {one_line(text)!r}"
        ) from error
