"""HTTP routes for what the page does not carry: frames, boxes, uploads of pictures.

Routes run outside the session. An address without the token of a living session is answered with
"not found". If people log in, the token of another person's session is refused. No address holds a
path of the machine. All routes lie below the app's base path (``server.baseUrlPath``), if any.

    GET /overview                                    the page that the app opens on
    GET /nv/TOKEN/frame/RECORDING/ROW.jpg?lo=&hi=    picture of a row of a recording
    GET /nv/TOKEN/visible/RECORDING/ROW.jpg?seen_s=  visible-light picture as adapting eyes see it
    GET /nv/TOKEN/boxes/RECORDING/CHUNK?v=           boxes of 1024 rows (`pack_boxes`)
    GET /nv/TOKEN/comparison?v=                      columns for comparing X and Y in the browser
    GET /nv/TOKEN/reasons/RECORDING/ROW              how each box of a row counts, its cost, and why
    PUT /nv/TOKEN/upload/pictures?name=              one file of pictures, or a video

The packages of the subjects contribute further routes.
"""

from __future__ import annotations

import math
from collections.abc import Awaitable, Callable
from dataclasses import asdict, dataclass
from functools import wraps
from http import HTTPStatus
from itertools import chain
from pathlib import Path
from typing import Final

import plotly
from anyio.to_thread import run_sync
from starlette.concurrency import run_in_threadpool
from starlette.requests import Request
from starlette.responses import FileResponse, JSONResponse, RedirectResponse, Response
from starlette.routing import Route

from nvcore.common.errors import MediaError
from nvcore.comparison.compare import Result
from nvcore.figures.overlay.explain import explain_boxes
from nvcore.pictures.base import Picture
from nvcore.pictures.recordings import RecordingPictures
from nvcore.pictures.stretch import jpeg, stretch
from ui.access.people import is_same, key_of
from ui.responses import PRIVATE, text_answer
from ui.session.address import finite_number
from ui.session.packed_comparison import can_pack, pack_boxes, pack_comparison, version_of
from ui.session.uploads import UploadError, receive
from ui.session.workspace import PICTURES, Workspace, workspace_of
from ui.settings.start import base_path
from ui.subject import all_sights, subject_pages

Answer = Callable[[Request], Awaitable[Response]]
Handler = Callable[[Request, Workspace], Awaitable[Response]]
MOST_DIGITS: Final = 12
_GUARDS: Final = {
    "X-Content-Type-Options": "nosniff",
    "Cross-Origin-Resource-Policy": "same-origin",
    "Referrer-Policy": "no-referrer",
}
CACHED: Final = {"Cache-Control": "private, max-age=3600", **_GUARDS}
NOT_CACHED: Final = {**PRIVATE, **_GUARDS}
ROWS_PER_CHUNK: Final = 1024
QUALITY: Final = 85
NOT_COMPARED: Final = "nothing is compared yet"
NO_FRAME: Final = "there is no such recording or frame"
NO_PERCENTILES: Final = "lo and hi: expected 0 <= lo < hi <= 100"
PLOTLY: Final = f"/nv/plotly-{plotly.__version__}.js"
"""Address of Plotly, which draws the figures."""


@dataclass(frozen=True)
class Place:
    """A route below the address of a session, and its handler.

    Attributes
    ----------
    path
        Path in Starlette's syntax, such as ``"frame/{recording}/{row}.jpg"``.
    """

    path: str
    answer: Answer
    method: str = "GET"


def index_in(request: Request, name: str) -> int:
    """Return a path parameter as an index from 0. Anything else becomes an index out of range."""
    text = request.path_params[name]
    is_index = text.isascii() and text.isdigit() and len(text) < MOST_DIGITS
    return int(text) if is_index else 10**MOST_DIGITS


def for_owner(handle: Handler) -> Answer:
    """Restrict a route to a workspace's owner, and answer 404 once the session has ended."""

    @wraps(handle)
    async def route(request: Request) -> Response:
        space, key = workspace_of(request.path_params["token"]), key_of(request.cookies)
        if key is None or (space is not None and not is_same(space.owner, key)):
            return say(HTTPStatus.FORBIDDEN, "log in as the one whose session this is")
        if space is None:
            return not_found("the session has ended; load the page again")
        return await handle(request, space)

    return route


def say(status: int, text: str) -> Response:
    """Return a plain-text answer."""
    return text_answer(status, text, NOT_CACHED)


def not_found(text: str) -> Response:
    """Return a 404 answer with the reason."""
    return say(HTTPStatus.NOT_FOUND, text)


@for_owner
async def frame(request: Request, space: Workspace) -> Response:
    """Send the picture of a recording's row, its grey values stretched between two percentiles."""
    ends = percentiles(request)
    if ends is None:
        return say(HTTPStatus.BAD_REQUEST, NO_PERCENTILES)
    return await _picture(request, space, space.pictures, lambda read: stretch(read, *ends))


@for_owner
async def visible(request: Request, space: Workspace) -> Response:
    """Send the visible-light picture of a row, as eyes see it `seen_s` after a change of light."""
    seen_s = _number(request, "seen_s", math.inf)
    if seen_s is None or seen_s < 0:
        return say(HTTPStatus.BAD_REQUEST, "seen_s: expected seconds, 0 or more")

    def show(read: Picture) -> Picture:
        picture = stretch(read)
        for sight in all_sights():
            picture = sight.show(picture, seen_s)
        return picture

    return await _picture(request, space, space.visible, show)


async def _picture(
    request: Request, space: Workspace, own: RecordingPictures, show: Callable[[Picture], Picture]
) -> Response:
    """Send the picture of a recording's row as JPEG."""
    recording, row = index_in(request, "recording"), index_in(request, "row")
    rows, pictures = own.indices.get(recording), own.sources.get(recording)
    if rows is None or pictures is None or row >= len(rows) or rows[row] < 0:
        return not_found("no picture for this frame")
    index = int(rows[row])
    try:
        content = await run_sync(
            lambda: jpeg(show(pictures.read(index)), quality=QUALITY), limiter=space.picture_turns
        )
    except MediaError as error:
        return not_found(error.message)
    return Response(content, media_type="image/jpeg", headers=CACHED)


@for_owner
async def boxes(request: Request, space: Workspace) -> Response:
    """Send the boxes of a chunk of a recording's rows, encoded by `pack_boxes`."""
    if (compared := space.compared) is None:
        return not_found(NOT_COMPARED)
    result, first_row = compared.result, index_in(request, "chunk") * ROWS_PER_CHUNK
    frames = frames_from(request, result, first_row)
    if not frames:
        return not_found(NO_FRAME)
    # the result may be newer than the version in the address: show it, but don't let it be cached
    headers = CACHED if request.query_params.get("v") == compared.version else NOT_CACHED
    content = await run_in_threadpool(
        pack_boxes, result, frames.start, frames[:ROWS_PER_CHUNK].stop
    )
    return Response(content, media_type="application/octet-stream", headers=headers)


@for_owner
async def comparison(request: Request, space: Workspace) -> Response:
    """Send the columns of `pack_comparison`, with which the browser follows a slider."""
    compared, version = space.compared, request.query_params.get("v")
    if compared is None or not can_pack(compared.result) or version != version_of(compared.result):
        # another comparison is open or being opened, and the page will report its version
        return Response(status_code=HTTPStatus.NO_CONTENT, headers=NOT_CACHED)
    content = await run_in_threadpool(pack_comparison, compared.result)
    return Response(content, media_type="application/octet-stream", headers=CACHED)


@for_owner
async def reasons(request: Request, space: Workspace) -> Response:
    """Send how each box of a row counts and why, and its cost, with the newest settings."""
    if (compared := space.compared) is None:
        return not_found(NOT_COMPARED)
    frames = frames_from(request, compared.result, index_in(request, "row"))
    if not frames:
        return not_found(NO_FRAME)
    boxes = await run_in_threadpool(explain_boxes, compared.result, frames.start)
    return JSONResponse([asdict(box) for box in boxes], headers=NOT_CACHED)


def frames_from(request: Request, result: Result, row: int) -> range:
    """Return the rows of the frames table from a row of the recording to its end, maybe none."""
    recording, first = index_in(request, "recording"), result.dataset.frame_columns.first
    if recording >= len(first) - 1:
        return range(0)
    return range(int(first[recording]) + row, int(first[recording + 1]))


@for_owner
async def upload(request: Request, space: Workspace) -> Response:
    """Receive one picture file or video into the session's folder as a stream."""
    stated = request.headers.get("content-length", "")
    n_bytes = int(stated) if stated.isascii() and stated.isdigit() and len(stated) < 19 else None
    try:
        stored = await receive(
            space, request.query_params.get("name", ""), request.stream(), n_bytes=n_bytes
        )
    except UploadError as error:
        return say(error.status, str(error))
    return JSONResponse(
        {"name": stored.name, "kind": stored.kind, "bytes": stored.n_bytes},
        status_code=HTTPStatus.CREATED,
        headers=NOT_CACHED,
    )


async def overview(request: Request) -> Response:
    """Redirect /overview to ``/``, the only address under which Streamlit knows the first page."""
    query = request.scope["query_string"].decode("utf-8", "replace")
    # relative, so that it works below any path
    return RedirectResponse(f"./{'?' if query else ''}{query}", headers=NOT_CACHED)


async def drawing_library(_request: Request) -> Response:
    """Send Plotly's JavaScript in the version that made the figures."""
    path = Path(plotly.__file__).parent / "package_data" / "plotly.min.js"
    headers = {"Cache-Control": "public, max-age=31536000, immutable"}
    return FileResponse(path, media_type="text/javascript", headers=headers)


OWN: Final = (
    Place("frame/{recording}/{row}.jpg", frame),
    Place("visible/{recording}/{row}.jpg", visible),
    Place("boxes/{recording}/{chunk}", boxes),
    Place("comparison", comparison),
    Place("reasons/{recording}/{row}", reasons),
    Place(f"upload/{PICTURES}", upload, "PUT"),
)


def routes_below(start: str) -> list[Route]:
    """Return all routes, below a base path as from `base_path`.

    ``st.App(routes=...)`` does not add the base path by itself.
    """
    places = chain(OWN, *(subject.routes() for subject in subject_pages()))
    return [
        Route(f"{start}/overview", overview, methods=["GET"]),
        Route(f"{start}{PLOTLY}", drawing_library, methods=["GET"]),
        *(
            Route(f"{start}/nv/{{token}}/{place.path}", place.answer, methods=[place.method])
            for place in places
        ),
    ]


def address(space: Workspace) -> str:
    """Return the common prefix of the addresses of a workspace's routes."""
    return f"{base_path()}/nv/{space.token}"


def percentiles(request: Request) -> tuple[float, float] | None:
    """Return the percentiles between which greys are stretched, or None if they are malformed."""
    lo, hi = _number(request, "lo", 0.0), _number(request, "hi", 100.0)
    return None if lo is None or hi is None or not 0 <= lo < hi <= 100 else (lo, hi)


def _number(request: Request, name: str, default: float) -> float | None:
    """Return a finite query parameter, `default` if it is missing, None if it is malformed."""
    text = request.query_params.get(name)
    return default if text is None else finite_number(text)
