"""The page Ratings, and what it adds to the dashboard."""

from typing import Final

STUDIES: Final = "sessions:SESSIONS"
