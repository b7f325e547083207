"""Boxes of a result drawn on pictures: one frame, or a video."""

from nvcore.overlay.annotate import annotated_frame, frame_png
from nvcore.overlay.draw import DrawnBoxes, draw_boxes
from nvcore.overlay.video import FPS_RANGE, write_video

__all__ = [
    "FPS_RANGE",
    "DrawnBoxes",
    "annotated_frame",
    "draw_boxes",
    "frame_png",
    "write_video",
]
