"""Time left page: the way to a moment in the Timeline, where its pedestrian is the chosen one."""

from __future__ import annotations

from typing import NoReturn

from nvcore.comparison import Result
from ui.session.chosen import choose_encounter
from ui.shell.navigate import open_row


def open_encounter(result: Result, encounter: int, row: int) -> NoReturn:
    """Show a frame of an encounter on the Timeline, its lane marked."""
    choose_encounter(result, encounter)
    open_row(row)
