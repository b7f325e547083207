"""Estimates of what drivers see unaided: picture features, estimators, and trials with people."""

from nvcore.common.subject import Subject

SUBJECT = Subject(
    name="driver",
    needs=("time_left",),
    settings="comparison.settings:DriverSettings",
    results="comparison.settings:RESULTS",
    steps="comparison.steps:STEPS",
    view="comparison.steps:driver_view",
    miss_weights="comparison.steps:MISS_WEIGHTS",
    findings="findings:CHECKS",
    caveats="findings:CAVEATS",
    recording_keys="inputs.session:DriverEntry",
    session_tables="inputs.session:DriverTables",
    inputs="inputs.joining:INPUT",
    commands="calls.commands:COMMANDS",
    measures="comparison.measures:MEASURES",
    counts="comparison.measures:COUNTS",
    doubts="comparison.notes:doubt_of",
    columns="comparison.columns:COLUMNS",
    entries="comparison.columns:ENTRIES",
    points="comparison.report:POINTS",
    remarks="comparison.report:REMARKS",
    sections="comparison.report:SECTIONS",
    rules="comparison.gate:RULES",
    models="evaluation.estimator_report:MODELS",
    formats={
        "nvcore-driver": "an estimator of what the driver sees, which nvcore driver estimate takes"
    },
    names={
        "driver_features": "calls.python:driver_features",
        "estimate_driver": "calls.python:estimate_driver",
        "evaluate_driver": "calls.python:evaluate_driver",
        "image_features": "calls.python:image_features",
        "train_driver": "calls.python:train_driver",
    },
    extras={"driver": ("av", "cv2", "sklearn")},
    ui="ui.subjects.driver",
)
