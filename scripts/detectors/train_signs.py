"""Train a detector of speed limits on real signs, and evaluate it on held-out signs.

    python -m scripts.detectors.train_signs [--model FILE] [--evaluate] [--left-out FILE]

The script trains on the scenes and crops of `sign_data.py` (about ten minutes on two free cores),
and writes the model and the names of examples left out because they resemble a sign of a test
scene: crops, and with `--strict` scenes as well. `--evaluate` only measures an existing model.
`--reader` only trains and measures the classifier of limits (half a minute), and puts it into an
existing model. The data are in `$NVCORE_REALDATA`. They are licensed for research only, so the
models do not ship.
"""

from __future__ import annotations

import argparse
from dataclasses import replace
from pathlib import Path

from nvcore.subjects.detectors.icf import AS_IN_REPORT, SIGNS, read_model, write_model
from scripts.detectors.sign_data import CHOOSING, TESTED, held_out, read_crops, read_scenes
from scripts.detectors.sign_examples import examples, train_signs
from scripts.detectors.sign_measures import LEAST_PX, measure, rejected
from scripts.detectors.sign_reading import reading_in_truth, train_reader
from scripts.realdata import realdata

LOWEST = -1e6
"""Threshold below the score of every window that passes the cascade."""

PRESETS = {"signs": SIGNS, "as-in-report": AS_IN_REPORT}


def main() -> None:
    """Train, write and measure."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--model", type=Path, default=Path("signs.npz"))
    parser.add_argument("--left-out", type=Path, default=Path("left_out.txt"))
    parser.add_argument("--evaluate", action="store_true")
    parser.add_argument(
        "--choosing", action="store_true", help="leave out and measure on what settings are for"
    )
    parser.add_argument(
        "--reader",
        action="store_true",
        help="train and measure the classifier of limits alone, and put it into the model",
    )
    parser.add_argument(
        "--strict", action="store_true", help="no scenes with a sign like one tested, either"
    )
    parser.add_argument("--preset", choices=PRESETS, default="signs", help="settings to train with")
    options = parser.parse_args()
    folder = realdata()
    if options.reader:
        reader = train_reader(folder)
        if options.model.is_file():
            write_model(replace(read_model(options.model).model, classifier=reader), options.model)
        print(*reading_in_truth(folder, reader), sep="\n")
        return
    if not options.evaluate:
        of = examples(folder, choosing=options.choosing, strict=options.strict)
        model = train_signs(of, PRESETS[options.preset])
        write_model(model, options.model)
        options.left_out.write_text("".join(f"{name}\n" for name in sorted(of.alike)))
        print(f"{len(of.alike)} crops and scenes with a sign that resembles one of a test scene: "
              f"{options.left_out}")  # fmt: skip
        print(f"{model.n_objects} windows of objects, {model.n_background} of background")
    detector = read_model(options.model).run_with(threshold=LOWEST)
    scenes = read_scenes(folder / "gtsdb" / "train")
    if options.choosing:
        chosen = [scene for scene in scenes if scene.number % 4 == CHOOSING]
        print("for choosing settings:", measure(chosen, detector))
        return
    tested = [scene for scene in scenes if scene.number % 4 == TESTED]
    print(f"signs of {LEAST_PX} px and more:", measure(tested, detector))
    print("as in the report:", measure(read_scenes(folder / "gtsdb" / "report"), detector))
    _, crops = held_out(read_crops(folder / "gtsrb"))
    print(f"rejected of {len(crops)} crops held out: {rejected(crops, detector)}")
    reader = detector.model.classifier
    if reader is not None:
        print(*reading_in_truth(folder, reader), sep="\n")


if __name__ == "__main__":
    main()
