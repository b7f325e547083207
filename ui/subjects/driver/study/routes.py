"""Routes from which a participant's browser fetches pictures, and to which it sends answers.

They work only while the session's page has a study on the screen, and for its participant alone.

    GET /nv/TOKEN/study/PICTURE/VIEW.png    a picture (by index, or practice-0): full or coarse
    PUT /nv/TOKEN/study/PLACE/shown         the picture of a trial appears
    PUT /nv/TOKEN/study/PLACE/answer        its answer

The browser sends JSON that names its owner. After 400 or 413 it gives up, as a retry cannot help.
After any other failure it keeps the content and retries, even with the next session.
"""

from __future__ import annotations

import logging
from http import HTTPStatus
from typing import Final

from anyio.to_thread import run_sync
from starlette.concurrency import run_in_threadpool
from starlette.requests import ClientDisconnect, Request
from starlette.responses import Response

from nvcore.common.errors import InputError, StoreError
from ui.session.routes import NOT_CACHED, Place, for_owner, index_in, not_found, say
from ui.session.workspace import Workspace
from ui.subjects.driver.study.on_screen import MOST_BYTES, OnScreen
from ui.subjects.people.studies import ON_SCREEN

ENDED: Final = "the page has ended; load it again"
_LOG = logging.getLogger("nvcore.ui")


@for_owner
async def study_picture(request: Request, space: Workspace) -> Response:
    """Answer with a picture of the study, or its coarse version."""
    screen: OnScreen | None = space.notes.get(ON_SCREEN)
    name, view = request.path_params["picture"], request.path_params["view"]
    if screen is None or view not in ("full", "coarse"):
        return not_found(ENDED)
    try:
        content = await run_sync(lambda: screen.picture(name, view), limiter=space.picture_turns)
    except InputError as error:
        return not_found(str(error))
    return Response(content, media_type="image/png", headers=NOT_CACHED)


@for_owner
async def study_answer(request: Request, space: Workspace) -> Response:
    """Store the report that a picture appeared, or its answer. Success means that it is on disk."""
    screen: OnScreen | None = space.notes.get(ON_SCREEN)
    kind, place = request.path_params["kind"], index_in(request, "place")
    if screen is None or kind not in ("shown", "answer"):
        return not_found(ENDED)
    content = bytearray()
    try:
        async for chunk in request.stream():
            content += chunk
            if len(content) > MOST_BYTES:
                return say(HTTPStatus.REQUEST_ENTITY_TOO_LARGE, "this is no answer")
        if not await run_in_threadpool(screen.keep, place, kind, bytes(content)):
            return not_found(ENDED)
    except ClientDisconnect:
        return say(HTTPStatus.BAD_REQUEST, "the answer broke off")
    except StoreError as error:
        _LOG.warning("An answer of a study waits in its browser: %s", error)
        return say(HTTPStatus.SERVICE_UNAVAILABLE, str(error))
    except InputError as error:
        return say(HTTPStatus.BAD_REQUEST, str(error))
    return Response(status_code=HTTPStatus.NO_CONTENT, headers=NOT_CACHED)


ROUTES: Final = (
    Place("study/{picture}/{view}.png", study_picture),
    Place("study/{place}/{kind}", study_answer, "PUT"),
)
