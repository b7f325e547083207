"""Server with the viewer alone: `streamlit run tests/e2e/helpers/viewer_app.py`."""

from __future__ import annotations

import gc
import threading
import time
from pathlib import Path

import streamlit as st
import viewer_scene as scene
from starlette.requests import Request
from starlette.responses import JSONResponse, Response
from starlette.routing import Route

TOKEN = "token-of-the-test"
CHUNK = 1024
SLOW = 4  # the recording whose pictures are slow, one after the other
DECODER = threading.Lock()


def answer_frame(request: Request) -> Response:
    row = request.path_params["row"]
    is_known = request.path_params["token"] == TOKEN and 0 <= row < scene.FIRST_WITHOUT_PICTURE
    if not is_known or row == scene.LOST_PICTURE:
        return Response("no picture for this frame", status_code=404, media_type="text/plain")
    if request.path_params["recording"] == SLOW:
        with DECODER:
            time.sleep(scene.SLOW_S)
    return Response(
        scene.jpeg_of(row),
        media_type="image/jpeg",
        headers={"Cache-Control": "private, max-age=3600"},
    )


def answer_visible(request: Request) -> Response:
    is_driver = "seen_s" in request.query_params
    return Response(scene.visible_jpeg(is_driver=is_driver), media_type="image/jpeg")


def answer_boxes(request: Request) -> Response:
    if request.path_params["token"] != TOKEN:
        text = "the session has ended; load the page again"
        return Response(text, status_code=404, media_type="text/plain")
    start = request.path_params["chunk"] * CHUNK
    rows = range(start, min(start + CHUNK, scene.N_LONG))
    return Response(scene.pack_rows(rows), media_type="application/octet-stream")


def answer_reasons(request: Request) -> Response:
    boxes = scene.boxes_of(request.path_params["row"])
    return JSONResponse([scene.reason_of(box) for box in boxes])


gc.freeze()  # as app.py does
app = st.App(
    Path(__file__).with_name("viewer_page.py"),
    routes=[
        Route("/nv/{token}/frame/{recording:int}/{row:int}.jpg", answer_frame),
        Route("/nv/{token}/visible/{recording:int}/{row:int}.jpg", answer_visible),
        Route("/nv/{token}/boxes/{recording:int}/{chunk:int}", answer_boxes),
        Route("/nv/{token}/reasons/{recording:int}/{row:int}", answer_reasons),
    ],
)
