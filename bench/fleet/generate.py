"""Generate a reproducible synthetic fleet of any size. Larger fleets begin with the smaller ones.

    python -m bench.fleet.generate FRAMES STORE [--processes 2]

Boxes are those of `bench.sets`, in recordings of 1,000 to 3,000 frames. Eight recordings each
belong to one car by day or night. At night its NIR (Y) sees pedestrians later and loses them more
often, while its FIR (X) is unaffected. Parts are appended as `nvcore ingest` appends sessions.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor
from functools import partial
from multiprocessing import get_context
from pathlib import Path
from typing import Final

import numpy as np
import pandas as pd

from bench.sets import COLUMNS, FPS, HEIGHT, SEED, WIDTH, Boxes, draw_detections, draw_walkers
from nvcore.dataset import Dataset
from nvcore.dataset.tables import dataset_from_tables
from nvcore.subjects.fleet.ingest import ingest_all
from nvcore.subjects.fleet.store import Store

RECORDINGS_PER_PART: Final = 8
ROADS: Final = ("urban", "rural", "motorway")
CARS: Final = 40


def draw_part(part: int) -> Dataset:
    """Draw the recordings of one car, about 16,000 frames."""
    rng = np.random.default_rng([SEED, 37, part])
    lengths = rng.integers(1_000, 3_001, RECORDINGS_PER_PART)
    is_night = rng.random() < 0.4
    truth, track, age = draw_walkers(lengths, rng)
    x = draw_detections(truth, track, age, rng, late=3.0, drop=0.06, clutter=rng.uniform(0.1, 0.5))
    late, drop = (14.0, 0.14) if is_night else (6.0, 0.05)
    y = draw_detections(truth, track, age, rng, late=late, drop=drop, clutter=rng.uniform(0.2, 0.5))
    night = ("night",) if is_night else ()
    roads = rng.integers(0, len(ROADS), RECORDINGS_PER_PART)
    first = part * RECORDINGS_PER_PART
    recordings = pd.DataFrame(
        {
            "name": [f"r{first + number:07}" for number in range(RECORDINGS_PER_PART)],
            "width": WIDTH,
            "height": HEIGHT,
            "fps": FPS,
            "unit": f"car {part % CARS:02}",
            "tags": pd.Series([(*night, f"road={ROADS[road]}") for road in roads], dtype=object),
        }
    )
    sources: tuple[Boxes, ...] = (truth, x, y)
    boxes = pd.DataFrame(
        {name: np.concatenate([getattr(source, name) for source in sources]) for name in COLUMNS}
    )
    boxes[["x", "y", "w", "h"]] = boxes[["x", "y", "w", "h"]].round(2)  # the precision of files
    boxes["score"] = boxes["score"].round(3)
    boxes["source"] = np.repeat([0, 1, 2], [len(source) for source in sources])
    boxes.loc[boxes["source"] == 0, "score"] = np.nan
    boxes.loc[boxes["source"] > 0, "track"] = -1  # a detector has no tracks
    frames = [np.arange(length) for length in lengths]
    return dataset_from_tables(recordings, frames, boxes, ["FIR", "NIR"], fingerprint=str(part))


def parts_of(n_frames: int) -> Iterator[int]:
    """Yield the part numbers of a fleet with at least this many frames."""
    n, part = 0, 0
    while n < n_frames:
        rng = np.random.default_rng([SEED, 37, part])
        n += int(rng.integers(1_000, 3_001, RECORDINGS_PER_PART).sum())
        yield part
        part += 1


def fill(uri: str, parts: list[int]) -> int:
    """Append parts to a store and return their number of frames."""
    n = 0

    def drawn(part: int) -> Dataset:
        nonlocal n
        dataset = draw_part(part)
        n += len(dataset.frames)
        return dataset

    done = ingest_all(((f"part {part}", partial(drawn, part)) for part in parts), Store(uri))
    assert not done.errors, done.errors
    return n


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("frames", type=float)
    parser.add_argument("store", type=Path)
    parser.add_argument("--processes", type=int, default=1)
    options = parser.parse_args()
    parts = [*parts_of(int(options.frames))]
    shares = [parts[i :: options.processes] for i in range(options.processes)]
    with ProcessPoolExecutor(options.processes, get_context("spawn")) as pool:
        n = sum(pool.map(partial(fill, str(options.store)), shares))
    print(f"{n:,} frames in {len(parts) * RECORDINGS_PER_PART:,} recordings in {options.store}")


if __name__ == "__main__":
    main()
