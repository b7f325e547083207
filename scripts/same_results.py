"""Show that two checkouts of the project give the same results.

    python scripts/same_results.py OLD_CHECKOUT NEW_CHECKOUT
        [--numbers] [--random N] [--seed S] [--only NAME ...] [--keep DIR] [--jobs N]

Each checkout needs its `.venv` (`make run` makes it). Every comparison is run by the command line
of either checkout, with the default settings, with wrong corrections of X and Y that the audit has
to notice, and with N random settings. What they write and print is compared to the byte, but for
the texts listed in `scripts/wordings.toml`; with `--numbers` only file names and the facts that
`scripts/facts.py` tells from prose. Exit code 0: all the same, 1: something differs or could not be
compared, 2: it cannot be run.

The real recordings are those in `$NVCORE_REALDATA` (default: `../shared/realdata` beside the newer
checkout); without them only the sample is compared. `--keep DIR` keeps all that was written; what
the older checkout wrote is used again while its commit and the commands stay the same.
"""

from __future__ import annotations

import argparse
import json
import os
import random
import shlex
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))

from scripts.comparisons import COMPARISONS, Comparison, Range
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
"""Where random settings are drawn if their whole range would leave little to compare."""

SHARE_SET = 0.4
"""Share of the parameters that a random setting sets."""
SHARE_AT_AN_END = 0.1
"""Share of those that are drawn at an end of what `Params` accepts."""

CORRECTIONS = ("--offset-frames-x", "3", "--offset-px-y=-8,4", "--scale-y", "1.1")

RULES = """\
frames >= 100
new_misses == 0
lamr_y <= 0.10
lamr_difference >= -0.01
longest_episode_s_y <= 1 or undefined
mean_similarity_x > 0.9
audit_warnings <= 1
"""

# prints what `Params` accepts and the names of the protocols, in the older checkout
READ_RANGES = """
import json
from dataclasses import fields
from nvcore.params import Params
from nvcore.protocols import PROTOCOLS

def range_of(spec):
    setting = spec.metadata.get("setting")
    if setting is None:  # before there was nvcore.stages
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
    """A comparison under one setting: commands that both checkouts run."""

    comparison: Comparison
    setting: str
    flags: tuple[str, ...]
    commands: tuple[tuple[str, ...], ...]


def random_flags(
    ranges: dict[str, Any], comparison: Comparison, *, seed: int, index: int
) -> tuple[str, ...]:
    """Flags of a random setting: the same for the same seed, comparison and index."""
    draw = random.Random(f"{seed} {comparison.name} {index}")
    x, y = draw.sample(sorted(comparison.systems), 2)
    thresholds = {
        f"threshold_{letter}": comparison.systems[name].scores
        for letter, name in (("x", x), ("y", y))
    }
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
    """Every comparison under every setting, the commands of each."""
    tasks = []
    for comparison in comparisons:
        session = "session.toml" if comparison.head else str(sample / "session.toml")
        tasks.append(Task(comparison, "default", (), _default_commands(session)))
        corrected = (
            ("check", session, *CORRECTIONS),
            ("compare", session, *CORRECTIONS, "--out", "report"),
        )
        tasks.append(Task(comparison, "corrections", CORRECTIONS, corrected))
        for index in range(1, count + 1):
            flags = random_flags(ranges, comparison, seed=seed, index=index)
            commands = _scoring_commands(session, flags)
            tasks.append(Task(comparison, f"random-{index}", flags, commands))
        if comparison.head is None:
            tasks.append(Task(comparison, "subjects", (), _subject_commands(session)))
    return tasks


def _scoring_commands(session: str, flags: Sequence[str]) -> tuple[tuple[str, ...], ...]:
    gate = ("--rules", "rules.txt", "--list", "--junit", "gate.xml", "--markdown", "gate.md")
    return (
        ("compare", session, *flags, "--out", "report"),
        ("report", session, *flags, "--out", "report.html"),
        ("gate", session, *flags, *gate),
    )


def _default_commands(session: str) -> tuple[tuple[str, ...], ...]:
    return (
        *_scoring_commands(session, ()),
        ("check", session, "--strict"),
        ("compare", session, "--json"),
        ("gate", "report/session.toml", "--rule", "no_such_measure == 0"),
        ("matrix", session, "--out", "matrix"),
        ("plan", session, "--out", "plan.json"),
    )


def _subject_commands(session: str) -> tuple[tuple[str, ...], ...]:
    """Whom the driver sees, and a detector of our own, as systems of further comparisons."""
    pictures = ("--only", "rural_child", "--frames", "100:299:4")
    return (
        ("driver", "estimate", session, *pictures[:2], "--model", "sample", "--out", "driver"),
        *_scoring_commands("driver/session.toml", ("--driver-weighting", "on")),
        ("detect", session, *pictures, "--detector", "icf:sample", "--out", "detect"),
        ("compare", "detect/session.toml", "--out", "detected"),
        ("models",),
        ("convert", str(Path(session).with_name("truth.csv")), "truth.json"),
    )


class Runner:
    """Runs the tasks in both checkouts, in the same folders.

    Parameters
    ----------
    old, new
        The checkouts.
    folder
        Where the commands run and what they write stays.
    realdata
        Folder of the real recordings.
    """

    def __init__(self, old: Path, new: Path, folder: Path, realdata: Path) -> None:
        self.old, self.new, self.folder, self.realdata = old, new, folder, realdata
        self.old_commit = _clean_commit(old)

    def run(self, task: Task) -> tuple[Path, Path]:
        """Folders of what the older and the newer checkout wrote."""
        folder = self.folder / task.comparison.name / task.setting
        folder.mkdir(parents=True, exist_ok=True)
        session = task.comparison.session(self.realdata)
        stamp = folder / "old.json"
        expected_stamp = json.dumps([self.old_commit, str(folder), session, RULES, task.commands])
        if not (self.old_commit and stamp.is_file() and stamp.read_text() == expected_stamp):
            stamp.unlink(missing_ok=True)
            self._run(self.old, task, session, folder / "old")
            stamp.write_text(expected_stamp)
        self._run(self.new, task, session, folder / "new")
        return folder / "old", folder / "new"

    def _run(self, checkout: Path, task: Task, session: str | None, outputs: Path) -> None:
        # both run in the folder of this name: paths in what they print are the same
        work = outputs.with_name("work")
        for folder in (work, outputs):
            shutil.rmtree(folder, ignore_errors=True)
        work.mkdir()
        (work / "rules.txt").write_text(RULES, encoding="utf-8")
        if session:
            (work / "session.toml").write_text(session, encoding="utf-8")
        environment = {**os.environ, "COLUMNS": "100"}
        program = str(checkout / ".venv" / "bin" / "nvcore")
        for number, command in enumerate(task.commands, start=1):
            process = subprocess.run(
                [program, *command], cwd=work, env=environment, capture_output=True, check=False
            )
            printed = work / "printed"
            printed.mkdir(exist_ok=True)
            stem = f"{number}-{command[0]}"
            kind = "json" if "--json" in command else "txt"
            (printed / f"{stem}.stdout.{kind}").write_bytes(process.stdout)
            (printed / f"{stem}.stderr.txt").write_bytes(process.stderr)
            (printed / f"{stem}.exit.txt").write_text(f"{process.returncode}\n")
        work.rename(outputs)


def _clean_commit(checkout: Path) -> str | None:
    """Commit of a checkout without changes of its own, else None."""
    git = ["git", "-C", str(checkout)]
    commit, changes = (
        subprocess.run([*git, *arguments], capture_output=True, text=True, check=False).stdout
        for arguments in (["rev-parse", "HEAD"], ["status", "--porcelain"])
    )
    return commit.strip() or None if not changes.strip() else None


def exit_codes(outputs: Path) -> str:
    """Exit codes of a task's commands, in their order."""
    paths = sorted((outputs / "printed").glob("*.exit.txt"))
    return " ".join(path.read_text().strip() for path in paths)


def is_refused(outputs: Path) -> bool:
    """Whether the comparison itself could not be made, so that nothing was compared."""
    return not (outputs / "report" / "summary.json").is_file()


def report(task: Task, old: Path, new: Path, rewording: Rewording | None) -> bool:
    """Print a task's line of the table and what differs; whether all is the same."""
    refused = is_refused(old)
    differing = list(compare_folders(old, new, rewording))
    files = [path for path in new.rglob("*") if path.is_file()]
    size = sum(path.stat().st_size for path in files)
    verdict = f"{len(differing)} DIFFER" if differing else "REFUSED" if refused else "same"
    print(
        f"{task.comparison.name:14} {task.setting:12} {len(files):5} {size:12,} "
        f"{exit_codes(new):12} {verdict:10} {shlex.join(task.flags)}".rstrip(),
        flush=True,
    )
    for name, where in differing:
        print(f"  {name}: {where}", flush=True)
    return not (differing or refused)


def main() -> int:
    """Run the program; its exit code."""
    options = _parser().parse_args()
    old, new = options.old.resolve(), options.new.resolve()
    for checkout in (old, new):
        if not (checkout / ".venv" / "bin" / "nvcore").is_file():
            print(f"{checkout}: has no .venv/bin/nvcore; run make run in it once", file=sys.stderr)
            return 2
    realdata = Path(os.environ.get("NVCORE_REALDATA", new.parent / "shared" / "realdata")).resolve()
    comparisons = [item for item in COMPARISONS if not options.only or item.name in options.only]
    if not realdata.is_dir():
        print(f"no real recordings in {realdata}: the sample only; set NVCORE_REALDATA")
        comparisons = [item for item in comparisons if item.head is None]
    ranges = json.loads(
        subprocess.run(
            [old / ".venv" / "bin" / "python", "-c", READ_RANGES],
            cwd=old, capture_output=True, text=True, check=True,
        ).stdout
    )  # fmt: skip
    tasks = make_tasks(
        ranges, comparisons, old / "sample_data", count=options.random, seed=options.seed
    )
    rewording = None if options.numbers else Rewording(read_wordings(WORDINGS))
    began = time.monotonic()
    print(f"{'comparison':14} {'settings':12} files        bytes exit codes   result     flags")
    with tempfile.TemporaryDirectory(prefix="same_results_") as temporary:
        folder = Path(options.keep or temporary).resolve()
        runner = Runner(old, new, folder, realdata)
        with ThreadPoolExecutor(options.jobs) as pool:
            outputs = pool.map(runner.run, tasks)
            are_same = [
                report(task, *folders, rewording)
                for task, folders in zip(tasks, outputs, strict=True)
            ]
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
        "--only", nargs="+", metavar="NAME", choices=[item.name for item in COMPARISONS],
        help="of these comparisons: %(choices)s",
    )  # fmt: skip
    parser.add_argument("--jobs", type=int, default=2, metavar="N", help="at a time (2)")
    parser.add_argument("--keep", type=Path, metavar="DIR", help="keep what is written there")
    return parser


if __name__ == "__main__":
    sys.exit(main())
