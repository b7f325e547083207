"""Drawing of a result's boxes on pictures: one frame, or a video."""

from nvcore.extras import needs

with needs("report", "drawn pictures need"):
    from nvcore.overlay.annotate import annotate, frame_png
    from nvcore.overlay.draw import DrawnDetections, DrawnTruth, TruthMark, draw_boxes
    from nvcore.overlay.video import FPS_RANGE, write_video

__all__ = [
    "FPS_RANGE",
    "DrawnDetections",
    "DrawnTruth",
    "TruthMark",
    "annotate",
    "draw_boxes",
    "frame_png",
    "write_video",
]
