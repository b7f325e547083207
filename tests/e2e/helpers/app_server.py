"""Starts a Streamlit server on a free port and ends it; finds the browser that visits it."""

from __future__ import annotations

import os
import socket
import subprocess
import sys
import time
import urllib.error
import urllib.request
from collections.abc import Iterator
from contextlib import contextmanager, nullcontext
from pathlib import Path

import pytest
from playwright.sync_api import BrowserContext, expect, sync_playwright

HELPERS = Path(__file__).resolve().parent
ROOT = HELPERS.parents[2]
START_S = 300
END_S = 30
# Limits for what hangs, not for what is slow: on a busy machine a cold page takes minutes.
PATIENCE_MS = 300_000
CHROMIUM = Path(os.environ.get("NVCORE_CHROMIUM", "/usr/bin/chromium-headless-shell"))
FLAGS = (
    *("--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run", "--disable-sync"),
    *("--disable-background-networking", "--disable-component-update"),
    # a page lives for seconds here: compiling its scripts for speed costs more than it saves
    "--js-flags=--no-maglev,--no-turbofan,--single-threaded-gc",
    # compiled scripts are kept after the first load, not only after the second
    "--blink-settings=v8CacheOptions=3",
)
# While Chromium fetches in the background it compiles every script anew, for seconds per page, also
# where it has kept the compiled code. The others are Playwright's own, whose list this replaces.
FEATURES_OFF = (
    "BackgroundResourceFetch",
    *("AvoidUnnecessaryBeforeUnloadCheckSync", "DestroyProfileOnBrowserClose", "HttpsUpgrades"),
    *("MediaRouter", "NetworkTimeServiceQuerying", "OptimizationHints", "PaintHolding"),
)

expect.set_options(timeout=PATIENCE_MS)


@contextmanager
def serve(script: Path, *, base: str = "", port: int | None = None) -> Iterator[str]:
    """The address of a server that runs this script from the project's folder.

    Parameters
    ----------
    base
        Path below which the app is served (``server.baseUrlPath``).
    port
        One of `held_port`; None: any.
    """
    command = [sys.executable, "-m", "streamlit", "run", str(script), "--server.headless=true"]
    command += ["--browser.gatherUsageStats=false", "--server.address=127.0.0.1"]
    environment = {**os.environ, "PYTHONPATH": str(ROOT)}
    command += [f"--server.baseUrlPath={base}"] if base else []
    command += ["--server.port"]
    with serving(command, cwd=ROOT, environment=environment, base=base, port=port) as (url, _):
        yield url


@contextmanager
def serving(
    command: list[str],
    *,
    cwd: Path,
    environment: dict[str, str],
    base: str = "",
    port: int | None = None,
) -> Iterator[tuple[str, subprocess.Popen[bytes]]]:
    """Address and process of a server, once it answers.

    Parameters
    ----------
    command
        Starts it; the port is put at its end.
    port
        One of `held_port`; None: any.
    """
    with held_port() if port is None else nullcontext(port) as number:
        # what the server logs as an error is shown with the test that failed
        server = subprocess.Popen(
            [*command, str(number)], cwd=cwd, env=environment, stdout=subprocess.DEVNULL
        )
        url = f"http://127.0.0.1:{number}{'/' + base if base else ''}"
        try:
            _wait_for(url, server)
            yield url, server
        finally:
            server.terminate()
            try:
                server.wait(END_S)
            except subprocess.TimeoutExpired:
                server.kill()
                server.wait()


@contextmanager
def held_port() -> Iterator[int]:
    """A port that only a server is given: nobody who asks for any port, nor a connection."""
    with socket.socket() as held:
        held.bind(("127.0.0.1", 0))
        # from now on a server, which asks for the same, may listen on it
        held.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        port: int = held.getsockname()[1]
        yield port


def _wait_for(url: str, server: subprocess.Popen[bytes]) -> None:
    deadline = time.monotonic() + START_S
    while time.monotonic() < deadline and server.poll() is None:
        try:
            with urllib.request.urlopen(f"{url}/_stcore/health", timeout=1):
                return
        except (urllib.error.URLError, TimeoutError, ConnectionError):
            time.sleep(0.1)
    raise AssertionError("the server did not start")


# A run begins some time after the click that asks for it, and Streamlit says nothing in between.
# Both are messages of protobuf: 11 of BackMsg asks for a run, 4 of ForwardMsg begins one. Runs that
# a fragment asks for by itself (6 of ClientState) are not counted: some never begin.
COUNT_RUNS = """
  window.nvAsked = window.nvBegun = 0;
  const part = (bytes, field) => {
    let at = 0;
    const number = () => {
      let value = 0, factor = 1, byte;
      do {
        byte = bytes[at++];
        value += (byte & 127) * factor;
        factor *= 128;
      } while (byte > 127);
      return value;
    };
    while (at < bytes.length) {
      const tag = number(), kind = tag & 7;
      if (kind !== 0 && kind !== 2) return null;
      const length = number(), content = bytes.subarray(at, at + length);
      if (tag >> 3 === field) return content;
      if (kind === 2) at += length;
    }
    return null;
  };
  window.WebSocket = class extends WebSocket {
    constructor(...address) {
      super(...address);
      this.addEventListener("message", ({ data }) => {
        if (data instanceof ArrayBuffer && part(new Uint8Array(data), 4)) {
          window.nvBegun = window.nvAsked;
        }
      });
    }
    send(data) {
      const asks = data instanceof Uint8Array && part(data, 11);
      if (asks && !part(asks, 6)) window.nvAsked += 1;
      super.send(data);
    }
  };
"""


@contextmanager
def open_chromium() -> Iterator[BrowserContext]:
    """The browser of the machine with a profile of its own, which keeps scripts as compiled.

    A test that needs it fails where it is missing.
    """
    if not CHROMIUM.exists():
        pytest.fail(f"{CHROMIUM} is missing: install it, or set NVCORE_CHROMIUM", pytrace=False)
    flags = [*FLAGS, f"--disable-features={','.join(FEATURES_OFF)}"]
    with sync_playwright() as playwright:
        chromium = playwright.chromium.launch_persistent_context(
            "", executable_path=str(CHROMIUM), args=flags
        )
        chromium.set_default_timeout(PATIENCE_MS)
        chromium.add_init_script(COUNT_RUNS)
        try:
            yield chromium
        finally:
            chromium.close()
