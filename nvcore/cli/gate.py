"""``nvcore gate``: rules that a comparison has to pass, for nightly runs."""

from __future__ import annotations

import shlex
from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from nvcore.cli.options import (
    GroupedCommand,
    examples,
    grouped_option,
    input_options,
    parameter_options,
    protocol_option,
)
from nvcore.cli.program import BadInput
from nvcore.cli.session_options import session_from
from nvcore.cli.steps import compare_session, errors_of, shown_findings
from nvcore.common.arguments import FOLDER, OUTPUT
from nvcore.common.errors import InputError, NvcoreError
from nvcore.common.output.files import write_whole
from nvcore.common.wording import one_line
from nvcore.inputs.session.toml import read_session

if TYPE_CHECKING:
    from nvcore.report.gate.rules import Rule

RULES = "Rules"
EXIT_FAILED = 1
STANDARD = Path("-")
"""File name that stands for standard input or output."""


class _GateCommand(GroupedCommand):
    """Command that replaces old result files by the error if it fails."""

    def parse_args(self, ctx: click.Context, args: list[str]) -> list[str]:
        arguments = [*args]
        try:
            return super().parse_args(ctx, args)
        except click.UsageError as error:
            values = (_value_of(flag, arguments) for flag in ("--out", "--junit", "--markdown"))
            _write_problem(*_result_files(*values), error.format_message())
            raise

    def invoke(self, ctx: click.Context) -> Any:
        try:
            return super().invoke(ctx)
        except click.ClickException as error:
            _write_problem(*self._files(ctx), error.format_message())
            raise
        except NvcoreError as error:
            _write_problem(*self._files(ctx), str(error))
            raise

    @staticmethod
    def _files(ctx: click.Context) -> tuple[Path | None, Path | None]:
        names = ("out", "junit", "markdown_file")
        return _result_files(*(ctx.params[name] for name in names))


def _result_files(
    out: Path | None, junit: Path | None, markdown_file: Path | None
) -> tuple[Path | None, Path | None]:
    """Return the files for outcomes as JUnit XML and Markdown, by default in the folder `out`."""
    if out is None:
        return junit, markdown_file
    return junit or out / "gate.xml", markdown_file or out / "gate.md"


def _file_type() -> click.Path:
    return click.Path(dir_okay=False, allow_dash=True, path_type=Path)


@click.command(
    cls=_GateCommand,
    short_help="Exit with 1 if a rule does not hold.",
    epilog=examples(
        "nvcore gate night.toml --rule 'newly_missed == 0' --out gate",
        "nvcore gate night.toml --rules rules.txt --strict",
        "nvcore gate night.toml --list",
    ),
)
@input_options
@grouped_option(
    RULES,
    "--rule",
    "rules",
    multiple=True,
    metavar="RULE",
    help="A measure, a comparison and a number: 'lamr_y <= 0.10'. Can be given again.",
)
@grouped_option(
    RULES,
    "--rules",
    "rules_file",
    metavar="FILE",
    type=_file_type(),
    help="A file with a rule on each line; # begins a comment; - is the standard input.",
)
@grouped_option(
    RULES, "--strict", is_flag=True, help="Warnings of the audit break the gate, as errors do."
)
@grouped_option(RULES, "--list", "lists", is_flag=True, help="Print all measures and their values.")
@protocol_option
@grouped_option(
    OUTPUT,
    "--out",
    type=FOLDER,
    help="Write the outcomes as gate.xml (JUnit) and gate.md into this folder.",
)
@grouped_option(
    OUTPUT,
    "--junit",
    type=_file_type(),
    metavar="FILE",
    help="Write the outcomes as JUnit XML; - is the standard output.",
)
@grouped_option(
    OUTPUT,
    "--markdown",
    "markdown_file",
    type=_file_type(),
    metavar="FILE",
    help="Write the outcomes as Markdown; - is the standard output.",
)
@parameter_options
def gate(
    rules: tuple[str, ...],
    rules_file: Path | None,
    strict: bool,
    lists: bool,
    out: Path | None,
    junit: Path | None,
    markdown_file: Path | None,
    **options: Any,
) -> None:
    """Compare X and Y, and exit with 1 if a rule does not hold.

    Inputs as for compare; without --rule and --rules, the rules are those of the session file. A
    measure ends with _x, _y or _difference (X - Y); newly_missed are the encounters that X detects
    and Y does not: give the release in use as X, the candidate as Y. An undefined measure breaks
    its rule, unless the rule ends with 'or undefined'. Exit code 0: all rules hold, 1: one does
    not, or the audit found errors (with --strict: or warnings), 2: bad input or no such measure.
    """
    from nvcore.report.gate import run_gate
    from nvcore.report.gate.measures import listed_names, measure_names
    from nvcore.report.gate.outcomes import value_text
    from nvcore.report.gate.results import junit_xml, markdown, terminal_lines
    from nvcore.report.protect_inputs import files_read, refuse_among_inputs, refuse_to_replace
    from nvcore.report.terminal import render_findings

    junit, markdown_file = _result_files(out, junit, markdown_file)
    files = [file for file in (junit, markdown_file) if file is not None]
    is_machine_read = _takes_standard_output(files, lists)
    outputs = [file for file in files if file != STANDARD]
    inputs = (options["session_file"], rules_file)
    refuse_to_replace(outputs, (file for file in inputs if file is not None and file != STANDARD))
    gate_rules = _read(rules, rules_file, options["session_file"])
    if not gate_rules and not lists:
        problem = "" if rules_file is None else "the file of rules holds none; "
        raise click.UsageError(f"{problem}give a rule: --rule 'lamr_y <= 0.10', or --rules FILE")
    session = session_from(options, needs_y=True)
    refuse_to_replace(outputs, files_read(session))
    if out is not None:
        written = click.get_current_context().params
        written["out"] = None  # an error about a folder of inputs must not be written into it
        refuse_among_inputs(out, session)
        written["out"] = out
    _write_problem(junit, markdown_file, "it was stopped before it ended", prints=False)
    with errors_of(session):
        result, findings = compare_session(session)
    names = measure_names() if lists else ()
    outcomes, values = run_gate(gate_rules, result, findings, strict=strict, names=names)
    findings = shown_findings(session, result.dataset, findings)
    click.echo(render_findings(findings), err=is_machine_read)
    if lists:
        listed = listed_names(result, values)
        width = max(map(len, listed))
        for name in listed:
            click.echo(f"{name:<{width}}  {value_text(values[name])}")
    click.echo("\n".join(["", *terminal_lines(outcomes)]), err=is_machine_read)
    title = f"{result.x.name} (X) and {result.y.name} (Y)"
    if junit is not None:
        _write(junit, junit_xml(outcomes, title, findings))
    if markdown_file is not None:
        _write(markdown_file, markdown(outcomes, title, findings).encode())
    if not all(outcome.is_passed for outcome in outcomes):
        raise SystemExit(EXIT_FAILED)


def _takes_standard_output(files: Sequence[Path], lists: bool) -> bool:
    """Whether machine-readable output goes to standard output. Refuse conflicting outputs."""
    n_taken = files.count(STANDARD) + lists
    if n_taken > 1:
        raise click.UsageError("only one of --list, --junit - and --markdown - can be printed")
    if len(files) == 2 and files[0].resolve() == files[1].resolve():
        raise click.UsageError("--junit and --markdown: expected two files, found the same twice")
    return n_taken > 0


def _read(texts: Sequence[str], file: Path | None, session: Path | None) -> list[Rule]:
    """Return the rules from the flags and the file, or raise BadInput with all their problems."""
    from nvcore.report.gate.measures import measure_names
    from nvcore.report.gate.rules import read_rules

    lines = [("--rule", text) for text in texts]
    if session is not None and not texts and file is None:
        where = f"{one_line(str(session))}: [gate]"
        lines = [(where, text) for text in read_session(session).rules]
    if file is not None:
        name = "standard input" if file == STANDARD else one_line(str(file))
        numbered = enumerate(_content(file).splitlines(), 1)
        lines += [(f"{name}, line {number}", text) for number, text in numbered]
    rules, problems = read_rules(lines, measure_names())
    if problems:
        listed_of = "SESSION_FILE" if session is None else shlex.quote(one_line(str(session)))
        problems.append(f"nvcore gate {listed_of} --list shows all measures")
        raise BadInput("\n".join(problems))
    return rules


def _content(file: Path) -> str:
    try:
        with click.open_file(str(file), "rb") as stream:
            content: bytes = stream.read()
        return content.decode("utf-8-sig")
    except OSError as error:
        raise InputError(f"the rules cannot be read ({error.strerror})", file=file) from error
    except UnicodeDecodeError as error:
        raise InputError(
            "the rules cannot be read: expected UTF-8 text; save the file as UTF-8", file=file
        ) from error


def _write(file: Path, content: bytes) -> None:
    if file == STANDARD:
        click.echo(content, nl=False)
        return
    write_whole(file, content)


def _write_problem(
    junit: Path | None, markdown_file: Path | None, problem: str, *, prints: bool = True
) -> None:
    """Write the reason for a failed run in place of results, except over files of other origin."""
    from nvcore.report.gate.results import is_gate_result, junit_error, markdown_error

    contents = ((junit, junit_error(problem)), (markdown_file, markdown_error(problem).encode()))
    for file, content in contents:
        if file is None or (file == STANDARD and not prints):
            continue
        # resolved, because a path by way of a missing folder (missing/../a.csv) seems not to exist
        target = file if file == STANDARD else file.resolve()
        with suppress(OSError, InputError):
            if file == STANDARD or not target.exists() or is_gate_result(_head(target)):
                _write(target, content)


def _head(file: Path) -> bytes:
    """Return the beginning of a regular file, or b"" for anything else, such as a terminal."""
    if not file.is_file():
        return b""
    with file.open("rb") as stream:
        return stream.read(200)


def _value_of(flag: str, arguments: Sequence[str]) -> Path | None:
    """Find the value of a flag in arguments that could not be parsed."""
    for argument, following in zip(arguments, [*arguments[1:], None], strict=True):
        if argument == flag and following is not None:
            return Path(following)
        if argument.startswith(f"{flag}="):
            return Path(argument.partition("=")[2])
    return None
