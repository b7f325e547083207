"""``nvcore driver``: would the driver have seen the pedestrian himself."""

from __future__ import annotations

from typing import Final

import click

from nvcore.driver.commands.estimate import estimate
from nvcore.driver.commands.features import features
from nvcore.driver.commands.train import evaluate, train


@click.group(short_help="Would the driver have seen the pedestrian himself.")
def driver() -> None:
    """Estimate whether the driver would have seen each pedestrian himself."""


for command in (features, train, evaluate, estimate):
    driver.add_command(command)

COMMANDS: Final = (driver,)
