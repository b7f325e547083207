"""The subjects: further questions about a comparison, each in one package (and `people`)."""

from nvcore.common.subject import Subject
from nvcore.subjects.alerts import Alerts
from nvcore.subjects.detectors import Detectors
from nvcore.subjects.driver import Driver
from nvcore.subjects.fleet import Fleet
from nvcore.subjects.ratings import Ratings
from nvcore.subjects.releases import Releases
from nvcore.subjects.review import Review
from nvcore.subjects.time_left import TimeLeft

SUBJECTS: tuple[Subject, ...] = (
    TimeLeft(),
    Detectors(),
    Driver(),
    Alerts(),
    Releases(),
    Ratings(),
    Fleet(),
    Review(),
)
"""All subjects, in the order in which their additions are listed."""
