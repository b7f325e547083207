"""Crops of cases: a pedestrian with surroundings, and the boxes of truth, X and Y.

GET /nv/TOKEN/crop/RECORDING/ROW.jpg?box=X,Y,W,H&lo=&hi=&v=
"""

from __future__ import annotations

from http import HTTPStatus
from typing import Final

import numpy as np
from anyio.to_thread import run_sync
from starlette.requests import Request
from starlette.responses import Response

from nvcore.comparison.compare import Result
from nvcore.figures.overlay.annotate import drawn_boxes, frame_picture, inks_of
from nvcore.figures.overlay.draw import draw_boxes
from nvcore.pictures.base import PictureReader
from ui.session.address import finite_number
from ui.session.routes import (
    CACHED,
    NO_FRAME,
    NO_PERCENTILES,
    NOT_CACHED,
    NOT_COMPARED,
    Place,
    for_owner,
    frames_from,
    index_in,
    not_found,
    percentiles,
    say,
)
from ui.session.workspace import Workspace
from ui.widgets.drawing import cut_scaled, small_jpeg

CROP_PX: Final = 320
"""Largest width of a crop, twice that on the page."""
MOST_PX: Final = 1e6


@for_owner
async def crop(request: Request, space: Workspace) -> Response:
    """Send the part of a frame around a box. Without a picture, the boxes are on a blank area."""
    if (compared := space.compared) is None:
        return not_found(NOT_COMPARED)
    result, recording = compared.result, index_in(request, "recording")
    frames = frames_from(request, result, index_in(request, "row"))
    if not frames:
        return not_found(NO_FRAME)
    box = [finite_number(text) for text in request.query_params.get("box", "").split(",")]
    if len(box) != 4 or any(side is None or abs(side) > MOST_PX for side in box):
        return say(HTTPStatus.BAD_REQUEST, "box: expected x,y,w,h in pixels")
    if (ends := percentiles(request)) is None:
        return say(HTTPStatus.BAD_REQUEST, NO_PERCENTILES)
    row = index_in(request, "row")
    rows = space.pictures.indices.get(recording)
    pictures = space.pictures.sources.get(recording)
    index = -1 if rows is None else int(rows[row])
    xywh = np.array(box, np.float64)
    content = await run_sync(
        lambda: draw_crop(result, frames.start, xywh, pictures, index, ends),
        limiter=space.picture_turns,
    )
    headers = CACHED if request.query_params.get("v") == version_of(space) else NOT_CACHED
    return Response(content, media_type="image/jpeg", headers=headers)


def version_of(space: Workspace) -> str:
    """Return the version of boxes and pictures, for addresses that browsers may cache."""
    return f"{space.version}-{space.pictures_version}"


def draw_crop(
    result: Result,
    row: int,
    xywh: np.ndarray,
    pictures: PictureReader | None,
    index: int,
    ends: tuple[float, float],
) -> bytes:
    """Draw the part of a frame around a box (px), and encode it as JPEG.

    Parameters
    ----------
    row
        Row of the frames table.
    index
        Index of the frame's picture. -1: none.
    ends
        Percentiles between which greys are stretched.
    """
    frames = result.dataset.frame_columns
    recording = int(frames.recording[row])
    picture, _ = frame_picture(pictures, index, *ends)
    size = float(frames.width[recording]), float(frames.height[recording])
    boxes = drawn_boxes(result, row)._asdict()
    drawn = draw_boxes(picture, *size, **boxes, inks=inks_of(result, "dark"))
    return small_jpeg(cut_scaled(result, recording, drawn, xywh), CROP_PX)


ROUTES: Final = (Place("crop/{recording}/{row}.jpg", crop),)
