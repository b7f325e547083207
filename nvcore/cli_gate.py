"""``nvcore gate``: rules that a comparison has to pass, for nightly runs."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from nvcore.cli_inputs import (
    OUTPUT,
    GroupedCommand,
    grouped_option,
    input_options,
    parameter_options,
    pasteable_errors,
    session_from,
    sources_of,
)
from nvcore.cli_steps import compare_session, protocol_named
from nvcore.errors import InputError

RULES = "Rules"
EXIT_FAILED = 1


@click.command(cls=GroupedCommand, short_help="Exit with 1 if a rule does not hold.")
@input_options
@grouped_option(
    RULES,
    "--rule",
    "rules",
    multiple=True,
    metavar="RULE",
    help="A figure, a comparison and a number: 'lamr_x <= 0.10'. Can be given again.",
)
@grouped_option(
    RULES,
    "--rules",
    "rules_file",
    metavar="FILE",
    type=click.Path(path_type=Path),
    help="A file with a rule on each line; # begins a comment.",
)
@grouped_option(
    RULES,
    "--protocol",
    metavar="NAME",
    default="all",
    show_default=True,
    help="Which pedestrians count in lamr, ap, recall and the like (docs/detection.md).",
)
@grouped_option(RULES, "--list", "lists", is_flag=True, help="Print all figures and their values.")
@grouped_option(
    OUTPUT,
    "--junit",
    type=click.Path(dir_okay=False, path_type=Path),
    metavar="FILE",
    help="Write the outcomes as JUnit XML.",
)
@grouped_option(
    OUTPUT,
    "--markdown",
    "markdown_file",
    type=click.Path(dir_okay=False, path_type=Path),
    metavar="FILE",
    help="Write the outcomes as a Markdown table.",
)
@parameter_options
def gate(
    rules: tuple[str, ...],
    rules_file: Path | None,
    protocol: str,
    lists: bool,
    junit: Path | None,
    markdown_file: Path | None,
    **options: Any,
) -> None:
    """Compare X and Y, and exit with 1 if a rule does not hold.

    Inputs as for compare. A figure ends with _x, _y or _difference (X - Y); new_misses are the
    encounters that X detects and Y does not: give the release in use as X, the candidate as Y. An
    undefined figure breaks its rule. Exit code 0: all rules hold, 1: one does not, 2: bad input or
    no such figure.
    """
    from nvcore.gate import CURVE_NAMES, gate_figures, judge, junit_xml, markdown, parse_rules

    chosen = protocol_named(protocol)
    wanted = parse_rules([*rules, *_lines(rules_file)])
    if not wanted and not lists:
        raise click.UsageError("give a rule: --rule 'lamr_x <= 0.10', or --rules FILE")
    session = session_from(options, needs_y=True)
    with pasteable_errors(session.folder, sources_of(session)):
        result, findings = compare_session(session)
    names = [f"{name}_x" for name in CURVE_NAMES] if lists else [rule.name for rule in wanted]
    figures = gate_figures(result, findings, chosen, names)
    if lists:
        width = max(map(len, figures))
        for name in sorted(figures):
            click.echo(f"{name:<{width}}  {figures[name]:.6g}")
    outcomes = judge(wanted, figures)
    title = f"{result.x.name} and {result.y.name}"
    if junit is not None:
        _write(junit, junit_xml(outcomes, title))
    if markdown_file is not None:
        _write(markdown_file, markdown(outcomes, title).encode())
    for one in outcomes:
        click.echo(f"{'passed' if one.is_passed else 'FAILED'}  {one.rule.text}  ({one.message})")
    if not all(one.is_passed for one in outcomes):
        raise SystemExit(EXIT_FAILED)


def _lines(file: Path | None) -> list[str]:
    if file is None:
        return []
    try:
        return file.read_text(encoding="utf-8").splitlines()
    except (OSError, UnicodeDecodeError) as error:
        raise InputError(f"the rules cannot be read ({error})", file=file) from error


def _write(file: Path, content: bytes) -> None:
    try:
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_bytes(content)
    except OSError as error:
        raise InputError(f"cannot be written ({error.strerror})", file=file) from error
