"""The page Time left, and what it adds to the dashboard."""

from typing import Final

ENCOUNTER_TEXT: Final = "encounter:draw_text"
ENCOUNTER_WAYS: Final = "encounter:draw_ways"
COLUMN_LOOKS: Final = "looks:LOOKS"
