"""``nvcore driver``: estimate what the driver would have seen unaided."""

from __future__ import annotations

from typing import Final

import click

from nvcore.driver.commands.run import estimate, features
from nvcore.driver.commands.train import evaluate, train


@click.group(short_help="Estimate what the driver would have seen unaided.")
def driver() -> None:
    """Estimate whether the driver would have seen each pedestrian unaided."""


for command in (features, train, evaluate, estimate):
    driver.add_command(command)

COMMANDS: Final = (driver,)
