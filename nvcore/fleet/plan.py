"""Plans of scans: which recordings are compared, by which programs, and in which batches."""

from __future__ import annotations

import hashlib
import json
from dataclasses import asdict, dataclass
from functools import cache
from importlib.metadata import version
from typing import Any, Final

import numpy as np

from nvcore import __version__
from nvcore.errors import InputError
from nvcore.fleet.arguments import FRAMES_PER_BATCH
from nvcore.fleet.location import Location
from nvcore.fleet.results import ScanParams
from nvcore.fleet.store import Snapshot, Store
from nvcore.wording import count_text, listed

SUMMARY: Final = "summary.json"
"""In a folder of results: which plan they are of, and the version of each table."""
_NEWEST: Final = "newest.json"
"""Which plan was begun last."""
BOXES_A_FRAME: Final = 12
"""Recordings with more boxes a frame than these count as longer."""


@cache
def programs() -> dict[str, str]:
    """Versions of what results, and the bytes of their files, depend on."""
    return {
        "nvcore": __version__,
        **{name: version(name) for name in ("numba", "numpy", "pandas", "pyarrow", "scipy")},
    }


@dataclass(frozen=True)
class Batch:
    """Recordings that are compared together.

    Attributes
    ----------
    key
        Hash of all that its results depend on.
    recordings
        Their names, in the order of the names.
    n_frames
        Of all of them.
    inputs
        Hash of what is compared, by which programs: the key without the settings.
    """

    key: str
    recordings: tuple[str, ...]
    n_frames: int
    inputs: str


@dataclass(frozen=True)
class Plan:
    """A scan as it is to be done: what of the store is compared, how, and in which batches.

    Attributes
    ----------
    store
        Its URI.
    versions
        Of the store's tables.
    params
        Of the comparison.
    programs
        See `programs`.
    batches
        In the order in which their recordings were taken into the store.
    left_out
        Number of recordings that a system lacks, by the system.
    """

    store: str
    versions: dict[str, int]
    params: ScanParams
    programs: dict[str, str]
    batches: tuple[Batch, ...]
    left_out: dict[str, int]

    @property
    def key(self) -> str:
        """Hash of all of it."""
        return _hash(self.to_json())

    @property
    def n_frames(self) -> int:
        """Frames of all batches."""
        return sum(batch.n_frames for batch in self.batches)

    def to_json(self) -> bytes:
        """All of it as JSON."""
        known = {**asdict(self), "params": self.params.given()}
        return json.dumps(known, sort_keys=True).encode()

    @classmethod
    def from_json(cls, text: bytes) -> Plan:
        """The plan that was written as JSON."""
        known = json.loads(text)
        params = ScanParams.parse(known.pop("params"))
        batches = [
            Batch(**{**batch, "recordings": tuple(batch["recordings"])})
            for batch in known.pop("batches")
        ]
        return cls(params=params, batches=tuple(batches), **known)

    def check_programs(self) -> None:
        """Refuse to work on it with other programs.

        Raises
        ------
        InputError
            If a version differs.
        """
        here = programs()
        others = [
            f"{name} {self.programs.get(name)} (here: {own})"
            for name, own in here.items()
            if self.programs.get(name) != own
        ]
        if others:
            raise InputError(
                f"this scan was begun with {listed(others)}; all workers need the same versions. "
                "Install these, or write the results of the new ones elsewhere"
            )


def plan(
    snapshot: Snapshot,
    params: ScanParams,
    store: str,
    *,
    frames_per_batch: int = FRAMES_PER_BATCH,
) -> Plan:
    """The batches of a scan; the same store gives the same plan.

    A batch ends where the hash of a recording's name says so, if it is half full, and where it
    would be too large: recordings that are added or changed move few of the others into another
    batch, and a batch that has the same recordings as before need not be done again.

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
            file=store,
        )
    chosen = np.flatnonzero(is_compared)
    size = np.maximum(recordings["n_rows"].to_numpy(), n_boxes / BOXES_A_FRAME)[chosen]
    hashes = [int(_hash(name)[:8], 16) / 2**32 for name in names.iloc[chosen]]
    may_end = np.array(hashes) < size / (frames_per_batch / 4)
    starts, total = [0], 0.0
    for i, n in enumerate(size):  # each end depends on the one before: a loop over recordings
        if total and total + n > frames_per_batch:
            starts.append(i)
            total = 0.0
        total += n
        if total >= frames_per_batch / 2 and may_end[i] and i + 1 < len(size):
            starts.append(i + 1)
            total = 0.0
    used = programs()
    lines = ["\0".join(line) for line in zip(*(of.iloc[chosen] for of in facts), strict=True)]
    batches = []
    for lo, hi in zip(starts, [*starts[1:], len(size)], strict=True):
        rows = recordings.iloc[chosen[lo:hi]]
        inputs = _hash("\n".join([json.dumps(used), *sorted(lines[lo:hi])]))
        batches.append(
            Batch(
                _hash(params.key + inputs),
                tuple(sorted(rows["recording"])),
                int(rows["n_rows"].sum()),
                inputs,
            )
        )
    return Plan(store, dict(snapshot.versions), params, used, tuple(batches), left_out)


def begin(store: Store, out: Location, params: ScanParams, **plan_options: Any) -> Plan:
    """The plan of a scan of the store as it is now, written to the folder of the results.

    Raises
    ------
    InputError
        If the same scan was begun with other programs and is not finished.
    """
    made = plan(store.snapshot(), params, store.location.uri, **plan_options)
    newest = newest_plan(out)
    if newest is None or newest.key != made.key:
        is_same = newest is not None and (newest.store, newest.params) == (made.store, params)
        if newest is not None and is_same and not is_finished(out, newest):
            newest.check_programs()
        out.write(_path_of(made.key), made.to_json())
        out.write(_NEWEST, json.dumps({"plan": made.key}).encode())
    return made


def tables_in(out: Location) -> dict[str, Any] | None:
    """What `SUMMARY` says of the tables of results; None: no scan was finished."""
    content = out.find(SUMMARY)
    tables: dict[str, Any] | None = None if content is None else json.loads(content)
    return tables


def plan_shown(out: Location) -> Plan | None:
    """The plan that the tables of results are of; without any the one that was begun last."""
    tables = tables_in(out)
    return newest_plan(out) if tables is None else plan_in(out, tables["plan"])


def newest_plan(out: Location) -> Plan | None:
    """The plan that was begun last; None: there is none."""
    content = out.find(_NEWEST)
    return None if content is None else plan_in(out, json.loads(content)["plan"])


def plan_in(out: Location, key: str) -> Plan | None:
    """The plan of this key; None: it is not there."""
    content = out.find(_path_of(key))
    return None if content is None else Plan.from_json(content)


def is_finished(out: Location, its_plan: Plan) -> bool:
    """Whether the tables of results were written."""
    return out.find(f"finished/{its_plan.key}.json") is not None


def _path_of(key: str) -> str:
    return f"plans/{key}.json"


def _hash(text: str | bytes) -> str:
    content = text.encode() if isinstance(text, str) else text
    return hashlib.sha256(content).hexdigest()[:32]
