"""Search for inputs that end in neither a result nor an error that explains the problem.

    python -m scripts.fuzz [TARGET ...] [--seconds 600]    all targets, or these, one after another
    python -m scripts.fuzz [TARGET ...] --runs 100000      this many random inputs of each
    python -m scripts.fuzz TARGET --again FILE             one input, with its traceback

External files, requests and rules are derived from small valid ones by changes that reach new lines
of the program (atheris, which is libFuzzer for Python). Faults are: an exception that is not an
NvcoreError, a warning, a failed check, more than 2 s of processor time for one input, more than
1,500 MB, or the end of the process. Each target has its own process. The corpus is kept in
.fuzz/corpus for the next run, faults in .fuzz/faults.
"""

from __future__ import annotations

import argparse
import hashlib
import json
import re
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from scripts.fuzz.target import ROOT
from scripts.fuzz.targets import TARGETS
from scripts.fuzz.trial import COUNTED

STORE = ROOT / ".fuzz"
MOST_STARTS = 20
"""Maximum number of processes for one target. All but the last were ended by an input."""
WORDS = 300


def prepare(name: str, store: Path) -> None:
    """Write the seeds of a target, and its dictionary of words."""
    folder = store / "seeds" / name
    folder.mkdir(parents=True, exist_ok=True)
    words: dict[bytes, None] = {}
    for content in TARGETS[name].first_inputs():
        (folder / hashlib.sha256(content).hexdigest()[:16]).write_bytes(content)
        words |= dict.fromkeys(re.findall(rb"[A-Za-z_<>/!?\[\]\"=:-]{3,24}", content))
    lines = ['"' + "".join(f"\\x{byte:02x}" for byte in word) + '"' for word in list(words)[:WORDS]]
    (store / "seeds" / f"{name}.dict").write_text("\n".join(lines), "ascii")


def fuzz(name: str, seconds: float, runs: int, store: Path) -> dict[str, float]:
    """Run one target for a time, or for a number of inputs unless 0, and return its counts."""
    prepare(name, store)
    counts_file, log = store / f"{name}.json", store / f"{name}.log"
    counts_file.unlink(missing_ok=True)
    end = time.monotonic() + seconds
    ends = 0
    with log.open("wb") as output:
        for _ in range(MOST_STARTS):
            done = 0
            if runs and counts_file.exists():
                known = json.loads(counts_file.read_text("utf-8"))
                done = sum(known[kind] for kind in COUNTED)
            left = runs - done if runs else round(end - time.monotonic())
            if left < 1:
                break
            module = f"scripts.fuzz.{'trial' if runs else 'worker'}"
            worker = subprocess.Popen(
                [sys.executable, "-m", module, name, str(store), str(left)],
                cwd=ROOT,
                stdout=output,
                stderr=subprocess.STDOUT,
            )
            try:
                code = worker.wait()
            finally:
                worker.kill()
            if code == 0:
                break
            ends += 1
    counts = {"read": 0, "refused": 0, "faults": 0, "slowest_s": 0.0, "peak_mb": 0}
    if counts_file.exists():
        counts |= json.loads(counts_file.read_text("utf-8"))
    return counts | {"ends": ends, "corpus": len(list((store / "corpus" / name).glob("*")))}


def try_again(name: str, file: Path) -> None:
    """Run one input without the fuzzer."""
    with tempfile.TemporaryDirectory() as folder:
        TARGETS[name].run(file.read_bytes(), Path(folder))


def main() -> int:
    """Fuzz, print the counts, and return 1 if there is a fault."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("targets", nargs="*", metavar="TARGET", help=", ".join(TARGETS))
    parser.add_argument("--seconds", type=float, default=600)
    parser.add_argument("--runs", type=int, default=0, metavar="N")
    parser.add_argument("--again", type=Path, metavar="FILE")
    options = parser.parse_args()
    unknown = set(options.targets) - set(TARGETS)
    if unknown:
        parser.error(f"there is no target {', '.join(sorted(unknown))}")
    if options.again is not None:
        try_again(options.targets[0], options.again)
        return 0
    names = options.targets or list(TARGETS)
    shares = sum(TARGETS[name].share for name in names)
    print(f"{'':12} {'read':>9} {'refused':>9} {'faults':>7} {'ended':>6} {'corpus':>7} "
          f"{'slowest s':>10} {'peak MB':>8}")  # fmt: skip
    n_faults = 0
    for name in names:
        seconds = options.seconds * TARGETS[name].share / shares
        counts = fuzz(name, seconds, options.runs, STORE)
        n_faults += int(counts["faults"] + counts["ends"])
        print(
            f"{name:12} {counts['read']:9,} {counts['refused']:9,} {counts['faults']:7,} "
            f"{counts['ends']:6} {counts['corpus']:7,} {counts['slowest_s']:10.2f} "
            f"{counts['peak_mb']:8,}",
            flush=True,
        )
    if n_faults:
        print(f"{n_faults} faults: the inputs are in {STORE / 'faults'}, python -m scripts.fuzz "
              "TARGET --again FILE runs one")  # fmt: skip
    return 1 if n_faults else 0


if __name__ == "__main__":
    sys.exit(main())
