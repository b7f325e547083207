"""The pages Driver and Study, and what they add to the dashboard."""

from typing import Final

ASIDE: Final = "finished:ASIDE"
ROUTES: Final = "study.routes:ROUTES"
STUDIES: Final = "study.files:STUDIES"
