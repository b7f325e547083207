"""Compute features of all pedestrians in recordings, in one pass over the pictures."""

from __future__ import annotations

from dataclasses import dataclass

import pandas as pd

from nvcore.dataset import Dataset
from nvcore.driver.recording import RecordingFeatures, open_recordings
from nvcore.driver.settings import DriverViewSettings
from nvcore.inputs.session import Session
from nvcore.pictures.run import PictureRun, speed_text
from nvcore.progress import Progress, no_progress
from nvcore.wording import MOST_NAMED, count_text, listed, one_line


@dataclass(frozen=True, eq=False, repr=False)
class FeatureRun:
    """Features of the pedestrians in recordings. ``print`` shows the assumptions."""

    recordings: tuple[RecordingFeatures, ...]
    settings: DriverViewSettings
    n_pictures: int
    seconds: float

    @property
    def table(self) -> pd.DataFrame:
        """Rows of all recordings, with the columns `FEATURE_COLUMNS`."""
        tables = [recording.table for recording in self.recordings]
        return pd.concat(tables, ignore_index=True)

    def __repr__(self) -> str:
        return f"<FeatureRun of {self._boxes}>"

    def __str__(self) -> str:
        head = f"{self._boxes}, {speed_text(self.n_pictures, self.seconds)}"
        of_notes: dict[tuple[str, ...], list[str]] = {}
        for recording in self.recordings:
            of_notes.setdefault(recording.notes, []).append(one_line(recording.name))
        parts = [
            f"{listed(names, most=MOST_NAMED)}: {' '.join(notes)}"
            for notes, names in of_notes.items()
        ]
        return "\n".join([head, *parts])

    @property
    def _boxes(self) -> str:
        n_boxes = sum(len(recording.table) for recording in self.recordings)
        return f"{count_text(n_boxes, 'box', 'boxes')} in {count_text(self.n_pictures, 'picture')}"


def run_features(
    dataset: Dataset,
    settings: DriverViewSettings | None = None,
    *,
    n_threads: int | None = None,
    progress: Progress = no_progress,
) -> FeatureRun:
    """Compute features of every pedestrian that is not ignored, in every frame with a picture.

    The table does not depend on the number of threads.

    Parameters
    ----------
    dataset
        Dataset with a `Session` as its settings, which names pictures, gaze and light.
    n_threads, progress
        See `nvcore.pictures.run.PictureRun`.

    Raises
    ------
    InputError
        If a gaze or light file cannot be used, or no evaluated frame has a picture.
    CancelledError
        If `progress` raises it.
    """
    session = dataset.settings
    assert isinstance(session, Session)
    settings = settings or DriverViewSettings()
    recordings = open_recordings(session, dataset, settings)
    try:
        n_pictures = sum(len(recording.rows) for recording in recordings)
        run = PictureRun(n_pictures, progress, n_threads=n_threads)
        parts = [recording.features_in(run) for recording in recordings]
    finally:
        for recording in recordings:
            if recording.pictures is not None:
                recording.pictures.close()
    progress(1.0, "done")
    return FeatureRun(tuple(parts), settings, run.n_done, run.seconds)
