"""Plans of scans: recordings to compare, their batches, and the program."""

from __future__ import annotations

import ast
import hashlib
import json
import sys
from collections.abc import Iterable, Iterator
from dataclasses import asdict, dataclass
from functools import cache
from importlib.metadata import version
from importlib.util import find_spec
from inspect import getsource
from pathlib import Path
from textwrap import dedent
from typing import Final

import numpy as np

from nvcore.common.errors import InputError
from nvcore.common.findings import Step
from nvcore.common.subject import subjects
from nvcore.common.wording import count_text, listed
from nvcore.subjects.fleet.calls import FRAMES_PER_BATCH
from nvcore.subjects.fleet.results import ScanParams
from nvcore.subjects.fleet.store import Snapshot

BOXES_A_FRAME: Final = 12
"""Recordings with more boxes a frame than these count as longer."""
_STARTS: Final = ("nvcore.subjects.fleet.batch", "nvcore.subjects.fleet.store")
"""Modules that a batch imports first."""
_OF_BATCHES: Final = ("settings", "session_keys", "scores", "tables")
"""Methods of subjects (`nvcore.common.subject.Subject`) that a comparison calls."""


@cache
def programs() -> dict[str, str]:
    """Return a hash of nvcore's code and versions of libraries, which results depend on."""
    libraries = ("numba", "numpy", "pandas", "pyarrow", "scipy")
    code = hashlib.sha256()
    for name, tree in sorted(modules_of_batches().items()):
        code.update(f"{name}\n{ast.dump(_without_docstrings(tree))}\n".encode())
    return {"nvcore": code.hexdigest()[:16], **{name: version(name) for name in libraries}}


def modules_of_batches() -> dict[str, ast.Module]:
    """Parse the modules of nvcore that a comparison imports, by name."""
    waiting, trees = [*_STARTS], dict[str, ast.Module]()
    for subject in subjects():
        for method in (getattr(subject, name) for name in _OF_BATCHES):
            waiting += _imported(ast.walk(ast.parse(dedent(getsource(method)))))
    while waiting:
        name = waiting.pop()
        path = None if name in trees else _source_of(name)
        if path is not None:
            trees[name] = ast.parse(path.read_bytes())
            waiting += [*_imported(trees[name].body), *filter(None, [name.rpartition(".")[0]])]
    return trees


def _source_of(name: str) -> Path | None:
    """Find the file of a module of nvcore, or return None for another name."""
    if name.partition(".")[0] != "nvcore":
        return None
    try:
        spec = sys.modules[name].__spec__ if name in sys.modules else find_spec(name)
    except ModuleNotFoundError:  # a name in a module
        return None
    return Path(spec.origin) if spec is not None and spec.origin else None


def _imported(body: Iterable[ast.AST]) -> Iterator[str]:
    """List the modules that are imported when code runs, and names that may be modules."""
    waiting = [*body]
    while waiting:
        node = waiting.pop()
        if isinstance(node, ast.With | ast.Try):
            waiting += node.body
        elif isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom) and node.module is not None:
            yield node.module
            yield from (f"{node.module}.{alias.name}" for alias in node.names)


def _without_docstrings(tree: ast.Module) -> ast.Module:
    for node in ast.walk(tree):
        body = getattr(node, "body", None)
        if isinstance(body, list) and body:
            node.body = [  # type: ignore[attr-defined]
                statement
                for statement in body
                if not (
                    isinstance(statement, ast.Expr)
                    and isinstance(statement.value, ast.Constant)
                    and isinstance(statement.value.value, str)
                )
            ]
    return tree


@dataclass(frozen=True)
class Batch:
    """Recordings that are compared together.

    Attributes
    ----------
    key
        Hash of everything that the results depend on.
    recordings
        Their names, sorted.
    n_frames
        Number of frames of all of them.
    """

    key: str
    recordings: tuple[str, ...]
    n_frames: int


@dataclass(frozen=True)
class Plan:
    """Plan of a scan: content of the store to compare, settings, and batches.

    Attributes
    ----------
    store
        URI of the store.
    versions
        Versions of the store's tables.
    params
        Sources and settings of the comparison.
    programs
        See `programs`.
    batches
        Batches in the order in which their recordings were ingested.
    left_out
        Number of recordings that a system lacks, by system.
    """

    store: str
    versions: dict[str, int]
    params: ScanParams
    programs: dict[str, str]
    batches: tuple[Batch, ...]
    left_out: dict[str, int]

    @property
    def key(self) -> str:
        """Hash of the plan."""
        return hash_of(self.to_json())

    @property
    def n_frames(self) -> int:
        """Number of frames of all batches."""
        return sum(batch.n_frames for batch in self.batches)

    def to_json(self) -> bytes:
        """Return the plan as JSON."""
        known = {**asdict(self), "params": self.params.given()}
        return json.dumps(known, sort_keys=True).encode()

    @classmethod
    def from_json(cls, text: bytes) -> Plan:
        """Read a plan that `to_json` wrote."""
        known = json.loads(text)
        params = ScanParams.parse(known.pop("params"))
        batches = [
            Batch(**{**batch, "recordings": tuple(batch["recordings"])})
            for batch in known.pop("batches")
        ]
        return cls(params=params, batches=tuple(batches), **known)

    def check_programs(self, advice: str, *steps: Step) -> None:
        """Raise InputError, with advice and steps, if the plan was made by other programs."""
        here = programs()
        others = [
            f"another {name} (its code differs)"
            if name == "nvcore"
            else f"{name} {self.programs.get(name)} (here: {own})"
            for name, own in here.items()
            if self.programs.get(name) != own
        ]
        if others:
            raise InputError(f"this scan was begun with {listed(others)}; {advice}", steps=steps)


def plan(
    snapshot: Snapshot, params: ScanParams, *, frames_per_batch: int = FRAMES_PER_BATCH
) -> Plan:
    """Divide the recordings of a store into batches, in the same way every time.

    A batch ends if it would be too large, or if it is half full and the hash of a recording's name
    marks an end. Adding or changing recordings therefore moves few others to another batch, and
    batches with unchanged recordings need not be compared again.

    Raises
    ------
    InputError
        If no recording has detections of both systems.
    """
    recordings = snapshot.recordings
    recordings = recordings.sort_values(["ingested_at", "file", "first_row", "recording"])
    names = recordings["recording"]
    n_boxes = np.zeros(len(recordings))
    facts = [names, recordings["sha256"]]
    is_compared = np.ones(len(recordings), bool)
    left_out: dict[str, int] = {}
    for source in params.sources:
        rows = snapshot.pick(source).reindex(names)
        n_boxes += rows["n_rows"].fillna(0).to_numpy()
        facts += [rows[name].map(str) for name in ("sha256", "kind", "threshold")]
        if source != params.truth:
            has_none = rows["sha256"].isna().to_numpy()
            left_out |= {source: int(has_none.sum())} if has_none.any() else {}
            is_compared &= ~has_none
    if not is_compared.any():
        raise InputError(
            f"none of {count_text(len(recordings), 'recording')} has detections of both "
            f"{params.x} and {params.y}",
            file=snapshot.location.uri,
        )
    chosen = np.flatnonzero(is_compared)
    size = np.maximum(recordings["n_rows"].to_numpy(), n_boxes / BOXES_A_FRAME)[chosen]
    hashes = [int(hash_of(name)[:8], 16) / 2**32 for name in names.iloc[chosen]]
    may_end = np.array(hashes) < size / (frames_per_batch / 4)
    starts, total = [0], 0.0
    for i, n in enumerate(size):  # a loop over recordings, since each end depends on the one before
        if total and total + n > frames_per_batch:
            starts.append(i)
            total = 0.0
        total += n
        if total >= frames_per_batch / 2 and may_end[i] and i + 1 < len(size):
            starts.append(i + 1)
            total = 0.0
    of_all = json.dumps([programs(), params.given()], sort_keys=True)
    lines = ["\0".join(line) for line in zip(*(of.iloc[chosen] for of in facts), strict=True)]
    batches = []
    for lo, hi in zip(starts, [*starts[1:], len(size)], strict=True):
        rows = recordings.iloc[chosen[lo:hi]]
        key = hash_of("\n".join([of_all, *sorted(lines[lo:hi])]))
        batches.append(Batch(key, tuple(sorted(rows["recording"])), int(rows["n_rows"].sum())))
    uri, versions = snapshot.location.uri, dict(snapshot.versions)
    return Plan(uri, versions, params, programs(), tuple(batches), left_out)


def hash_of(text: str | bytes) -> str:
    """Return the first 32 digits of a sha256."""
    content = text.encode() if isinstance(text, str) else text
    return hashlib.sha256(content).hexdigest()[:32]
