"""Server of the app for measurements."""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
import urllib.error
import urllib.request
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from time import monotonic, sleep

from playwright.sync_api import Browser, sync_playwright

from bench.csv_files import write_csv
from bench.sets import make_set

CHROMIUM = os.environ.get("NVCORE_CHROMIUM", "/usr/bin/chromium-headless-shell")
FLAGS = (
    *("--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run"),
    *("--disable-background-networking", "--disable-component-update", "--disable-sync"),
)
ROOT = Path(__file__).resolve().parent.parent.parent


@contextmanager
def open_chromium() -> Iterator[tuple[Browser, Path]]:
    """Open the browser, and yield it with a folder for its data."""
    with sync_playwright() as playwright, tempfile.TemporaryDirectory() as parent:
        browser = playwright.chromium.launch(executable_path=CHROMIUM, args=list(FLAGS))
        yield browser, Path(parent)
        browser.close()


def folder_of_set(parent: Path, n: int, *, one_recording: bool = False) -> Path:
    """Create a folder with a set of `n` frames, or an empty one for 0, the sample."""
    folder = parent / str(n)
    folder.mkdir()
    if n:
        write_csv(make_set(n), folder, one_recording=one_recording)
    return folder


@contextmanager
def serve(folder: Path, port: int, *, script: Path | None = None) -> Iterator[tuple[str, int]]:
    """Serve the app or another script on a folder, and yield address and process."""
    command = [sys.executable, "-m", "streamlit", "run", str(script or ROOT / "app.py")]
    command += [f"--server.port={port}", "--server.address=127.0.0.1", "--server.headless=true"]
    command += ["--", "--local-root", str(folder)]
    server = subprocess.Popen(
        command,
        cwd=ROOT,
        env={**os.environ, "PYTHONPATH": str(ROOT)},
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
    )
    url = f"http://127.0.0.1:{port}"
    try:
        _wait_for(url, server)
        yield url, server.pid
    finally:
        server.terminate()
        server.wait(20)


def _wait_for(url: str, server: subprocess.Popen[bytes]) -> None:
    end = monotonic() + 60
    while monotonic() < end and server.poll() is None:
        try:
            with urllib.request.urlopen(f"{url}/_stcore/health", timeout=1):
                return
        except (urllib.error.URLError, TimeoutError, ConnectionError):
            sleep(0.1)
    sys.exit(f"the app did not start at {url}")
