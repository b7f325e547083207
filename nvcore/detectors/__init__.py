"""Detectors that are trained or run here: pictures in, boxes with scores out."""

from nvcore.subjects import Subject

SUBJECT = Subject(
    name="detectors",
    findings="findings:CHECKS",
    caveats="findings:CAVEATS",
    commands="commands:COMMANDS",
    models="words:MODELS",
    names={"detect": "face:detect", "train": "training.face:train"},
    extras={"detectors": ("av", "cv2"), "onnx": ("av", "cv2", "google", "onnxruntime")},
    ui="ui.detectors",
)
