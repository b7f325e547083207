"""The pages Driver and Study, and what they add to the dashboard."""

from typing import Final

ROUTES: Final = "study.routes:ROUTES"
STUDIES: Final = "study.files:STUDIES"
