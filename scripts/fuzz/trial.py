"""Trials of a target: run inputs, classify their outcomes, and keep faults.

    python -m scripts.fuzz.trial TARGET STORE RUNS

The command tries a number of purely random changes, while `scripts.fuzz.worker` learns from each. A
trial continues after a fault in Python. It keeps the input and its traceback, one for each place.
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

from nvcore.common.errors import NvcoreError
from scripts.fuzz.target import ROOT, mutated_text
from scripts.fuzz.targets import TARGETS

SLOW_S: Final = 2.0
"""Maximum processor time per input. More is a fault."""
NOTES_S: Final = 1.0
"""Seconds between two writes of the counts."""
MOST_KEPT: Final = 300
"""Maximum number of valid inputs that are kept for further changes."""
COUNTED: Final = ("read", "refused", "faults")


class Trial:
    """Runner of inputs that counts their outcomes and keeps those that end in a fault."""

    def __init__(self, name: str, store: Path, folder: Path):
        self.target = TARGETS[name]
        self.faults, self.counts_file = store / "faults" / name, store / f"{name}.json"
        self.faults.mkdir(parents=True, exist_ok=True)
        self.folder = folder
        self.counts: dict[str, Any] = dict.fromkeys((*COUNTED, "slowest_s"), 0)
        if self.counts_file.exists():  # from the previous process, which ended early
            self.counts |= json.loads(self.counts_file.read_text("utf-8"))
        self.noted = time.monotonic()

    def warm_up(self) -> None:
        """Run some seeds, which loads and compiles code. From then on warnings are faults."""
        for content in self.target.first_inputs()[:5]:
            with suppress(NvcoreError):
                self.target.run(content, self.folder)
            self._tidy()
        warnings.simplefilter("error")

    def __call__(self, content: bytes) -> str:
        """Try one input and return its outcome."""
        begin, kind, told = time.process_time(), "read", "-"
        try:
            try:
                self.target.run(content, self.folder)
            except NvcoreError as error:
                kind, told = "refused", str(error)
            spent_s = time.process_time() - begin
            self.counts["slowest_s"] = max(self.counts["slowest_s"], round(spent_s, 2))
            assert spent_s <= SLOW_S, f"{spent_s:.1f} s"
            assert told.encode().strip(), "no message"  # half a surrogate pair cannot be encoded
        except Exception as error:  # noqa: BLE001  # any exception is a finding
            kind = "faults"
            self._keep(content, error)
        self.counts[kind] += 1
        self._tidy()
        if time.monotonic() - self.noted > NOTES_S:
            self.note()
        return kind

    def note(self) -> None:
        """Write the counts, in case the process ends early."""
        gc.collect()
        self.counts["peak_mb"] = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss // 1024
        self.counts_file.write_text(json.dumps(self.counts), "utf-8")
        self.noted = time.monotonic()

    def _tidy(self) -> None:
        for entry in self.folder.iterdir():
            shutil.rmtree(entry) if entry.is_dir() else entry.unlink()

    def _keep(self, content: bytes, error: Exception) -> None:
        """Keep the shortest faulty input for each place in the project's code."""
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
    """Try inputs derived from the seeds and from valid inputs among the results."""
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
