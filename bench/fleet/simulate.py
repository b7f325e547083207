"""Simulate the time of large scans from measured costs.

Workers process one batch after the other: they read it from shared storage, compare it for as long
as a random measured batch took, and write its results. Then one process finishes. Costs of programs
are measured (`bench.fleet`), those of storage and machines are assumed.
"""

from __future__ import annotations

import heapq
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any, Final

import numpy as np

FRAMES_PER_RECORDING: Final = 2_000
SEED: Final = 37


@dataclass(frozen=True)
class Storage:
    """Assumptions about storage and machines: a cloud object store.

    Attributes
    ----------
    total, each
        Bandwidth in bytes per second, of all workers together and of one.
    request_s
        Latency of a request.
    requests
        Requests of a worker per batch: lease, files of the store, results, list of finished
        batches.
    slow, times
        Share of batches on a slow machine, and its slowdown factor.
    """

    total: float = 12.5e9
    each: float = 1e8
    request_s: float = 0.03
    requests: int = 25
    slow: float = 0.01
    times: float = 5.0


LOCAL: Final = Storage(np.inf, np.inf, 0.0, 0, 0.0, 1.0)
"""The disk of the measurement, whose cost is included in the time of a batch."""


@dataclass(frozen=True)
class Costs:
    """Measured costs: seconds per batch, per worker start, and once."""

    frame_s: np.ndarray  # per frame, of each batch
    batch: float  # frames on average
    start_s: float
    read: float  # bytes per frame
    written: float
    plan_s: float  # per recording, once
    open_s: float  # per recording and worker
    plan_bytes: float  # per recording
    memory: float  # of a worker, bytes per recording
    finish_s: tuple[float, float]  # per batch, and constant; once


def costs_of(known: dict[str, Any]) -> Costs:
    """Derive costs from results of `bench.fleet`: largest size with one worker, and metadata."""
    largest = known["sizes"][max(known["sizes"], key=int)]
    scan, ingest, metadata = largest["scan, 1"], largest["ingest"], known["metadata"]
    at, n_frames = np.array(scan["done_at_s"]).T
    frame_s = np.diff(at) / n_frames[1:]
    start_s = at[0] - scan["begin_s"] - scan["open_s"] - n_frames[0] * np.median(frame_s)
    of_recording = [metadata[of] for of in ("begin_s", "open_s", "plan_bytes", "memory")]
    return Costs(
        frame_s,
        scan["frames"] / scan["batches"],
        max(float(start_s), 0.0),
        ingest["bytes"] / ingest["frames"],
        scan["bytes"] / scan["frames"],
        *(of / metadata["recordings"] for of in of_recording),
        _finishing([of["scan, 1"] for of in known["sizes"].values()]),
    )


def _finishing(scans: Sequence[dict[str, Any]]) -> tuple[float, float]:
    """Fit a line to seconds of finishing: per batch, and constant."""
    n, seconds = ([of[name] for of in scans] for name in ("batches", "finish_s"))
    if len(scans) == 1:
        return seconds[0] / n[0], 0.0
    slope, at_all = np.polyfit(n, seconds, 1)
    return max(float(slope), 0.0), max(float(at_all), 0.0)


def simulate(
    costs: Costs,
    storage: Storage,
    n_frames: float,
    workers: int,
    rng: np.random.Generator,
    *,
    times: float = 1.0,
    stores: int = 1,
) -> dict[str, float]:
    """Simulate the seconds from the store to the summary, with their parts.

    Parameters
    ----------
    times
        Batch size relative to the measured ones.
    stores
        Number of stores into which the fleet is divided, each with its own scan and share of the
        workers. Joining their results is not included.
    """
    n_frames, workers = n_frames / stores, max(workers // stores, 1)
    n = max(round(n_frames / (times * costs.batch)), 1)
    recordings = n_frames / FRAMES_PER_RECORDING
    took = rng.choice(costs.frame_s, n) * (n_frames / n)
    took = took * np.where(rng.random(n) < storage.slow, storage.times, 1.0)
    took += storage.requests * storage.request_s
    plan_s = costs.plan_s * recordings
    # listings of finished batches return a thousand names at a time
    pages_s = n / 1000 * storage.request_s
    open_s = costs.open_s * recordings + costs.plan_bytes * recordings / storage.each + 4 * pages_s
    ready = plan_s + costs.start_s + open_s
    free = [ready] * workers
    size, storage_at, waited = (costs.read + costs.written) * n_frames / n, 0.0, 0.0
    for seconds in took:  # the first idle worker takes the next batch
        now = heapq.heappop(free)
        storage_at = max(storage_at, now) + size / storage.total
        moved = max(storage_at, now + size / storage.each)
        waited += moved - now - size / storage.each
        heapq.heappush(free, moved + seconds)
    of_batch, at_all = costs.finish_s
    last, finish_s = max(free), at_all + n * (of_batch + 2 * storage.request_s / 16)
    return {
        "total": last + finish_s,
        "metadata": ready,
        "storage": max(waited / workers, 0.0),
        "tail": last - float(np.median(free)),
        "finish": finish_s,
        "memory": costs.memory * recordings,
    }


def predicted(
    costs: Costs, storage: Storage, n_frames: float, workers: int
) -> tuple[float, float, float]:
    """Return low, middle and high seconds (95 %) over random draws of the measured batches."""
    totals = []
    for seed in range(200):
        rng = np.random.default_rng([SEED, seed])
        drawn = replace(costs, frame_s=rng.choice(costs.frame_s, len(costs.frame_s)))
        totals.append(simulate(drawn, storage, n_frames, workers, rng)["total"])
    low, middle, high = np.percentile(totals, [2.5, 50, 97.5])
    return float(low), float(middle), float(high)
