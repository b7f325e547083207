"""``nvcore driver``: would the driver have seen the pedestrian himself."""

from __future__ import annotations

from typing import Final

import click

COMMANDS: Final[tuple[click.Command, ...]] = ()
"""The commands below ``nvcore driver``, in the order of its help."""


@click.group(short_help="Would the driver have seen the pedestrian himself.")
def driver() -> None:
    """Estimate whether the driver would have seen each pedestrian himself."""


for command in COMMANDS:
    driver.add_command(command)
