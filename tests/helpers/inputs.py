"""Small input files for tests, and the command line called within the process."""

from __future__ import annotations

from pathlib import Path

from click.testing import CliRunner, Result

from nvcore.cli import main
from nvcore.dataset import Dataset
from nvcore.inputs.session import Session, Source, SystemSource

FACTS = ("--size", "640x480", "--fps", "20")
TRUTH = "frame,x,y,w,h,track"
DETECTIONS = "frame,x,y,w,h,score"


def nvcore(*arguments: object) -> Result:
    """Run the command line; errors that no user can mend are raised."""
    result = CliRunner().invoke(main, [str(part) for part in arguments])
    if result.exception is not None and not isinstance(result.exception, SystemExit):
        raise result.exception
    return result


def write(path: Path, *lines: str) -> Path:
    """A text file of these lines."""
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    return path


def drive(folder: Path) -> Path:
    """truth.csv, fir.csv and nir.csv: one pedestrian in each of two recordings, 20 frames.

    FIR detects both throughout, NIR the one of "urban" from frame 10 on and has a false alarm.
    """
    truth, fir, nir = (["recording,frame,x,y,w,h," + last] for last in ("track", "score", "score"))
    for recording, x in (("urban", 100), ("rural", 300)):
        for frame in range(20):
            box = f"{recording},{frame},{x + 3 * frame},200,40,{100 + frame}"
            truth.append(f"{box},1")
            fir.append(f"{box},{0.9 - frame / 100:.2f}")
            if recording == "urban" and frame >= 10:
                nir.append(f"{box},{0.5 + frame / 100:.2f}")
    nir.append("rural,4,500,200,40,100,0.65")
    for name, lines in (("truth", truth), ("fir", fir), ("nir", nir)):
        write(folder / f"{name}.csv", *lines)
    return folder


def flags(folder: Path, *more: object) -> list[str]:
    """Flags that compare the systems of `drive`."""
    files = ("--truth", folder / "truth.csv", "--x", folder / "fir.csv", "--y", folder / "nir.csv")
    return [str(part) for part in (*files, *FACTS, *more)]


def mot_layout(folder: Path, names: tuple[str, ...] = ("A", "B")) -> Path:
    """Recordings of 5 frames in MOTChallenge's layout; the last frame has no truth."""
    for name in names:
        rows = [f"{frame},1,{11 + frame},21,30,60" for frame in (1, 2, 3, 4)]
        write(folder / name / "gt" / "gt.txt", *(f"{row},1,1,1" for row in rows))
        write(folder / name / "det" / "det.txt", *(f"{row},0.9,-1,-1,-1" for row in rows))
        facts = ("frameRate=10", "seqLength=5", "imWidth=640", "imHeight=480")
        write(folder / name / "seqinfo.ini", "[Sequence]", f"name={name}", *facts)
    return folder


def one_box(folder: Path, *rows: str) -> Path:
    """A truth of one pedestrian in frames 0 to 9, and these detections."""
    write(folder / "truth.csv", TRUTH, *(f"{frame},100,200,40,100,1" for frame in range(10)))
    write(folder / "fir.csv", DETECTIONS, *rows)
    return folder


def session_of(
    folder: Path, truth: str = "truth.csv", *systems: str | SystemSource, **facts: object
) -> Session:
    """A session in memory; size and fps are given unless said otherwise."""
    sources = [SystemSource((system,)) if isinstance(system, str) else system for system in systems]
    chosen = {"size": (640, 480), "fps": 20.0, **facts}
    default = (SystemSource(("fir.csv",)), SystemSource(("nir.csv",)))
    return Session(folder, Source((truth,)), tuple(sources) or default, **chosen)


def boxes_of(dataset: Dataset, number: int) -> list[list[float]]:
    """x, y, w, h of the boxes of the truth (0) or of a system (1, 2, ...)."""
    boxes = dataset.boxes[dataset.boxes["source"] == number]
    return boxes[["x", "y", "w", "h"]].to_numpy().tolist()
