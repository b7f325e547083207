"""Text of the section "In the browser" of docs/benchmarks.md from results of `bench.web`."""

from __future__ import annotations

from pathlib import Path
from statistics import median
from typing import Any

from bench.tables import seconds_text, table

HEADING = "## In the browser"
TARGETS_S = {0: 0.3, 100_000: 0.5, 1_000_000: 1.0}
"""Targets by number of frames. 0 is the sample."""
METHOD = """\
The dashboard's Timeline page in headless Chromium {version}, without a GPU, server and browser on
this machine. *Key press to plot*: from the key event on the slider to the first painted frame with
changed lines in the time plot; median of {n} presses (slowest in brackets), each on a still page.
*Opening*: from the click that opens the session file (CSV) to the finished Data page. Sets as
above, in recordings of 1,000 frames; the sample has ten of 300.
Load of the machine when it began: {load:.1f}.
"""


def web_section(figures: dict[str, Any]) -> str:
    """Return the whole section, starting with its heading."""
    if "failed" in figures:
        return f"{HEADING}\n\nNot measured: {figures['failed']}\n"
    sets = {int(n): figure for n, figure in figures["sets"].items()}
    names = list(next(iter(sets.values()))["seconds"])
    n_presses = min(len(runs) for figure in sets.values() for runs in figure["seconds"].values())
    rows = [[name, *(_cell(figure["seconds"][name]) for figure in sets.values())] for name in names]
    rows.append(["target", *(_target(n) for n in sets)])
    rows.append(["met", *(_met(n, figure["seconds"]) for n, figure in sets.items())])
    opened = [figure["opened_s"] for figure in sets.values()]
    rows.append(["opening", *("" if s is None else seconds_text(s) for s in opened)])
    head = ["key press to plot", *(f"{n:,} frames" if n else "sample" for n in sets)]
    how = METHOD.format(version=figures["chromium"], n=n_presses, load=figures["load"])
    parts = [HEADING, how.rstrip(), table(head, rows), _playing(figures["playing"])]
    return "\n\n".join(parts) + "\n"


def put_section(path: Path, section: str) -> None:
    """Replace the section with that heading in a page, or append it."""
    heading = section.partition("\n")[0]
    before, _, after = path.read_text(encoding="utf-8").partition(f"\n{heading}\n")
    _, mark, following = after.partition("\n## ")
    path.write_text(f"{before.rstrip()}\n\n{section}" + (mark + following), encoding="utf-8")


def _cell(seconds: list[float]) -> str:
    if not seconds:
        return "–"
    return f"{seconds_text(median(seconds))} ({seconds_text(max(seconds))})"


def _target(n: int) -> str:
    return f"{seconds_text(TARGETS_S[n])} or less" if n in TARGETS_S else ""


def _met(n: int, seconds: dict[str, list[float]]) -> str:
    if n not in TARGETS_S:
        return ""
    is_met = all(runs and median(runs) <= TARGETS_S[n] for runs in seconds.values())
    return "yes" if is_met else "no"


def _playing(figures: dict[str, float]) -> str:
    return (
        "Playing a recording of 20 frames per second (640x480, H.264) with boxes: "
        f"{figures['painted']} of {figures['due']} frames due were painted; in {figures['mixed']} "
        "of them picture and boxes were of different frames (read back from the canvas)."
    )
