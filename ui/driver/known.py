"""What the session has estimated of the driver's view, and what is known of the light."""

from __future__ import annotations

from pathlib import Path
from typing import Final, NamedTuple

import pandas as pd

from nvcore.comparison import Result
from nvcore.driver.estimate import EstimateRun
from nvcore.driver.filter import as_the_driver_sees
from nvcore.driver.illumination import LightSettings
from nvcore.driver.illumination.clock import AdaptationClock
from nvcore.driver.run import RecordingFeatures
from nvcore.errors import NvcoreError
from nvcore.inputs.session import Session
from nvcore.records import decode
from ui.driver.confined import EstimatorSpec, clock_by_meter
from ui.session import state
from ui.session.opening import public_text, recording_entry
from ui.subjects import MadeFile
from ui.widgets.drawing import Sight, VisiblePictures

ESTIMATES: Final = (
    "What was estimated on the page Driver: in each frame, how detectable each {one} is",
    "How that was estimated; both lie beside session.toml, which names them",
)
RUN: Final = "driver_estimates"
"""What the workspace remembers of the run whose estimates were opened."""
MOST_CLOCKS: Final = 50


class OpenedRun(NamedTuple):
    """A run whose estimates were opened.

    Attributes
    ----------
    named
        How the session names the file of the estimates.
    run
        What came out.
    spec
        The estimator, as a file that stays as long as the estimates.
    files
        What was written for people: features, estimates and the record of how they were made.
    """

    named: str
    run: EstimateRun
    spec: EstimatorSpec
    files: tuple[Path, ...]


def opened_run() -> OpenedRun | None:
    """The run that the open session's estimates come from; None: they come from elsewhere."""
    run: OpenedRun | None = state.workspace().notes.get(RUN)
    named = state.opened().session.driver.detectability
    return run if run is not None and run.named == named else None


def features_of(recording: int) -> pd.DataFrame | None:
    """Features of the pedestrians of a recording; None: not known.

    Returns
    -------
    `FEATURE_COLUMNS`, and ``estimate``: detectability by the estimator, 0..1, NaN: it says none.
    """
    part, known = part_of(recording), opened_run()
    if part is None or known is None:
        return None
    own = known.run.table
    estimate = own.loc[own["recording"] == part.name_in_data, "detectability"]
    return part.table.assign(estimate=estimate.to_numpy())


def clock_of(recording: int) -> AdaptationClock | None:
    """Light and adaptation in the frames of a recording; None: nothing is known of the light.

    By the run of this session, else by the recording's light meter, with the settings of
    `recorded_light`, else our defaults.
    """
    part = part_of(recording)
    clock = _cached_by_meter(recording) if part is None else part.clock
    return None if isinstance(clock, str) else clock


def made_files(session: Session, portable: Session) -> dict[str, MadeFile]:
    """Files of the estimates that the app has made, by their names in the session to be written."""
    if opened_run() is None:
        return {}
    files = zip(vars(session.driver).values(), vars(portable.driver).values(), strict=True)
    made = {name: session.folder / path for path, name in files if path is not None}
    return {
        name: MadeFile(path, text)
        for (name, path), text in zip(made.items(), ESTIMATES, strict=False)
    }


def _add_light(recording: int, visible: VisiblePictures) -> VisiblePictures:
    """Pictures of visible light with the changes of light that are known in the recording."""
    clock = clock_of(recording)
    if clock is None:
        return visible
    return visible._replace(seen_s=clock.seen_s, change_s=clock.change_s)


def _trouble(recording: int) -> str:
    """Why the file of a recording's light meter cannot be used, without paths; empty: it can."""
    trouble = _cached_by_meter(recording) if part_of(recording) is None else None
    if not isinstance(trouble, str):
        return ""
    return f"How long ago the light has changed is not known: {trouble}"


def caution_of(result: Result) -> str:
    """Why the estimates are to be doubted, such as simulated subjects; empty: no reason."""
    record = result.dataset.of("driver")
    return "" if record is None else record.caution


def is_estimated(result: Result, recording: int) -> bool:
    """Whether detectability in a recording is by an estimator whose name is known."""
    record, name = result.dataset.of("driver"), result.dataset.recordings["name"].iloc[recording]
    return record is not None and bool(record.made_by) and name in record.estimated_in


def recorded_light() -> LightSettings | None:
    """What counted as a change of light where the estimates were made; None: nobody says it."""
    record = state.opened().dataset.of("driver")
    if record is None or not record.light:
        return None
    try:
        return decode(LightSettings, record.light, "settings of the light", complete=True)
    except ValueError:  # of another version, or by hand: as if it said nothing
        return None


def may_be_another_clock(recording: int) -> bool:
    """Whether estimates may rest on another clock than `clock_of` shows beside them."""
    dataset = state.opened().dataset
    is_of_file = dataset.of("driver") is not None and part_of(recording) is None
    return is_of_file and recorded_light() is None and clock_of(recording) is not None


def part_of(recording: int) -> RecordingFeatures | None:
    """What the opened run has of a recording; None: it was not among those that were estimated."""
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
    """By the light meter; why its file cannot be used; None: there is none."""
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
