"""Write a synthetic set as MOTChallenge text, in a layout that TrackEval and nvcore both read.

    python -m bench.mot_files SET.npz FOLDER

There is one sequence per recording: ``gt/NAME/seqinfo.ini``, ``gt/NAME/gt/gt.txt`` (nine columns,
class 1), ``trackers/x/data/NAME.txt`` and ``trackers/y/data/NAME.txt`` (ten columns, with track id
and score), and the list of sequences in ``seqmap.txt``. Frames, ids and pixels are 1-based. Boxes
have three decimals, scores six.
"""

from __future__ import annotations

import argparse
from pathlib import Path

import numpy as np

from bench.sets import FPS, HEIGHT, WIDTH, Boxes, BoxSet, load_set

SYSTEMS = ("x", "y")
BOX = "%d,%d,%.3f,%.3f,%.3f,%.3f,"


def write_mot(boxes: BoxSet, folder: Path) -> None:
    """Write truth and both systems to `folder`, which is created."""
    names = [f"r{i:04d}" for i in range(len(boxes.lengths))]
    for name, length in zip(names, boxes.lengths.tolist(), strict=True):
        (folder / "gt" / name / "gt").mkdir(parents=True)
        (folder / "gt" / name / "seqinfo.ini").write_text(
            f"[Sequence]\nname={name}\nimDir=img1\nframeRate={FPS:g}\nseqLength={length}\n"
            f"imWidth={WIDTH}\nimHeight={HEIGHT}\nimExt=.jpg\n"
        )
    (folder / "seqmap.txt").write_text("\n".join(["name", *names]) + "\n")
    # column 7: the box counts. Columns 8 and 9: a pedestrian, fully visible
    truth = [folder / "gt" / name / "gt" / "gt.txt" for name in names]
    _write(boxes.truth, boxes.lengths, truth, BOX + "%d,1,1")
    for system, source in zip(SYSTEMS, boxes.systems, strict=True):
        target = folder / "trackers" / system / "data"
        target.mkdir(parents=True)
        paths = [target / f"{name}.txt" for name in names]
        _write(source, boxes.lengths, paths, BOX + "%.6f,-1,-1,-1")


def _write(source: Boxes, lengths: np.ndarray, paths: list[Path], row: str) -> None:
    ends = np.cumsum(lengths)
    offsets = source.offsets(int(ends[-1]))
    for first, last, path in zip(ends - lengths, ends, paths, strict=True):
        rows = slice(offsets[first], offsets[last])
        columns = (
            source.frame_index[rows] - first + 1, source.track[rows] + 1, source.x[rows] + 1,
            source.y[rows] + 1, source.w[rows], source.h[rows], source.score[rows],
        )  # fmt: skip
        np.savetxt(path, np.column_stack(columns), fmt=row)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("set", type=Path)
    parser.add_argument("folder", type=Path)
    options = parser.parse_args()
    write_mot(load_set(options.set), options.folder)


if __name__ == "__main__":
    main()
