"""Drawing of a result's boxes on pictures: one frame, or a video."""

from nvcore.common.extras import needs

with needs("report", "drawn pictures need"):
    from nvcore.figures.overlay.annotate import annotate, frame_png
    from nvcore.figures.overlay.draw import DrawnDetections, DrawnTruth, TruthMark, draw_boxes
    from nvcore.figures.overlay.video import FPS_RANGE, write_video

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
