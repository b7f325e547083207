"""Write a set as nvcore's CSV or Parquet with a session file, for the dashboard.

python -m bench.csv_files N FOLDER [--one-recording] [--parquet]
"""

from __future__ import annotations

import argparse
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.csv
import pyarrow.parquet

from bench.sets import FPS, FRAMES_PER_RECORDING, HEIGHT, WIDTH, Boxes, BoxSet, make_set

INPUTS = """\
[truth]
path = "truth.csv"
format = "csv"
frame_base = 0

[[system]]
name = "first"
path = "x.csv"
format = "csv"
frame_base = 0

[[system]]
name = "second"
path = "y.csv"
format = "csv"
frame_base = 0
"""
"""Truth and systems of a session file beside the files written by `write_csv`."""
SESSION = """\
[defaults]
size = "{width}x{height}"
fps = {fps:g}
frames = "0:{last}"
"""
DECIMALS = 2


def write_csv(
    boxes: BoxSet, folder: Path, *, one_recording: bool = False, ending: str = "csv"
) -> Path:
    """Write truth.csv (or .parquet), x.csv, y.csv and session.toml, and return the session file.

    The last recording must be complete, because all have the same list of frames.
    """
    length = boxes.n_frames if one_recording else min(FRAMES_PER_RECORDING, boxes.n_frames)
    folder.mkdir(parents=True, exist_ok=True)
    sources = zip(("truth", "x", "y"), (boxes.truth, *boxes.systems), strict=True)
    for name, source in sources:
        write = pa.csv.write_csv if ending == "csv" else pa.parquet.write_table
        write(_table(source, name, length), folder / f"{name}.{ending}")
    path = folder / "session.toml"
    text = SESSION.format(width=WIDTH, height=HEIGHT, fps=FPS, last=length - 1)
    path.write_text(f"{text}\n{INPUTS.replace('csv', ending)}", encoding="utf-8")
    return path


def _table(source: Boxes, name: str, length: int) -> pa.Table:
    recording, frame = np.divmod(source.frame_index, length)
    names = pa.array([f"r{i:04d}" for i in range(int(recording[-1]) + 1)])
    columns = {
        "recording": pa.DictionaryArray.from_arrays(recording.astype(np.int32), names).cast(
            pa.string()
        ),
        "frame": frame,
        **{key: np.round(getattr(source, key), DECIMALS) for key in ("x", "y", "w", "h")},
    }
    columns |= {"track": source.track} if name == "truth" else {"score": source.score.round(3)}
    return pa.table(columns)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("n_frames", type=int)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--one-recording", action="store_true")
    parser.add_argument("--parquet", action="store_true")
    options = parser.parse_args()
    write_csv(
        make_set(options.n_frames),
        options.folder,
        one_recording=options.one_recording,
        ending="parquet" if options.parquet else "csv",
    )


if __name__ == "__main__":
    main()
