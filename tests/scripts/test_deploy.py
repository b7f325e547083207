"""The files for operators: what they run works."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import threading
from http import HTTPStatus
from http.server import BaseHTTPRequestHandler, HTTPServer

import pytest
from places import ROOT


class Health(BaseHTTPRequestHandler):
    """Answers below one path only."""

    def do_GET(self) -> None:
        fine = self.path == self.server.path  # type: ignore[attr-defined]
        self.send_response(HTTPStatus.OK if fine else HTTPStatus.NOT_FOUND)
        self.end_headers()

    def log_message(self, *_: object) -> None:
        """Nothing."""


@pytest.mark.parametrize(
    ("base", "path", "code"),
    [
        ("", "/_stcore/health", 0),
        ("/apps/night/", "/apps/night/_stcore/health", 0),
        ("", "/elsewhere", 1),
    ],
)
def test_the_image_asks_for_its_health_where_the_app_is(base: str, path: str, code: int):
    (line,) = [
        line for line in (ROOT / "deploy" / "Dockerfile").read_text().splitlines()
        if line.startswith("HEALTHCHECK CMD ")
    ]  # fmt: skip
    _, flag, program = json.loads(line.removeprefix("HEALTHCHECK CMD "))
    with HTTPServer(("127.0.0.1", 0), Health) as server:
        server.path = path  # type: ignore[attr-defined]
        threading.Thread(target=server.serve_forever, daemon=True).start()
        done = subprocess.run(
            [sys.executable, flag, program.replace("8501", str(server.server_port))],
            env={**os.environ, "STREAMLIT_SERVER_BASE_URL_PATH": base},
            stderr=subprocess.DEVNULL,
        )
        server.shutdown()
    assert done.returncode == code
