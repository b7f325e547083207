"""One target in a process of its own, which a decoder, a hang or too much memory may end.

    python -m scripts.fuzz.worker TARGET STORE SECONDS

It goes on after a fault in Python: the input and its traceback are kept, once for each place.
"""

from __future__ import annotations

import hashlib
import importlib
import json
import os
import resource
import shutil
import sys
import tempfile
import time
import traceback
import warnings
from pathlib import Path
from random import Random
from typing import Any, Final

import atheris

TIMEOUT_S: Final = 10
"""For one input."""
MEMORY_MB: Final = 1500
"""Of the whole process; what is imported takes a third of it."""
NOTES_S: Final = 1.0
"""Seconds between two notes of the counts."""

ROOT: Final = Path(__file__).resolve().parents[2]
COMPILED: Final = [
    ".".join(path.relative_to(ROOT).with_suffix("").parts).removesuffix(".__init__")
    for path in ROOT.glob("nvcore/**/*.py")
    if "kernels" in path.with_suffix("").parts or "\n@compiled" in path.read_text("utf-8")
]
"""Modules with loops: what compiles them does not know the calls that follow lines."""
with atheris.instrument_imports(include=["nvcore", "ui", "tomllib", "zipfile"], exclude=COMPILED):
    from nvcore.errors import NvcoreError
    from scripts.fuzz.targets import TARGETS, tidy

    if TARGETS[sys.argv[1]].module:
        importlib.import_module(TARGETS[sys.argv[1]].module)


class Trial:
    """Tries inputs, counts how they end, and keeps those that end in a fault."""

    def __init__(self, name: str, store: Path, folder: Path):
        self.target = TARGETS[name]
        self.faults, self.counts_file = store / "faults" / name, store / f"{name}.json"
        self.faults.mkdir(parents=True, exist_ok=True)
        self.folder = folder
        self.counts: dict[str, Any] = {"read": 0, "refused": 0, "faults": 0, "slowest_s": 0.0}
        if self.counts_file.exists():  # of the process before, which ended early
            self.counts |= json.loads(self.counts_file.read_text("utf-8"))
        self.noted = time.monotonic()

    def __call__(self, content: bytes) -> None:
        """Try one input."""
        begin = time.monotonic()
        try:
            self.target.run(content, self.folder)
            self.counts["read"] += 1
        except NvcoreError as error:
            self.counts["refused"] += 1
            self._check_text(content, error)
        except Exception as error:  # noqa: BLE001  # what is looked for
            self.counts["faults"] += 1
            self._keep(content, error)
        now = time.monotonic()
        self.counts["slowest_s"] = max(self.counts["slowest_s"], round(now - begin, 2))
        for entry in self.folder.iterdir():
            shutil.rmtree(entry) if entry.is_dir() else entry.unlink()
        if now - self.noted > NOTES_S:
            self.noted = now
            self.note()

    def _check_text(self, content: bytes, error: NvcoreError) -> None:
        """What is said can be shown: half a character of two cannot."""
        try:
            str(error).encode()
        except UnicodeEncodeError as fault:
            self.counts["faults"] += 1
            self._keep(content, fault.with_traceback(error.__traceback__))

    def note(self) -> None:
        """Write the counts down: a process that ends early says nothing more."""
        tidy()
        self.counts["peak_mb"] = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss // 1024
        self.counts_file.write_text(json.dumps(self.counts), "utf-8")

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


def dictionary(words: Path) -> list[str]:
    """The fuzzer's flag for the words of the seeds; none without words, which would end it."""
    return [f"-dict={words}"] if words.stat().st_size else []


def main() -> None:
    """Fuzz until the time is over, or the process ends."""
    name, store, seconds = sys.argv[1], Path(sys.argv[2]), int(sys.argv[3])
    warnings.simplefilter("ignore")
    with tempfile.TemporaryDirectory(prefix="nvcore-fuzz-") as folder:
        trial = Trial(name, store, Path(folder))
        corpus = store / "corpus" / name
        corpus.mkdir(parents=True, exist_ok=True)
        seeds, words = store / "seeds" / name, store / "seeds" / f"{name}.dict"
        flags = [
            f"-max_total_time={seconds}",
            f"-timeout={TIMEOUT_S}",
            f"-rss_limit_mb={MEMORY_MB}",
            f"-max_len={trial.target.most_bytes}",
            f"-artifact_prefix={trial.faults}/",
            *dictionary(words),
            "-len_control=0",
            "-reload=0",
            "-print_final_stats=1",
        ]
        mutate = trial.target.mutate
        ours: dict[str, Any] = {}
        if mutate is not None:
            ours["custom_mutator"] = lambda content, most, seed: mutate(content, Random(seed))[
                :most
            ]
        atheris.Setup([sys.argv[0], *flags, str(corpus), str(seeds)], trial, **ours)
        atheris.Fuzz()


if __name__ == "__main__":
    main()
