"""Detectors that are trained or run by nvcore: pictures in, scored boxes out."""

from nvcore.subjects import Subject

SUBJECT = Subject(
    name="detectors",
    findings="findings:CHECKS",
    caveats="findings:CAVEATS",
    commands="commands:COMMANDS",
    models="words:MODELS",
    formats={"nvcore-icf": "a detector of pedestrians or signs, which nvcore detect takes"},
    names={"detect": "face:detect", "train": "face:train"},
    extras={"detectors": ("av", "cv2"), "onnx": ("av", "cv2", "google", "onnxruntime")},
    ui="ui.detectors",
)
