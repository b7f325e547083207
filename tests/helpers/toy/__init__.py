"""A subject for the tests: how many encounters are long, and who detects those."""

from nvcore.common.subject import Subject

SUBJECT = Subject(
    name="toy",
    settings="settings:ToySettings",
    results="settings:RESULTS",
    steps="measures:STEPS",
    view="measures:is_long",
    measures="measures:MEASURES",
    columns="shown:COLUMNS",
    figures="shown:FIGURES",
    points="shown:POINTS",
    ui="toy.ui",
)
