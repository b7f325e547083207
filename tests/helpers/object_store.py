"""A server of S3 in a process of its own, and a proxy before it that refuses and cuts requests."""

from __future__ import annotations

import http.client
import subprocess
import threading
import urllib.request
from collections.abc import Iterator
from contextlib import contextmanager
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from typing import Final
from urllib.parse import urlsplit

import pytest
from places import ROOT

SERVER: Final = ROOT / ".venv-tools" / "s3" / "bin" / "python"
"""Interpreter with an emulator of S3, installed apart because it needs other versions."""
SERVE: Final = """
from moto.server import DomainDispatcherApplication, create_backend_app
from werkzeug.serving import run_simple

# one request at a time: moto checks and writes in two steps, so conditional writes could race
run_simple("127.0.0.1", 0, DomainDispatcherApplication(create_backend_app), threaded=False)
"""


def options(url: str) -> dict[str, str]:
    """Of `nvcore.subjects.fleet.location.Location`, for a server at this address."""
    return {
        "aws_endpoint_url": url,
        "aws_access_key_id": "test",
        "aws_secret_access_key": "test",
        "aws_region": "us-east-1",
        "aws_allow_http": "true",
    }


@contextmanager
def served() -> Iterator[str]:
    """Within it, an empty S3 server answers at this address."""
    if not SERVER.exists():
        pytest.skip(f"no S3 server in {SERVER}")
    command = [SERVER, "-c", SERVE]
    with subprocess.Popen(command, stderr=subprocess.PIPE, text=True) as process:
        assert process.stderr is not None
        try:
            lines = iter(process.stderr.readline, "")
            url = next(line.split()[-1] for line in lines if "Running on" in line)
            reader = threading.Thread(target=process.stderr.read, daemon=True)
            reader.start()  # else the pipe fills
            yield url
        finally:
            process.kill()
            reader.join()


def make_bucket(url: str, name: str) -> None:
    urllib.request.urlopen(urllib.request.Request(f"{url}/{name}", method="PUT")).close()


@contextmanager
def troubled(url: str) -> Iterator[tuple[str, dict[str, int]]]:
    """Within it, a proxy of the server that refuses some requests and cuts the answers of others.

    Yields its address, and how often it did what.
    """
    done = {"passed": 0, "refused": 0, "cut": 0}
    counting = threading.Lock()
    target = urlsplit(url)

    class Handler(BaseHTTPRequestHandler):
        protocol_version = "HTTP/1.1"

        def answer(self) -> None:
            body = self.rfile.read(int(self.headers.get("content-length", 0)))
            with counting:
                n = sum(done.values())
                fate = "refused" if n % 4 == 1 else "cut" if n % 7 == 3 else "passed"
                done[fate] += 1
            if fate == "refused":
                self.send_response(503)
                self.send_header("content-length", "0")
                self.end_headers()
                return
            connection = http.client.HTTPConnection(target.hostname or "", target.port)
            connection.request(self.command, self.path, body, dict(self.headers))
            answer = connection.getresponse()
            content = answer.read()
            connection.close()
            if fate == "cut":  # it was done, and nobody learns of it
                self.close_connection = True
                return
            self.send_response_only(answer.status)
            for key, value in answer.getheaders():
                if key.lower() not in ("content-length", "connection", "transfer-encoding"):
                    self.send_header(key, value)
            length = answer.headers["content-length"] if self.command == "HEAD" else len(content)
            self.send_header("content-length", str(length))
            self.end_headers()
            self.wfile.write(content)

        do_GET = do_PUT = do_POST = do_HEAD = do_DELETE = answer  # noqa: N815

        def log_message(self, *_: object) -> None:
            pass

    with ThreadingHTTPServer(("127.0.0.1", 0), Handler) as proxy:
        thread = threading.Thread(target=proxy.serve_forever, daemon=True)
        thread.start()
        try:
            yield f"http://127.0.0.1:{proxy.server_address[1]}", done
        finally:
            proxy.shutdown()
            thread.join()
