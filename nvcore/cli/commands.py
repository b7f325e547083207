"""Group of all commands, from the core and from the subjects."""

from __future__ import annotations

from itertools import chain

import click

from nvcore import __version__
from nvcore.cli.app import app, sample
from nvcore.cli.compare import check, compare
from nvcore.cli.convert import convert
from nvcore.cli.gate import gate
from nvcore.cli.groups import groups
from nvcore.cli.matrix import matrix
from nvcore.cli.models import models
from nvcore.cli.options import examples
from nvcore.cli.plan import plan
from nvcore.cli.program import Program
from nvcore.cli.report import report
from nvcore.common.subject import subjects


@click.group(
    cls=Program,
    context_settings={"help_option_names": ["-h", "--help"], "max_content_width": 100},
    epilog=examples(
        "nvcore compare sample_data/session.toml", "nvcore app", "nvcore compare --help"
    ),
)
@click.version_option(__version__, prog_name="nvcore")
def main() -> None:
    """Compare two pedestrian-detection systems by what the driver notices."""


for command in (
    *(compare, check, convert, gate, matrix, plan, report, groups),
    *chain(*(subject.commands() for subject in subjects())),
    *(models, app, sample),
):
    main.add_command(command)
