"""Trials of a target: how inputs end, and which end in a fault.

    python -m scripts.fuzz.trial TARGET STORE RUNS

tries so many inputs that are changed by chance alone; `scripts.fuzz.worker` learns from each. A
trial goes on after a fault in Python: the input and its traceback are kept, once for each place.
"""

from __future__ import annotations

import gc
import hashlib
import json
import os
import resource
import shutil
import sys
import tempfile
import time
import traceback
import warnings
from contextlib import suppress
from pathlib import Path
from random import Random
from typing import Any, Final

from nvcore.errors import NvcoreError
from scripts.fuzz.target import ROOT, mutated_text
from scripts.fuzz.targets import TARGETS

SLOW_S: Final = 2.0
"""Of the processor, for one input; more is a fault."""
NOTES_S: Final = 1.0
"""Seconds between two notes of the counts."""
MOST_KEPT: Final = 300
"""Inputs that were read, to be changed further."""
COUNTED: Final = ("read", "refused", "faults")


class Trial:
    """Tries inputs, counts how they end, and keeps those that end in a fault."""

    def __init__(self, name: str, store: Path, folder: Path):
        self.target = TARGETS[name]
        self.faults, self.counts_file = store / "faults" / name, store / f"{name}.json"
        self.faults.mkdir(parents=True, exist_ok=True)
        self.folder = folder
        self.counts: dict[str, Any] = dict.fromkeys((*COUNTED, "slowest_s"), 0)
        if self.counts_file.exists():  # of the process before, which ended early
            self.counts |= json.loads(self.counts_file.read_text("utf-8"))
        self.noted = time.monotonic()

    def warm_up(self) -> None:
        """Read some seeds, for what they load and compile; warnings are faults from now on."""
        for content in self.target.first_inputs()[:5]:
            with suppress(NvcoreError):
                self.target.run(content, self.folder)
            self._tidy()
        warnings.simplefilter("error")

    def __call__(self, content: bytes) -> str:
        """Try one input; how it ended."""
        begin, kind, told = time.process_time(), "read", "-"
        try:
            try:
                self.target.run(content, self.folder)
            except NvcoreError as error:
                kind, told = "refused", str(error)
            spent_s = time.process_time() - begin
            self.counts["slowest_s"] = max(self.counts["slowest_s"], round(spent_s, 2))
            assert spent_s <= SLOW_S, f"{spent_s:.1f} s"
            assert told.encode().strip(), "no message"  # half a character of two cannot be shown
        except Exception as error:  # noqa: BLE001  # what is looked for
            kind = "faults"
            self._keep(content, error)
        self.counts[kind] += 1
        self._tidy()
        if time.monotonic() - self.noted > NOTES_S:
            self.note()
        return kind

    def note(self) -> None:
        """Write the counts down: a process that ends early says nothing more."""
        gc.collect()
        self.counts["peak_mb"] = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss // 1024
        self.counts_file.write_text(json.dumps(self.counts), "utf-8")
        self.noted = time.monotonic()

    def _tidy(self) -> None:
        for entry in self.folder.iterdir():
            shutil.rmtree(entry) if entry.is_dir() else entry.unlink()

    def _keep(self, content: bytes, error: Exception) -> None:
        """The input, once for each place in the project's code; the shortest of them."""
        frames = traceback.extract_tb(error.__traceback__)
        ours = [f for f in frames if f.filename.startswith(f"{ROOT}{os.sep}")] or frames
        place = f"{type(error).__name__} {ours[-1].filename}:{ours[-1].lineno}"
        file = self.faults / hashlib.sha256(place.encode()).hexdigest()[:12]
        if file.exists() and file.stat().st_size <= len(content):
            return
        file.write_bytes(content)
        text = "".join(traceback.format_exception(error))
        file.with_suffix(".txt").write_text(f"{place}\n\n{text}", "utf-8", "backslashreplace")


def main() -> None:
    """Try inputs that are made of the seeds, and of those among them that were read."""
    name, store, runs = sys.argv[1], Path(sys.argv[2]), int(sys.argv[3])
    with tempfile.TemporaryDirectory(prefix="nvcore-fuzz-") as folder:
        trial = Trial(name, store, Path(folder))
        trial.warm_up()
        mutate, most = trial.target.mutate or mutated_text, trial.target.most_bytes
        seeds, known, rng = trial.target.first_inputs(), [b""], Random(runs)
        for _ in range(runs):
            content = mutate(rng.choice(rng.choice((seeds, seeds, known))), rng)[:most]
            if trial(content) == "read":
                known.append(content)
                del known[:-MOST_KEPT]
        trial.note()


if __name__ == "__main__":
    main()
