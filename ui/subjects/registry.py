"""The pages of all subjects. Processes that must not load Streamlit import single packages."""

from typing import Final

from ui.subject import SubjectPages
from ui.subjects.alerts import AlertsPages
from ui.subjects.detectors import DetectorsPages
from ui.subjects.driver import DriverPages
from ui.subjects.ratings import RatingsPages
from ui.subjects.releases import ReleasesPages
from ui.subjects.review import ReviewPages
from ui.subjects.time_left import TimeLeftPages

SUBJECTS: Final[tuple[SubjectPages, ...]] = (
    TimeLeftPages(),
    DetectorsPages(),
    DriverPages(),
    AlertsPages(),
    ReleasesPages(),
    RatingsPages(),
    ReviewPages(),
)
"""In the order in which their additions are listed."""
