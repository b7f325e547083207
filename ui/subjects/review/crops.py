"""Route of crops: a pedestrian with surroundings, and the boxes of truth, X and Y.

Its address is ``/nv/TOKEN/crop/RECORDING/ROW.jpg?box=X,Y,W,H&lo=&hi=&v=``.
"""

from __future__ import annotations

from http import HTTPStatus
from typing import Final

import cv2
import numpy as np
from anyio.to_thread import run_sync
from starlette.requests import Request
from starlette.responses import Response

from nvcore.figures.overlay.annotate import drawn_boxes, frame_picture, inks_of
from nvcore.figures.overlay.draw import draw_boxes
from ui.session import routes
from ui.session.address import finite_number
from ui.session.workspace import Workspace
from ui.widgets.drawing import cut_scaled, small_jpeg

CROP_PX: Final = 320
"""Largest width of a crop, twice that on the page."""
MOST_PX: Final = 1e6
ARROW_SHARE: Final = 0.008
"""Half the width of the arrowhead above the case's box, as a share of the picture's width."""


@routes.for_owner
async def crop(request: Request, space: Workspace) -> Response:
    """Send the part of a frame around a box. Without a picture, the boxes are on a blank area."""
    if (compared := space.compared) is None:
        return routes.not_found(routes.NOT_COMPARED)
    result = compared.result
    recording, row = (routes.index_in(request, name) for name in ("recording", "row"))
    rows = routes.frames_from(request, result, row)
    if not rows:
        return routes.not_found(routes.NO_FRAME)
    box = [finite_number(text) for text in request.query_params.get("box", "").split(",")]
    if len(box) != 4 or any(side is None or abs(side) > MOST_PX for side in box):
        return routes.say(HTTPStatus.BAD_REQUEST, "box: expected x,y,w,h in pixels")
    if (ends := routes.percentiles(request)) is None:
        return routes.say(HTTPStatus.BAD_REQUEST, routes.NO_PERCENTILES)
    indices, pictures = space.pictures.indices.get(recording), space.pictures.sources.get(recording)
    index = -1 if indices is None else int(indices[row])
    frames, xywh = result.dataset.frame_columns, np.array(box, np.float64)

    def draw() -> bytes:
        picture, _ = frame_picture(pictures, index, *ends)
        size = float(frames.width[recording]), float(frames.height[recording])
        boxes = drawn_boxes(result, rows.start)._asdict()
        drawn = draw_boxes(picture, *size, **boxes, inks=inks_of(result, "dark"))
        _point_at(drawn, xywh * np.tile(drawn.shape[1::-1], 2) / np.tile(size, 2))
        return small_jpeg(cut_scaled(result, recording, drawn, xywh), CROP_PX)

    content = await run_sync(draw, limiter=space.picture_turns)
    is_newest = request.query_params.get("v") == version_of(space)
    headers = routes.CACHED if is_newest else routes.NOT_CACHED
    return Response(content, media_type="image/jpeg", headers=headers)


def _point_at(drawn: np.ndarray, xywh: np.ndarray) -> None:
    """Draw a white arrowhead above a box (px of the drawing), which may be one of many."""
    x, y, w, _ = xywh
    half = ARROW_SHARE * drawn.shape[1]
    top = max(y - 3 * half, 0)
    corners = [(x + w / 2 - half, top), (x + w / 2 + half, top), (x + w / 2, top + 1.5 * half)]
    cv2.fillConvexPoly(drawn, np.round(corners).astype(np.int32), (255, 255, 255), cv2.LINE_AA)


def version_of(space: Workspace) -> str:
    """Return the version of boxes and pictures, for addresses that browsers may cache."""
    return f"{space.version}-{space.pictures_version}"


ROUTES: Final = (routes.Place("crop/{recording}/{row}.jpg", crop),)
