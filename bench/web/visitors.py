"""Measure many simultaneous visitors: wait for the first page and for each move of alpha.

    python -m bench.web.visitors [--visitors 10] [--minutes 10] [--pause 4.5] [--port 8651]

The module starts the app on its sample, waits until it is healthy, and opens the page for one
visitor alone, then for all at once. The visitors speak the protocol of Streamlit's own page over a
WebSocket, so that no browser shares the cores with the server. Each moves the slider of alpha on
the Overview every `--pause` seconds, to values in its own order. A move ends when the server
reports that the page is complete. Each page must equal the first one for its alpha, whoever asks.

One line of JSON is printed: seconds of the first pages, percentiles of the moves over the whole
time and for each tenth, memory (PSS of the server and its children) over time and after all
visitors have left.
"""

from __future__ import annotations

import argparse
import asyncio
import os
import random
import tempfile
from dataclasses import dataclass, field
from pathlib import Path
from time import perf_counter
from typing import Any

import numpy as np
from streamlit.proto.BackMsg_pb2 import BackMsg
from streamlit.proto.Delta_pb2 import Delta
from streamlit.proto.ForwardMsg_pb2 import ForwardMsg
from websockets.asyncio.client import ClientConnection, connect

from bench.measure import report
from bench.web.server import serve

ALPHA = "Misses against false alarms (alpha)"
ALPHAS = tuple(round(0.1 * step, 1) for step in range(1, 10))
LONGEST_S = 300
READINGS = 20
"""Number of memory readings while the visitors move alpha."""
ENDING_S = 240
"""Time until sessions have ended. They are kept for three minutes after a visitor left."""


@dataclass
class Visitor:
    """Session in the app, held over a WebSocket."""

    socket: ClientConnection
    slider_id: str = ""
    waits_s: list[tuple[float, float]] = field(default_factory=list)
    """Send time (s after the start) and duration (s) of each move."""

    async def open_page(self) -> float:
        """Return the seconds until the first page is complete."""
        start = perf_counter()
        await self._ask(None)
        return perf_counter() - start

    async def move(self, alpha: float) -> str:
        """Move alpha, and return the text of the page that comes back."""
        return await self._ask(alpha)

    async def _ask(self, alpha: float | None) -> str:
        message = BackMsg()
        message.rerun_script.query_string = ""
        if alpha is not None:
            state = message.rerun_script.widget_states.widgets.add()
            state.id = self.slider_id
            state.double_array_value.data.append(alpha)
        await self.socket.send(message.SerializeToString())
        texts: dict[tuple[int, ...], str] = {}
        async with asyncio.timeout(LONGEST_S):
            while True:
                answer = ForwardMsg.FromString(await self.socket.recv())
                kind = answer.WhichOneof("type")
                if kind == "delta":
                    texts[tuple(answer.metadata.delta_path)] = self._text_of(answer.delta)
                elif kind == "script_finished":
                    if answer.script_finished == ForwardMsg.FINISHED_SUCCESSFULLY:
                        return "\n".join(text for _, text in sorted(texts.items()) if text)
                    if answer.script_finished == ForwardMsg.FINISHED_WITH_COMPILE_ERROR:
                        raise RuntimeError("the page failed")

    def _text_of(self, delta: Delta) -> str:
        """Return the text of an element, empty for a widget or a figure."""
        element = delta.new_element
        kind = element.WhichOneof("type")
        if kind == "slider" and element.slider.label == ALPHA:
            self.slider_id = element.slider.id
        if kind == "exception":
            raise RuntimeError(element.exception.message)
        return getattr(element, kind).body if kind in ("markdown", "html") else ""


async def visit(url: str) -> Visitor:
    """Create a visitor. The caller closes its socket."""
    address = url.replace("http://", "ws://") + "/_stcore/stream"
    return Visitor(await connect(address, origin=url, subprotocols=["streamlit"], max_size=None))


async def move_for(
    visitor: Visitor, seconds: float, pause_s: float, texts: dict[float, str], *, seed: int
) -> int:
    """Move alpha every `pause_s` seconds, and count pages unlike the first of their alpha."""
    chance = random.Random(seed)
    start, n_other = perf_counter(), 0
    await asyncio.sleep(chance.uniform(0, pause_s))
    alpha = 0.0
    while (sent := perf_counter() - start) < seconds:
        alpha = chance.choice([value for value in ALPHAS if value != alpha])
        text = await visitor.move(alpha)
        took = perf_counter() - start - sent
        visitor.waits_s.append((sent, took))
        n_other += texts.setdefault(alpha, text) != text
        await asyncio.sleep(max(0.0, pause_s - took))
    return n_other


def memory_mb(pid: int) -> float:
    """Return the proportional set size of a process and its descendants, in MB."""
    return sum(_pss_kb(process) for process in _tree(pid)) / 1000


def _tree(pid: int) -> list[int]:
    children = Path(f"/proc/{pid}/task/{pid}/children")
    below = [int(child) for child in children.read_text().split()] if children.exists() else []
    return [pid, *(process for child in below for process in _tree(child))]


def _pss_kb(pid: int) -> float:
    try:
        lines = Path(f"/proc/{pid}/smaps_rollup").read_text().splitlines()
    except OSError:  # the process has ended
        return 0.0
    return next((float(line.split()[1]) for line in lines if line.startswith("Pss:")), 0.0)


def percentiles(waits_s: list[float]) -> dict[str, float]:
    """Return p50, p95, p99 and the maximum, in seconds."""
    p50, p95, p99 = np.percentile(waits_s, [50, 95, 99])
    return {"n": len(waits_s), "p50": p50, "p95": p95, "p99": p99, "max": max(waits_s)}


async def measure(url: str, pid: int, options: argparse.Namespace) -> dict[str, Any]:
    """Run the whole measurement on a server that has just become healthy."""
    figures: dict[str, Any] = {"load": os.getloadavg()[0], "memory_mb": {"start": memory_mb(pid)}}
    alone = await visit(url)
    figures["first_page_alone_s"] = await alone.open_page()
    visitors = [await visit(url) for _ in range(options.visitors)]
    figures["first_pages_at_once_s"] = await asyncio.gather(
        *(visitor.open_page() for visitor in visitors)
    )
    await alone.socket.close()
    figures["memory_mb"]["all there"] = memory_mb(pid)
    seconds = 60 * options.minutes
    texts: dict[float, str] = {}
    during: list[float] = []

    async def read_memory() -> None:
        for _ in range(READINGS):
            await asyncio.sleep(seconds / READINGS)
            during.append(memory_mb(pid))

    *n_other, _ = await asyncio.gather(
        *(
            move_for(visitor, seconds, options.pause, texts, seed=seed)
            for seed, visitor in enumerate(visitors)
        ),
        read_memory(),
    )
    waits = [wait for visitor in visitors for wait in visitor.waits_s]
    figures["moves_s"] = percentiles([took for _, took in waits])
    tenths = [
        [took for sent, took in waits if tenth <= 10 * sent / seconds < tenth + 1]
        for tenth in range(10)
    ]
    figures["p95_by_tenth_s"] = [percentiles(tenth)["p95"] for tenth in tenths if tenth]
    figures["pages_that_differ"] = sum(n for n in n_other if n)
    figures["memory_mb"]["during"] = during
    for visitor in visitors:
        await visitor.socket.close()
    await asyncio.sleep(ENDING_S)
    figures["memory_mb"]["after all left"] = memory_mb(pid)
    return figures


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--visitors", type=int, default=10)
    parser.add_argument("--minutes", type=float, default=10)
    parser.add_argument("--pause", type=float, default=4.5)
    parser.add_argument("--port", type=int, default=8651)
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder, serve(Path(folder), options.port) as (url, pid):
        report(**asyncio.run(measure(url, pid, options)))


if __name__ == "__main__":
    main()
