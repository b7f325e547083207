"""Time left: whether the car could still have stopped when a system confirmed a pedestrian."""

from nvcore.common.subject import Subject

SUBJECT = Subject(
    name="time_left",
    settings="settings:TimeLeftSettings",
    results="settings:RESULTS",
    steps="steps:STEPS",
    view="steps:TimeLeftView",
    restrict="steps:only_urgent_of",
    measures="measures:MEASURES",
    counts="measures:COUNTS",
    columns="columns:COLUMNS",
    entries="columns:ENTRIES",
    figures="figures:FIGURES",
    lanes="figures:LANES",
    points="notes:POINTS",
    sections="section:SECTIONS",
    ui="ui.subjects.time_left",
)
