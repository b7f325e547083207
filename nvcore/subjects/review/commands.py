"""``nvcore review``: projects and the decisions on their cases."""

from __future__ import annotations

import getpass
import sys
from pathlib import Path
from typing import TYPE_CHECKING

import click

from nvcore.cli.options import command, grouped_option
from nvcore.cli.steps import EXIT_FINDINGS, say_written
from nvcore.common.output.files import write_whole
from nvcore.common.wording import aligned, count_text, number

if TYPE_CHECKING:
    from nvcore.subjects.review.calls import OpenProject

# As in nvcore/cli/__init__.py, numpy is imported by the command only.

ACTIONS = {
    "new": "NAME SESSION_FILE",
    "list": "[NAME]",
    "decide": "NAME CASE DECISION",
    "check": "NAME",
    "measures": "NAME",
    "export": "NAME FILE",
    "import": "FILE [NAME]",
    "delete": "NAME",
    "backup": "FILE",
}
"""Words after each action."""


@command(
    "Projects: decide on misses and false alarms one by one.",
    'nvcore review new "Night drive" night.toml',
    'nvcore review list "Night drive" --open',
    'nvcore review decide "Night drive" a4bf488f4d wrong-truth --note "a pole"',
    'nvcore review measures "Night drive"',
    'nvcore review export "Night drive" night.zip',
)
@click.argument("action", type=click.Choice(list(ACTIONS)))
@click.argument("words", nargs=-1)
@grouped_option(
    "Decisions",
    "--reviewer",
    metavar="NAME",
    help="Whose decision it is. Default: the user's log-in.",
)
@grouped_option("Decisions", "--note", default="", metavar="TEXT", help="A note on the decision.")
@grouped_option("Decisions", "--open", "only_open", is_flag=True, help="List only open cases.")
@grouped_option(
    "Decisions",
    "--above",
    type=float,
    default=0.0,
    metavar="SECONDS",
    help="List or check only cases of larger severity, or longer false alarms.",
)
@grouped_option(
    "Store",
    "--projects",
    "store",
    type=click.Path(path_type=Path),
    metavar="FILE",
    help="File of the projects. Default: $NVCORE_PROJECTS, else in the application folder.",
)
def review(
    action: str,
    words: tuple[str, ...],
    reviewer: str | None,
    note: str,
    only_open: bool,
    above: float,
    store: Path | None,
) -> None:
    """Keep a comparison as a project, list its cases, and decide on them.

    \b
    new NAME SESSION_FILE      keep a comparison as a project
    list [NAME]                the projects, or the cases of one
    decide NAME CASE DECISION  real-miss, false-alarm, wrong-truth, irrelevant, ask, open
    check NAME                 exit with 1 if a case more severe than --above is open
    measures NAME              every measure before and after the review
    export NAME FILE           a project as .zip, its decisions as .csv or .json, the frames of
                               its open cases as .xml for CVAT
    import FILE [NAME]         a project from .zip (under another name), or decisions into one
    delete NAME                a project, and what no other one uses
    backup FILE                copy the file of all projects, also while it is in use

    Cases called wrong truth or irrelevant are left out of the measures after the review. Exit code
    0: fine, 1: a check failed, 2: bad input.
    """  # noqa: D301
    from nvcore.subjects.review.calls import import_project, open_project, open_store
    from nvcore.subjects.review.decisions import COLUMNS, read_decisions, write_decisions

    def need(n: int) -> tuple[str, ...]:
        if len(words) != n:
            raise click.UsageError(f"review {action} {ACTIONS[action]}")
        return words

    if action == "list" and not words:
        rows = [
            (of.name, f"{of.created_at:%Y-%m-%d}", f"?project={of.token}")
            for of in open_store(store).projects()
        ]
        click.echo("\n".join(aligned(rows)) if rows else "No projects.")
    elif action == "list":
        _list_cases(open_project(need(1)[0], store=store), only_open=only_open, above=above)
    elif action == "check":
        if _list_cases(open_project(need(1)[0], store=store), only_open=True, above=above):
            sys.exit(EXIT_FINDINGS)
    elif action == "new":
        name, session = need(2)
        open_project(name, session=session, store=store)
        click.echo(f"kept: {name}")
    elif action == "decide":
        name, case, decision = need(3)
        text = "" if decision == "open" else decision.replace("-", " ")
        open_project(name, store=store).decide(case, text, reviewer=_reviewer(reviewer), note=note)
        click.echo(f"decided: {case} {decision}")
    elif action == "measures":
        _list_measures(open_project(need(1)[0], store=store))
    elif action == "export":
        name, out = need(2)
        project = open_project(name, store=store)
        if Path(out).suffix == ".zip":
            open_store(store).export(project.project.token, Path(out))
        elif Path(out).suffix == ".xml":
            write_whole(Path(out), project.open_as_cvat())
        elif Path(out).suffix not in (".csv", ".json"):
            raise click.UsageError(f"{out}: a file ends in .zip, .csv, .json or .xml")
        else:
            write_decisions(project.decisions[list(COLUMNS)], Path(out))
        say_written(Path(out))
    elif action == "import":
        file = Path(words[0]) if words else Path(need(1)[0])
        if file.suffix == ".zip":
            new_name = words[1] if len(words) == 2 else None
            click.echo(f"kept: {import_project(file, name=new_name, store=store).name}")
        else:
            project, decisions = open_project(need(2)[1], store=store), read_decisions(file)
            open_store(store).decide(project.project.token, decisions)
            click.echo(count_text(len(decisions), "decision"))
    elif action == "backup":
        (out,) = need(1)
        open_store(store).backup(Path(out))
        say_written(Path(out))
    else:
        (name,) = need(1)
        open_store(store).delete(open_project(name, store=store).project.token)
        click.echo(f"deleted: {name}")


def _reviewer(name: str | None) -> str:
    """Return a name that was given, else the user's log-in, else none."""
    if name is not None:
        return name
    try:
        return getpass.getuser()
    except (KeyError, OSError):  # a user without an account, as in a container
        return ""


def _list_cases(project: OpenProject, *, only_open: bool, above: float) -> int:
    """Print the cases, and return their number."""
    cases = project.cases
    is_heavy = cases["severity_s"] > above if above else True
    shown = cases[~(cases["is_done"] & only_open) & is_heavy]
    rows = [("case", "kind", "systems", "recording", "frames", "s", "decision", "note")]
    for row in shown.to_dict("records"):
        frames, seconds = f"{row['first_frame']}-{row['last_frame']}", row["severity_s"]
        begin = (row["case"], row["kind"], row["systems"].upper(), row["recording"])
        rows.append((*begin, frames, number(seconds, ".2f"), row["decision"], row["note"]))
    click.echo("\n".join(aligned(rows)))
    click.echo(f"{int(cases['is_done'].sum())} of {len(cases)} done")
    robust = project.robustness
    if robust is not None and robust.turns_sign:
        n = len(robust.turns_sign)
        ids = ", ".join(cases["case"].iloc[list(robust.turns_sign)])
        click.echo(f"The leader would change without {count_text(n, 'miss', 'misses')}: {ids}")
    return len(shown)


def _list_measures(project: OpenProject) -> None:
    rows = [("", "X", "Y", "X reviewed", "Y reviewed")]
    for row in project.measures.to_dict("records"):
        x, y, new_x, new_y = (
            number(row[name], ".4g") for name in ("x", "y", "x_reviewed", "y_reviewed")
        )
        rows.append((row["label"], x, y, new_x, new_y))
    click.echo("\n".join(aligned(rows)))
