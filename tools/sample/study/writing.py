"""Files of the simulated study: pictures, boxes, trials, and the model's truth."""

from __future__ import annotations

from pathlib import Path

import pandas as pd

from nvcore.common.progress import Progress, no_progress
from tools.sample.study.scenes import BOXES_FILE, FOLDER, N_PICTURES, all_scenes, boxes_table, jpeg
from tools.sample.study.trials import (
    TRIALS_FILE,
    TRUTH_FILE,
    simulated_trials,
    trials_text,
    truth_rows,
)


def write_study(folder: Path, *, progress: Progress = no_progress) -> None:
    """Write the pictures into ``study`` of a folder, and the simulated trials beside it."""
    (folder / FOLDER).mkdir(exist_ok=True)
    scenes = list(all_scenes())
    boxes = boxes_table(scenes)
    parts = []
    for number, scene in enumerate(scenes):
        progress(number / N_PICTURES, scene.image)
        pictures = scene.pictures()
        (folder / FOLDER / scene.image).write_bytes(jpeg(pictures[0]))
        parts.append(truth_rows(scene.image, scene.box(), pictures))
    truth = pd.concat(parts, ignore_index=True)
    (folder / FOLDER / BOXES_FILE).write_bytes(table_text(boxes).encode())
    (folder / TRUTH_FILE).write_bytes(table_text(truth).encode())
    trials = simulated_trials(truth, boxes)
    (folder / TRIALS_FILE).write_bytes(trials_text(trials).encode())


def table_text(table: pd.DataFrame) -> str:
    """Return a table as CSV with line feeds."""
    return str(table.to_csv(index=False, lineterminator="\n"))
