"""CVAT XML 1.1, the annotation tool's own format: for video and for images."""

from __future__ import annotations

from nvcore.readers import cvat_images, cvat_video

FORMATS = (cvat_video.FORMAT, cvat_images.FORMAT)
