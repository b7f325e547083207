"""Measure the effect of each setting of the speed-sign detector on accuracy and time.

    python -m scripts.detectors.sign_ablation [--out docs/validation.md]

The script trains a small model on half of the training scenes and crops, again with one setting
changed, and measures each on the scenes for choosing settings. The test scenes are not used.
Settings of a run are changed without another training. It takes about fifty minutes on two free
cores. Data as for `scripts.detectors.train_signs`.
"""

from __future__ import annotations

import argparse
from collections.abc import Mapping
from dataclasses import dataclass, fields, replace
from pathlib import Path
from time import process_time
from typing import Any, Final

from nvcore.metrics.detection import scale_steps
from nvcore.subjects.detectors.icf import AS_IN_REPORT, SIGNS, IcfDetector, IcfSettings
from scripts.detectors.sign_data import CHOOSING, SignScene, read_scenes
from scripts.detectors.sign_examples import Examples, examples, train_signs
from scripts.detectors.sign_measures import Measured, measure
from scripts.detectors.train_signs import LOWEST
from scripts.realdata import realdata

BASE: Final = replace(
    SIGNS,
    features=1500,
    trees_per_round=(32, 128, 384),
    negatives=4000,
    negatives_per_round=3000,
    copies=2,
    kept_share=0.98,
    slack=0.0,
)
FEW: Final = -5.0
"""Score threshold for cascades that pass too many windows for suppression."""
SECTION: Final = ("<!-- sign ablation: begin -->", "<!-- sign ablation: end -->")


@dataclass(frozen=True)
class Row:
    """One changed setting.

    Attributes
    ----------
    name
        Description for people.
    trained
        Changed settings of the training.
    run
        Changed settings of the run.
    crops
        Whether the training uses crops.
    seed
        Seed of the training.
    lowest
        Score threshold.
    """

    name: str
    trained: Mapping[str, Any] | None = None
    run: Mapping[str, Any] | None = None
    crops: bool = True
    seed: int = 1
    lowest: float = LOWEST


def _window(side: int) -> dict[str, Any]:
    """Return settings with another window size that finds signs of the same sizes."""
    by = side / BASE.window_width
    return {
        "window_width": side,
        "window_height": side,
        "object_width": BASE.object_width * by,
        "object_height": BASE.object_height * by,
        "scales": tuple(round(scale / by, 4) for scale in BASE.scales),
    }


RIGHT_HALF: Final = (0.5, 0.15, 1.0, 0.15, 1.0, 0.75, 0.5, 0.75)
"""Corners as shares of width and height."""
SMALL_TOO: Final = tuple(round(0.33 * 1.15**i, 4) for i in range(15))
"""Scales for a window of 64 px that find the same sizes as the base with 32 px."""
AS_REPORTED: Final = {spec.name: getattr(AS_IN_REPORT, spec.name) for spec in fields(IcfSettings)}
ROWS: Final = (
    Row("base"),
    Row("base, another seed", {}, seed=2),
    Row("no mining (one round, as many trees)", {"trees_per_round": (384,), "negatives": 10_000}),
    Row("no crops", {}, crops=False),
    Row("300 features", {"features": 300}),
    Row("5,000 features", {"features": 5000}),
    Row("half of the features differences", {"difference_share": 0.5}),
    Row("grey instead of LUV", {"channels": ("grey", "magnitude", "orientations")}),
    Row("RGB instead of LUV", {"channels": ("rgb", "magnitude", "orientations")}),
    Row("HSV instead of LUV", {"channels": ("hsv", "magnitude", "orientations")}),
    Row("LUV alone", {"channels": ("luv",)}),
    Row("gradients alone", {"channels": ("magnitude", "orientations")}),
    Row("orientations over the full circle", {"full_circle": True}),
    Row("CLAHE, clip limit 4", {"clahe_clip": 4.0}),
    Row("no blur", {"blur": False}),
    Row("window of 24 px", _window(24)),
    Row("window of 48 px", _window(48)),
    Row("small objects not learned from shrunk ones", {"least_object_px": 0.0}),
    Row("all settings as in the report", AS_REPORTED),
    Row("as in the report, scales for small signs", {**AS_REPORTED, "scales": SMALL_TOO}),
    Row("cascade: calibrated, all objects pass", {"kept_share": 1.0}, lowest=FEW),
    Row(
        "cascade: calibrated, all pass with some room",
        {"kept_share": 1.0, "slack": SIGNS.slack},
        lowest=FEW,
    ),
    Row("cascade: constant, -1", run={"cascade": "constant", "rejection": -1.0}),
    Row("cascade: constant, -5", run={"cascade": "constant", "rejection": -5.0}),
    Row("cascade: hard, by stages", run={"cascade": "hard"}),
    Row("no cascade", run={"cascade": "none"}, lowest=FEW),
    Row("stride 2", run={"stride": 2}),
    Row("stride 6", run={"stride": 6}),
    Row("stride 10", run={"stride": 10}),
    Row("scales in steps of 1.3", run={"scales": tuple(0.66 * 1.3**i for i in range(8))}),
    Row("scales 1.0 to 1.7, as in the report", run={"scales": scale_steps(1.0, 1.7, 0.1)}),
    Row("every other scale approximated", run={"scales_between": 1}),
    Row("suppression at 10 %", run={"overlap": 0.1}),
    Row("suppression at 50 % of the union", run={"overlap_of": "union"}),
    Row("only where training signs lay", run={"use_band": True}),
    Row("polygon: the right half, no sky, no bonnet", run={"region": RIGHT_HALF}),
    Row("only windows with red", run={"proposals": "red"}),
)
"""Each setting that the report names as an improvement, and our additional ones."""


def ablation(of: Examples, scenes: list[SignScene]) -> list[str]:
    """Return the table as Markdown rows. Seconds are processor time summed over cores."""
    lines = [
        "| | PR-AUC | 95 % interval | missed at a precision of 95 % | windows a scene "
        "| features a window | s a scene | training, s |",
        "|---|---|---|---|---|---|---|---|",
    ]
    base: IcfDetector | None = None
    for row in ROWS:
        start = process_time()
        if row.run is None:
            settings = replace(BASE, **(row.trained or {}))
            sample = of if row.crops else replace(of, crops=[])
            detector = IcfDetector(train_signs(sample, settings, seed=row.seed))
        else:
            assert base is not None
            detector = base.run_with(**row.run)
        seconds = process_time() - start
        base = base or detector
        measured = measure(scenes, detector.run_with(threshold=row.lowest))
        lines.append(_line(row, measured, None if row.run is not None else seconds))
        print(lines[-1], flush=True)
    return lines


def _line(row: Row, m: Measured, seconds: float | None) -> str:
    training = "–" if seconds is None else f"{seconds:.0f}"
    return (
        f"| {row.name} | {m.area:.3f} | {m.low:.3f} to {m.high:.3f} | {m.missed} of {m.n_signs} | "
        f"{m.windows:,.0f} | {m.features:.1f} | {m.seconds:.2f} | {training} |"
    )


def main() -> None:
    """Print the table, and write it between its markers."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--out", type=Path)
    options = parser.parse_args()
    folder = realdata()
    every = examples(folder, choosing=True)
    of = replace(every, scenes=every.scenes[::2], crops=every.crops[::2])
    scenes = read_scenes(folder / "gtsdb" / "train")
    table = ablation(of, [scene for scene in scenes if scene.number % 4 == CHOOSING])
    if options.out is not None:
        begin, end = SECTION
        before, _, rest = options.out.read_text().partition(begin)
        after = rest.partition(end)[2]
        body = "\n".join(table)
        options.out.write_text(f"{before}{begin}\n\n{body}\n\n{end}{after}")


if __name__ == "__main__":
    main()
