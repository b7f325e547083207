"""``nvcore driver``: would the driver have seen the pedestrian himself."""

from __future__ import annotations

from typing import Final

import click

from nvcore.cli.driver.estimate import estimate
from nvcore.cli.driver.features import features
from nvcore.cli.driver.train import evaluate, train

COMMANDS: Final[tuple[click.Command, ...]] = (features, train, evaluate, estimate)
"""The commands below ``nvcore driver``, in the order of its help."""


@click.group(short_help="Would the driver have seen the pedestrian himself.")
def driver() -> None:
    """Estimate whether the driver would have seen each pedestrian himself."""


for command in COMMANDS:
    driver.add_command(command)
