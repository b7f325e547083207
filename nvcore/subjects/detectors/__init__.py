"""Detectors that are trained or run by nvcore: pictures in, scored boxes out."""

from nvcore.common.subject import Subject

SUBJECT = Subject(
    name="detectors",
    findings="findings:CHECKS",
    caveats="findings:CAVEATS",
    commands="calls.commands:COMMANDS",
    models="words:MODELS",
    formats={"nvcore-icf": "a detector of pedestrians or signs, which nvcore detect takes"},
    names={"detect": "calls.python:detect", "train": "calls.python:train"},
    extras={"detectors": ("av", "cv2"), "onnx": ("av", "cv2", "google", "onnxruntime")},
    ui="ui.subjects.detectors",
)
