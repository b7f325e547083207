"""Time left: could the car still have stopped when a system was sure of a pedestrian."""

from nvcore.subjects import Subject

SUBJECT = Subject(
    name="time_left",
    settings="settings:TimeLeftSettings",
    results="settings:RESULTS",
    steps="steps:STEPS",
    view="steps:TimeLeftView",
    restrict="steps:only_urgent_of",
)
