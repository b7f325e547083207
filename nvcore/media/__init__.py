"""Pictures of the recordings: reading, stretching, drawing boxes on them, annotated videos.

    pictures = open_pictures(Path("drive.mp4"))
    index, note = picture_index(frames, pictures)     which picture shows which frame
    jpeg(pictures.read(int(index[212])), lo=1, hi=99)

Whatever comes from files is checked before it is decoded: sizes, archives, container formats.
"""

from nvcore.media.annotate import annotated_frame, frame_png
from nvcore.media.archive import Archive, ArchiveLimits
from nvcore.media.base import Picture, Pictures
from nvcore.media.draw import DrawnBoxes, draw_boxes
from nvcore.media.export_video import FPS_RANGE, write_video
from nvcore.media.image_header import IMAGE_SUFFIXES
from nvcore.media.index import picture_index, size_note
from nvcore.media.sources import is_below, open_pictures
from nvcore.media.stretch import jpeg, png, stretch

__all__ = [
    "FPS_RANGE",
    "IMAGE_SUFFIXES",
    "Archive",
    "ArchiveLimits",
    "DrawnBoxes",
    "Picture",
    "Pictures",
    "annotated_frame",
    "draw_boxes",
    "frame_png",
    "is_below",
    "jpeg",
    "open_pictures",
    "picture_index",
    "png",
    "size_note",
    "stretch",
    "write_video",
]
