"""Custom ONNX networks, run by ONNX Runtime, with the output layouts of common families."""

from nvcore.subjects.detectors.onnx.detector import open_onnx

__all__ = ["open_onnx"]
