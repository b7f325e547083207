"""Timeline page: the frame viewer."""

from __future__ import annotations

from typing import Final

from nvcore.comparison import Result
from ui.session import state
from ui.timeline import listed
from ui.widgets import compared_viewer

HEIGHT_PX: Final = 700
KEY: Final = "viewer"


def settled() -> int:
    """Row within the recording that the viewer has settled on, also before it is drawn."""
    return compared_viewer.settled(KEY)


def draw(result: Result) -> None:
    """The viewer."""
    box = listed.box_in(state.recording())
    compared_viewer.draw(result, KEY, height_px=HEIGHT_PX, listed=box)
