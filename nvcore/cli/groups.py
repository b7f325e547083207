"""``nvcore groups``: test whether persons or drives differ between conditions."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from nvcore.cli.options import command, grouped_option, options_of
from nvcore.cli.steps import say_written
from nvcore.common.arguments import FILE, FOLDER, OUTPUT
from nvcore.common.arguments.groups import GroupArguments

# As in nvcore/cli/__init__.py, numpy and pandas are imported by the command only.


@command(
    "Compare groups of persons or drives.",
    "nvcore groups reactions.csv",
    "nvcore groups drives.csv --measure violations --rename control=",
    "nvcore groups means.csv --correlation 0.7 --difference 300",
)
@click.argument("table", type=FILE)
@options_of(GroupArguments)
@grouped_option(
    OUTPUT, "--out", type=FOLDER, help="Write the tables as CSV, and groups.json, into this folder."
)
@grouped_option(OUTPUT, "--json", "as_json", is_flag=True, help="Print groups.json.")
def groups(table: Path, out: Path | None, as_json: bool, **options: Any) -> None:
    """Compare groups of persons or drives: which conditions differ, by the test that fits.

    TABLE (CSV) has the columns condition and value, if known participant, or another column to
    compare; a table of drives has participant,condition,duration_s,violations,kind. Or it has
    condition,n,mean,sd. Whether the same persons stand in all conditions is found from the column
    participant. The test that fits has a star, others stand beside it. Exit code 0: fine, 2: bad
    input.
    """
    from nvcore.common.output.files import check_folder
    from nvcore.evidence.groups import compare_groups
    from nvcore.evidence.groups.text import FILES, groups_json, write_groups
    from nvcore.report.protect_inputs import refuse_to_replace

    if out is not None:
        refuse_to_replace((out / name for name in FILES), [table])
        check_folder(out, FILES)
    comparison = compare_groups(GroupArguments(table, **options))
    if out is not None:
        write_groups(out, comparison)
    click.echo(groups_json(comparison) if as_json else str(comparison), nl=not as_json)
    say_written(out)
