"""Detectors that are trained or run here: pictures in, boxes with scores out."""
