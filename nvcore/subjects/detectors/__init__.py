"""Detectors that are trained or run by nvcore: pictures in, scored boxes out."""

from __future__ import annotations

from collections.abc import Sequence
from typing import ClassVar

from nvcore.common import subject


class Detectors(subject.Subject):
    """Detectors that nvcore runs or trains."""

    name = "detectors"
    names: ClassVar = {"nvcore.subjects.detectors.calls.python": ("detect", "train")}
    formats: ClassVar = {
        "nvcore-icf": "a detector of pedestrians or signs, which nvcore detect takes"
    }
    extras: ClassVar = {"detectors": ("av", "cv2"), "onnx": ("av", "cv2", "google", "onnxruntime")}

    def checks(self) -> subject.AddedChecks:
        from nvcore.subjects.detectors.findings import CAVEATS, audit_provenance

        return subject.AddedChecks((audit_provenance,), caveats=(CAVEATS,))

    def commands(self) -> Sequence[subject.Command]:
        from nvcore.subjects.detectors.calls.commands import detect, train

        return (train, detect)

    def models(self) -> Sequence[subject.Models]:
        from nvcore.subjects.detectors.words import MODELS

        return (MODELS,)
