"""Detectors that are trained or run here: pictures in, boxes with scores out."""

from nvcore.detectors.base import About, Detections, Detector, TrainedOn

__all__ = ["About", "Detections", "Detector", "TrainedOn"]
