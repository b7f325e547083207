"""Pictures of the recordings: reading and stretching them, safely.

    pictures = open_pictures(Path("drive.mp4"))
    index = map_frames(frames, pictures).index        which picture shows which frame
    jpeg(pictures.read(int(index[212])), lo=1, hi=99)

Whatever comes from files is checked before it is decoded: sizes, archives, container formats.
"""

from nvcore.common.extras import needs
from nvcore.common.file_kinds import IMAGE_SUFFIXES

with needs("report", "pictures need"):
    from nvcore.pictures.archive import Archive, ArchiveLimits
    from nvcore.pictures.base import Picture, Pictures
    from nvcore.pictures.index import map_frames, size_note
    from nvcore.pictures.open import is_below, open_pictures
    from nvcore.pictures.recordings import RecordingPictures, session_pictures
    from nvcore.pictures.stretch import jpeg, picture_address, png, stretch

__all__ = [
    "IMAGE_SUFFIXES",
    "Archive",
    "ArchiveLimits",
    "Picture",
    "Pictures",
    "RecordingPictures",
    "is_below",
    "jpeg",
    "map_frames",
    "open_pictures",
    "picture_address",
    "png",
    "session_pictures",
    "size_note",
    "stretch",
]
