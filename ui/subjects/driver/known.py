"""Estimates of the driver's view in this session, and the known light."""

from __future__ import annotations

from pathlib import Path
from typing import Final, NamedTuple

import pandas as pd

from nvcore.common.errors import NvcoreError
from nvcore.common.records import decode
from nvcore.comparison.compare import Result
from nvcore.inputs.session import Session
from nvcore.subjects.driver.filter import as_the_driver_sees
from nvcore.subjects.driver.illumination import LightSettings
from nvcore.subjects.driver.illumination.clock import AdaptationClock
from nvcore.subjects.driver.running.estimate import EstimateRun
from nvcore.subjects.driver.running.run import RecordingFeatures
from ui.session import state
from ui.session.opening import public_text, recording_entry
from ui.subject import MadeFile
from ui.subjects.driver.confined import EstimatorSpec, clock_by_meter
from ui.widgets.drawing import Sight, VisiblePictures

ESTIMATES: Final = (
    "What was estimated on the page Driver: in each frame, how detectable each {one} is",
    "How that was estimated; both lie beside session.toml, which names them",
)
RUN: Final = "driver_estimates"
"""Workspace key of the run whose estimates were opened."""
MOST_CLOCKS: Final = 50


class OpenedRun(NamedTuple):
    """Run whose estimates were opened.

    Attributes
    ----------
    named
        Path of the estimates' file in the session.
    run
        Results of the run.
    spec
        The estimator, as a file that stays as long as the estimates.
    files
        Files for people: features, estimates and their record.
    """

    named: str
    run: EstimateRun
    spec: EstimatorSpec
    files: tuple[Path, ...]


def opened_run() -> OpenedRun | None:
    """Return the run behind the open session's estimates, or None if they come from elsewhere."""
    run: OpenedRun | None = state.workspace().notes.get(RUN)
    named = state.opened().session.driver.detectability
    return run if run is not None and run.named == named else None


def features_of(recording: int) -> pd.DataFrame | None:
    """Return the features of a recording's pedestrians, or None if unknown.

    Returns
    -------
    `FEATURE_COLUMNS`, and ``estimate``: estimated detectability, 0..1, NaN if there is none.
    """
    part, known = part_of(recording), opened_run()
    if part is None or known is None:
        return None
    own = known.run.table
    estimate = own.loc[own["recording"] == part.name_in_data, "detectability"]
    return part.table.assign(estimate=estimate.to_numpy())


def clock_of(recording: int) -> AdaptationClock | None:
    """Return light and adaptation in the frames of a recording, or None if the light is unknown.

    The clock is that of this session's run, or else from the recording's light meter, with the
    settings of `recorded_light` or our defaults.
    """
    part = part_of(recording)
    clock = _cached_by_meter(recording) if part is None else part.clock
    return None if isinstance(clock, str) else clock


def made_files(session: Session, portable: Session) -> dict[str, MadeFile]:
    """Return the estimate files made by the app, by their names in the session to be written."""
    if opened_run() is None:
        return {}
    files = zip(vars(session.driver).values(), vars(portable.driver).values(), strict=True)
    made = {name: session.folder / path for path, name in files if path is not None}
    return {
        name: MadeFile(path, text)
        for (name, path), text in zip(made.items(), ESTIMATES, strict=False)
    }


def _add_light(recording: int, visible: VisiblePictures) -> VisiblePictures:
    """Add the known changes of light in the recording to its visible-light pictures."""
    clock = clock_of(recording)
    if clock is None:
        return visible
    return visible._replace(seen_s=clock.seen_s, change_s=clock.change_s)


def _trouble(recording: int) -> str:
    """Return why the recording's light meter cannot be used, without paths, or "" if it can."""
    trouble = _cached_by_meter(recording) if part_of(recording) is None else None
    if not isinstance(trouble, str):
        return ""
    return f"How long ago the light has changed is not known: {trouble}"


def caution_of(result: Result) -> str:
    """Return why the estimates are doubtful, such as simulated subjects, or "" without a reason."""
    record = result.dataset.of("driver")
    return "" if record is None else record.caution


def is_estimated(result: Result, recording: int) -> bool:
    """Whether the detectability in a recording comes from an estimator with a known name."""
    record, name = result.dataset.of("driver"), result.dataset.recordings["name"].iloc[recording]
    return record is not None and bool(record.made_by) and name in record.estimated_in


def recorded_light() -> LightSettings | None:
    """Return the criteria for a change of light behind the estimates, or None if unknown."""
    record = state.opened().dataset.of("driver")
    if record is None or not record.light:
        return None
    try:
        return decode(LightSettings, record.light, "settings of the light", complete=True)
    except ValueError:  # of another version, or edited by hand: treated as unknown
        return None


def may_be_another_clock(recording: int) -> bool:
    """Whether estimates may rest on another clock than `clock_of` shows."""
    dataset = state.opened().dataset
    is_of_file = dataset.of("driver") is not None and part_of(recording) is None
    return is_of_file and recorded_light() is None and clock_of(recording) is not None


def part_of(recording: int) -> RecordingFeatures | None:
    """Return the opened run's results for a recording, or None if it was not estimated."""
    known = opened_run()
    if known is None:
        return None
    names = state.recording_names()
    name = recording_entry(state.opened().session, names, names[recording]).name
    parts = known.run.features.recordings
    return next((part for part in parts if part.name_in_data == name), None)


def _cached_by_meter(recording: int) -> AdaptationClock | str | None:
    return state.cached("driver_clock", recording, lambda: _by_meter(recording), most=MOST_CLOCKS)


def _by_meter(recording: int) -> AdaptationClock | str | None:
    """Return the clock from the light meter, or why its file is unusable, or None without one."""
    session, names = state.opened().session, state.recording_names()
    path = recording_entry(session, names, names[recording]).light
    if path is None:
        return None
    frames = state.opened().dataset.frame_columns
    numbers, fps = frames.frame[frames.rows_of(recording)], float(frames.fps[recording])
    try:
        settings = recorded_light() or LightSettings()
        return clock_by_meter(session.folder / path, numbers, fps, settings)
    except NvcoreError as error:
        return public_text(error, (session.folder,))


SIGHT: Final = Sight(
    label="As the driver sees it",
    hint="As the driver sees it after the light has changed: contrast and sharpness come back "
    "while the eyes adapt (a model with numbers of ours)",
    add_light=_add_light,
    trouble=_trouble,
    show=as_the_driver_sees,
)
