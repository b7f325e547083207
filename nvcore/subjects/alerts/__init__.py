"""Alerts: which detections reach the driver, and which of the resulting alerts were justified."""

from nvcore.common.subject import Subject

SUBJECT = Subject(
    name="alerts",
    needs=("time_left", "driver"),
    settings="settings:AlertSettings",
    results="settings:RESULTS",
    steps="steps:STEPS",
    view="steps:AlertsView",
    measures="measures:MEASURES",
    counts="measures:COUNTS",
    doubts="notes:doubt_of",
    columns="columns:COLUMNS",
    figures="figures:FIGURES",
    points="section:POINTS",
    sections="section:SECTIONS",
    system_keys="session:SystemAlerts",
    inputs="inputs:INPUT",
    commands="calls.commands:COMMANDS",
    ui="ui.subjects.alerts",
    names={"judge_alerts": "calls.python:judge_alerts"},
)
