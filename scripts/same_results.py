"""Show that two checkouts of the project give the same results.

    python scripts/same_results.py OLD_CHECKOUT NEW_CHECKOUT
        [--numbers] [--random N] [--seed S] [--only NAME ...] [--keep DIR] [--jobs N]

Each checkout needs its `.venv` with all extras (`make check` makes it). Both checkouts run the
command lines of `scripts/comparisons.py`: all commands with the default settings, with wrong
corrections of X and Y that the audit has to notice, and with bad inputs, and the comparing commands
with N random settings. Files and printed text are compared byte by byte, except for parts that
`scripts/differences.py` masks and the texts listed in `scripts/wordings.toml`. With `--numbers`
only file names and facts (`scripts/facts.py`) are compared. Commands that both checkouts reject
count as equal and are listed, because only their message was compared. Exit code 0: all equal, 1:
something differs, 2: the script cannot run.

The real recordings are those in `$NVCORE_REALDATA`. Without them only sessions of the sample are
compared. `--keep DIR` keeps the output. That of the older checkout is used again while its commit
and the commands stay the same.
"""

from __future__ import annotations

import argparse
import json
import os
import random
import re
import shlex
import shutil
import subprocess
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))

from scripts.comparisons import COMPARISONS, FILES, RUNS, RUNS_OF_ALL, SCRIPTS, Comparison, Range
from scripts.differences import Rewording, compare_folders, read_wordings

WORDINGS = Path(__file__).with_name("wordings.toml")

USUAL: dict[str, Range] = {
    "midpoint": (10, 200),
    "spread": (1, 60),
    "midpoint_m": (5, 80),
    "spread_m": (1, 20),
    "horizon": (140, 260),
    "lag_s": (0, 3),
    "gap_s": (0, 3),
    "window": (0, 10),
    "tolerance": (0, 0.3),
    "lateral_tolerance": (0, 0.1),
    "recency_spread": (0.01, 1),
    "confirm_n": (1, 5),
    "confirm_m": (5, 20),
}
"""Ranges of random settings whose full range would leave little to compare."""

SHARE_SET = 0.4
"""Share of the parameters that a random setting changes."""
SHARE_AT_AN_END = 0.1
"""Share of changed parameters that are set to an end of the range accepted by `Params`."""

CORRECTIONS = ("--offset-frames-x", "3", "--offset-px-y=-8,4", "--scale-y", "1.1")

# prints what `Params` accepts and the names of the protocols, in the older checkout
READ_RANGES = """
import json
from dataclasses import fields
from nvcore.settings.params import Params
from nvcore.settings.protocols import PROTOCOLS

def range_of(spec):
    setting = spec.metadata.get("setting")
    if setting is None:  # before there was nvcore.settings.stages
        return {key: spec.metadata.get(key) for key in ("choices", "low", "high", "above_low")}
    is_whole = getattr(setting, "is_whole", False)
    choices = None if setting.words is None else list(setting.words)
    ends = {"low": setting.low, "high": setting.high, "above_low": setting.is_above_low}
    return {"choices": choices, "is_whole": is_whole, **ends}

ranges = {spec.name: range_of(spec) for spec in fields(Params)}
print(json.dumps({"params": ranges, "protocols": list(PROTOCOLS)}))
"""


@dataclass(frozen=True)
class Task:
    """Comparison under one setting, with the commands that both checkouts run.

    A command that begins with "!" must be rejected. "python" runs one of `SCRIPTS`.
    """

    comparison: Comparison
    setting: str
    flags: tuple[str, ...]
    commands: tuple[tuple[str, ...], ...]

    @property
    def names(self) -> tuple[str, str]:
        """Names that `--only` accepts for it."""
        return self.comparison.name, f"{self.comparison.name}/{self.setting}"


def random_flags(
    ranges: dict[str, Any], comparison: Comparison, *, seed: int, index: int
) -> tuple[str, ...]:
    """Return the flags of a random setting. Equal seed, comparison and index give equal flags."""
    draw = random.Random(f"{seed} {comparison.name} {index}")
    x, y = draw.sample(sorted(comparison.systems), 2)
    thresholds = {
        f"threshold_{letter}": comparison.systems[name].scores
        for letter, name in (("x", x), ("y", y))
    }
    thresholds["alert_score"] = comparison.systems[x].scores
    values: dict[str, str] = {}
    for name, spec in ranges["params"].items():
        is_set, at_an_end = draw.random() < SHARE_SET, draw.random() < SHARE_AT_AN_END
        place, choice = draw.random(), draw.choice(spec["choices"] or [""])
        if name == "horizon":
            is_set = is_set or values.get("proximity") == "horizon"
        if not is_set:
            continue
        if spec["choices"]:
            values[name] = choice
            continue
        low, high = thresholds.get(name) or (spec["low"], spec["high"])
        if at_an_end:
            value = high if spec["above_low"] or place < 0.5 else low
        else:
            low, high = USUAL.get(name, (low, high))
            value = low + (high - low) * (place or 0.5)
        values[name] = f"{round(value) if spec.get('is_whole') else value:.4g}"
    n_confirming = values.get("confirm_n", "3")
    if int(values.get("confirm_m", "5")) < int(n_confirming):
        values["confirm_m"] = n_confirming
    flags = [f"--name-x={x}", f"--name-y={y}"]
    flags += [f"--{name.replace('_', '-')}={value}" for name, value in values.items()]
    if draw.random() < SHARE_SET:
        flags.append(f"--protocol={draw.choice(ranges['protocols'])}")
    return tuple(flags)


def make_tasks(
    ranges: dict[str, Any],
    comparisons: Sequence[Comparison],
    sample: Path,
    *,
    count: int,
    seed: int,
) -> list[Task]:
    """Return the commands of every comparison under every setting."""
    tasks = []
    for comparison in comparisons:
        settings: dict[str, tuple[str, tuple[str, ...]]] = {
            name: (name, CORRECTIONS if name == "corrections" else ())
            for name in (*RUNS_OF_ALL, *comparison.runs)
        }
        for index in range(1, count + 1):
            flags = random_flags(ranges, comparison, seed=seed, index=index)
            settings[f"random-{index}"] = ("random", flags)
        for setting, (run, flags) in settings.items():
            x, y, *_ = comparison.systems
            values = {"x": x, "y": y, "recording": comparison.recording}
            text = f"{comparison.first}\n{RUNS[run]}".replace("{session}", comparison.path)
            for name, value in {**values, "sample": str(sample)}.items():
                text = text.replace(f"{{{name}}}", shlex.quote(value))
            lines = re.split(r"\n| ; ", text.replace("{flags}", shlex.join(flags)))
            commands = tuple(tuple(shlex.split(line)) for line in lines if line.strip())
            tasks.append(Task(comparison, setting, flags, commands))
    return tasks


class Runner:
    """Runner of tasks in both checkouts, in the same folders.

    Parameters
    ----------
    old, new
        The checkouts.
    folder
        Folder in which the commands run and their output stays.
    realdata
        Folder of the real recordings.
    """

    def __init__(self, old: Path, new: Path, folder: Path, realdata: Path) -> None:
        self.old, self.new, self.folder, self.realdata = old, new, folder, realdata
        self.old_commit = _clean_commit(old)

    def run(self, task: Task) -> tuple[Path, Path, float]:
        """Return the output folders of both checkouts, and the newer one's seconds."""
        folder = self.folder / task.comparison.name / task.setting
        folder.mkdir(parents=True, exist_ok=True)
        files = {**FILES, "session.toml": task.comparison.text}
        for name, text in files.items():
            for key, path in (("sample", self.old / "sample_data"), ("realdata", self.realdata)):
                text = text.replace(f"{{{key}}}", str(path))
            files[name] = text
        stamp = folder / "old.json"
        expected_stamp = json.dumps([self.old_commit, str(folder), files, SCRIPTS, task.commands])
        if not (self.old_commit and stamp.is_file() and stamp.read_text() == expected_stamp):
            stamp.unlink(missing_ok=True)
            self._run(self.old, task, files, folder / "old")
            stamp.write_text(expected_stamp)
        began = time.monotonic()
        self._run(self.new, task, files, folder / "new")
        return folder / "old", folder / "new", time.monotonic() - began

    def _run(self, checkout: Path, task: Task, files: dict[str, str], outputs: Path) -> None:
        # both run in a folder of this name, so that printed paths are equal
        work = outputs.with_name("work")
        for folder in (work, outputs):
            shutil.rmtree(folder, ignore_errors=True)
        printed = work / "printed"
        printed.mkdir(parents=True)
        for name, text in files.items():
            if text or name != "session.toml":
                (work / name).write_text(text, encoding="utf-8")
        programs = checkout / ".venv" / "bin"
        # first in the path, so that it prints its name and not this path
        path = os.pathsep.join([str(programs), os.environ.get("PATH", "")])
        environment = {**os.environ, "COLUMNS": "100", "PATH": path}
        for number, command in enumerate(task.commands, start=1):
            words = [word for word in command if word != "!"]
            if words[0] == "python":
                call = [str(programs / "python"), "-c", SCRIPTS[words[1]], *words[2:]]
            else:
                call = [str(programs / "nvcore"), *words]
            process = subprocess.run(
                call, cwd=work, env=environment, capture_output=True, check=False
            )
            stem = f"{number:02}-{words[0]}"
            kind = "json" if "--json" in words else "txt"
            (printed / f"{stem}.stdout.{kind}").write_bytes(process.stdout)
            (printed / f"{stem}.stderr.txt").write_bytes(process.stderr)
            (printed / f"{stem}.exit.txt").write_text(f"{process.returncode}\n")
        work.rename(outputs)


def _clean_commit(checkout: Path) -> str | None:
    """Return the commit of a checkout without local changes, else None."""
    git = ["git", "-C", str(checkout)]
    commit, changes = (
        subprocess.run([*git, *arguments], capture_output=True, text=True, check=False).stdout
        for arguments in (["rev-parse", "HEAD"], ["status", "--porcelain"])
    )
    return commit.strip() or None if not changes.strip() else None


def exit_codes(task: Task, outputs: Path) -> list[tuple[str, bool]]:
    """Return each command's exit code, and whether it is expected (rejected: 2 or more)."""
    paths = sorted((outputs / "printed").glob("*.exit.txt"))
    codes = [path.read_text().strip() for path in paths]
    return [
        (code, (code not in ("0", "1")) == (command[0] == "!"))
        for code, command in zip(codes, task.commands, strict=True)
    ]


def report(
    task: Task, old: Path, new: Path, seconds: float, rewording: Rewording | None
) -> tuple[bool, list[str]]:
    """Print a task's line of the table and its differences.

    Return whether all is equal, and lines on commands that did not end as expected.
    """
    codes = exit_codes(task, new)
    differing = list(compare_folders(old, new, rewording))
    files = [path for path in new.rglob("*") if path.is_file()]
    size = sum(path.stat().st_size for path in files)
    verdict = f"{len(differing)} DIFFER" if differing else "same"
    counts = sorted(Counter(code for code, _ in codes).items())
    print(
        f"{task.comparison.name:12} {task.setting:12} {len(files):5} {size:12,} {seconds:5.0f} s "
        f"{' '.join(f'{n}x{code}' for code, n in counts):14} {verdict:10} "
        f"{shlex.join(task.flags)}".rstrip(),
        flush=True,
    )
    for name, where in differing:
        print(f"  {name}: {where}", flush=True)
    unmeant = [
        f"exit code {code}: {task.comparison.name} {task.setting}: {shlex.join(command)}"
        for (code, is_meant), command in zip(codes, task.commands, strict=True)
        if not is_meant
    ]
    return not differing, unmeant


def main() -> int:
    """Run the program and return its exit code."""
    options = _parser().parse_args()
    old, new = options.old.resolve(), options.new.resolve()
    for checkout in (old, new):
        if not (checkout / ".venv" / "bin" / "nvcore").is_file():
            print(f"{checkout}: has no .venv/bin/nvcore; run make run in it once", file=sys.stderr)
            return 2
    realdata = Path(os.environ.get("NVCORE_REALDATA") or os.devnull).resolve()
    comparisons: Sequence[Comparison] = COMPARISONS
    if not realdata.is_dir():
        print("no real recordings: only the sample is compared; set NVCORE_REALDATA")
        comparisons = [item for item in comparisons if "{realdata}" not in item.text]
    ranges = json.loads(
        subprocess.run(
            [old / ".venv" / "bin" / "python", "-c", READ_RANGES],
            cwd=old, capture_output=True, text=True, check=True,
        ).stdout
    )  # fmt: skip
    tasks = make_tasks(
        ranges, comparisons, old / "sample_data", count=options.random, seed=options.seed
    )
    if options.only:
        names = {name for task in tasks for name in task.names}
        if unknown := {*options.only} - names:
            print(
                f"there is no {', '.join(sorted(unknown))}; there are {', '.join(sorted(names))}",
                file=sys.stderr,
            )
            return 2
        tasks = [task for task in tasks if {*options.only} & {*task.names}]
    rewording = None if options.numbers else Rewording(read_wordings(WORDINGS))
    began = time.monotonic()
    print(f"{'comparison':12} {'settings':12} files        bytes    time exit codes     result")
    with tempfile.TemporaryDirectory(prefix="same_results_") as temporary:
        folder = Path(options.keep or temporary).resolve()
        runner = Runner(old, new, folder, realdata)
        with ThreadPoolExecutor(options.jobs) as pool:
            outputs = pool.map(runner.run, tasks)
            reports = [
                report(task, *written, rewording)
                for task, written in zip(tasks, outputs, strict=True)
            ]
    are_same = [is_same for is_same, _ in reports]
    for line in [line for _, unmeant in reports for line in unmeant]:
        print(line)
    minutes = (time.monotonic() - began) / 60
    print(f"{sum(are_same)} of {len(are_same)} the same; {minutes:.1f} minutes")
    if rewording:
        for wording in rewording.wordings:
            if wording not in rewording.needed:
                print(f"not needed: {wording.old!r} -> {wording.new!r}")
    return 0 if all(are_same) else 1


def _parser() -> argparse.ArgumentParser:
    summary, _, details = (__doc__ or "").partition("\n")
    parser = argparse.ArgumentParser(
        description=summary, epilog=details, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("old", type=Path, metavar="OLD_CHECKOUT")
    parser.add_argument("new", type=Path, metavar="NEW_CHECKOUT")
    parser.add_argument("--numbers", action="store_true", help="compare facts, not wordings")
    parser.add_argument("--random", type=int, default=2, metavar="N", help="random settings (2)")
    parser.add_argument("--seed", type=int, default=1, metavar="S", help="of the settings (1)")
    parser.add_argument(
        "--only", nargs="+", metavar="NAME",
        help=f"only these of {', '.join(item.name for item in COMPARISONS)}, or of their settings, "
        "such as sample/errors",
    )  # fmt: skip
    parser.add_argument("--jobs", type=int, default=2, metavar="N", help="at a time (2)")
    parser.add_argument("--keep", type=Path, metavar="DIR", help="keep what is written there")
    return parser


if __name__ == "__main__":
    sys.exit(main())
