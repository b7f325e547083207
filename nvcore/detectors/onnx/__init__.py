"""A network of one's own in ONNX, run by ONNX Runtime: layouts of the common families."""

from nvcore.detectors.onnx.detector import open_onnx

__all__ = ["open_onnx"]
