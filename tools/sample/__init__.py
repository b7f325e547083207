"""Sample data: a generated night drive with truth, two simulated systems and pictures.

scene, body, camera     people and their paths in three dimensions
places, recordings      the ten recordings
truth, systems          boxes, and the detections of two systems
canvas, backdrop, objects, vehicles, people, render     pictures
writing, ratings        files, and simulated ratings
visible/                the same drives in visible light at dusk
speed_signs             a second sample: drives past speed signs
study/                  a simulated study: who sees a pedestrian after the light changed
"""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

import pandas as pd

from nvcore.common.progress import Progress, no_progress
from nvcore.subjects.ratings.reading import RATINGS_FILE
from tools.sample.ratings import ratings_text, simulate_ratings
from tools.sample.recordings import all_recordings
from tools.sample.render import pictures
from tools.sample.scene import Recording
from tools.sample.speed_signs import FOLDER as SIGNS_FOLDER
from tools.sample.speed_signs import write_speed_signs
from tools.sample.study.scenes import FOLDER as STUDY_FOLDER
from tools.sample.study.writing import write_study
from tools.sample.systems import detections
from tools.sample.truth import sightings, truth_table
from tools.sample.visible.recordings import GLOWS, light_file, light_text, visible_file
from tools.sample.visible.render import visible_pictures
from tools.sample.visible.view import VISIBLE_SIZE
from tools.sample.writing import (
    SYSTEM_FILES,
    TRUTH_FILE,
    csv_text,
    readme_text,
    session_text,
    write_colour_video,
    write_video,
)

__all__ = ["all_recordings", "generate", "tables"]


def tables(recordings: Iterable[Recording]) -> dict[str, pd.DataFrame]:
    """Return truth and detections of recordings, one table per file name.

    The same recordings give the same tables on every call.
    """
    parts: dict[str, list[pd.DataFrame]] = {TRUTH_FILE: []}
    parts |= {path: [] for path in SYSTEM_FILES.values()}
    for recording in recordings:
        visible = sightings(recording)
        parts[TRUTH_FILE].append(truth_table(recording, visible))
        for name, path in SYSTEM_FILES.items():
            parts[path].append(detections(recording, visible, system=name))
    return {path: pd.concat(part, ignore_index=True) for path, part in parts.items()}


def generate(folder: Path, *, progress: Progress = no_progress) -> None:
    """Write the sample data into a folder, replacing files of the same names.

    Parameters
    ----------
    folder
        Folder, created if it does not exist.
    progress
        Called with the name of the next recording, and with an empty name at the end.
    """
    folder.mkdir(parents=True, exist_ok=True)
    recordings = all_recordings()
    sample_tables = tables(recordings)
    for path, table in sample_tables.items():
        (folder / path).write_bytes(csv_text(table).encode())
    session = folder / "session.toml"
    session.write_bytes(session_text(recordings).encode())
    (folder / RATINGS_FILE).write_bytes(ratings_text(simulate_ratings(session)).encode())
    (folder / "README.md").write_bytes(readme_text(recordings, sample_tables[TRUTH_FILE]).encode())
    lit = [recording for recording in recordings if recording.name in GLOWS]
    n_steps = len(recordings) + len(lit) + 2
    for n_done, recording in enumerate(recordings):
        progress(n_done / n_steps, recording.name)
        write_video(folder / f"{recording.name}.mp4", pictures(recording))
    for n_done, recording in enumerate(lit, start=len(recordings)):
        progress(n_done / n_steps, visible_file(recording))
        (folder / light_file(recording)).write_bytes(light_text(recording).encode())
        frames = visible_pictures(recording, GLOWS[recording.name])
        write_colour_video(folder / visible_file(recording), frames, VISIBLE_SIZE)
    progress((n_steps - 2) / n_steps, STUDY_FOLDER)
    write_study(folder)
    progress((n_steps - 1) / n_steps, SIGNS_FOLDER)
    write_speed_signs(folder)
    progress(1.0, "")
