"""The files for operators: what they run works."""

from __future__ import annotations

import json
import os
import re
import subprocess
import sys
import threading
from http import HTTPStatus
from http.server import BaseHTTPRequestHandler, HTTPServer

import pytest
import yaml
from places import ROOT

from scripts.dashboard_in_wheel import PARTS


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


def test_the_compose_file_passes_settings_that_the_page_on_hosting_explains():
    compose = yaml.safe_load((ROOT / "deploy" / "compose.yaml").read_text(encoding="utf-8"))
    passed = set(compose["services"]["app"]["environment"])
    page = (ROOT / "docs" / "hosting.md").read_text(encoding="utf-8")
    assert {"NVCORE_MAX_VISITORS", "STREAMLIT_SERVER_ALLOWED_HOSTS"} <= passed
    rows = "\n".join(re.findall(r"^\| `.*?`(?=[ ,])[^|]*", page, re.MULTILINE))
    assert passed <= set(re.findall(r"`([A-Z_]+)`", rows))


def test_the_state_of_the_image_is_on_a_volume():
    compose = yaml.safe_load((ROOT / "deploy" / "compose.yaml").read_text(encoding="utf-8"))
    image = (ROOT / "deploy" / "Dockerfile").read_text(encoding="utf-8")
    kept = re.findall(r"NVCORE_(?:RATINGS|STUDIES|UPLOAD_DIR)=(/\w+)/", image)
    assert len(kept) == 3
    assert set(kept) == {volume.split(":")[1] for volume in compose["services"]["app"]["volumes"]}


def test_the_image_has_every_part_of_the_dashboard():
    lines = (ROOT / ".dockerignore").read_text(encoding="utf-8").splitlines()
    sent = [line[1:] for line in lines if line.startswith("!")]
    assert [part for part in PARTS if part not in sent] == []
