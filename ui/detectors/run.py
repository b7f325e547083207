"""Detectors page: the detector over recordings, in the background, as a system to compare."""

from __future__ import annotations

import os
from collections.abc import Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Final

import streamlit as st

from nvcore.dataset import Dataset
from nvcore.dataset.provenance import About, TrainedOn
from nvcore.detectors.registry import DETECTORS
from nvcore.detectors.run import run_detector
from nvcore.detectors.timing import Expectation, expect
from nvcore.detectors.writing import WrittenRun, write_detections
from nvcore.pictures import RecordingPictures
from nvcore.progress import Progress
from nvcore.wording import MOST_NAMED, listed
from ui.detectors import finished
from ui.detectors.asking import described, key_of, trained_recordings
from ui.detectors.confined import ConfinedDetector, DetectorFacts, DetectorSpec
from ui.detectors.finished import FOLDER, RUN, OnScreen, RunJob, RunKey
from ui.detectors.trial import Levels, levels_of
from ui.jobs.background import BackgroundJob, JobState, while_open
from ui.jobs.progress import draw_job
from ui.jobs.runs import new_run_folder
from ui.session import state
from ui.session.opening import live_session
from ui.session.uploads import ANNOTATION_FOLDERS
from ui.session.workspace import Workspace
from ui.widgets.buttons import button
from ui.widgets.text import plain

TIMING: Final = "detector_timing"
HEADER: Final = "Run it over the recordings"
SHARE_OF_CORES: Final = 2
"""One picture for so many cores at a time, each in one thread: the others are for visitors."""


def draw(spec: DetectorSpec, what: DetectorFacts) -> OnScreen:
    """Which recordings, how long that will take, and the button that runs it there."""
    st.header(HEADER)
    chosen = _choose_recordings(trained_recordings(what.about))
    trained_on = _ask_for_training(what.about)
    on_screen = OnScreen(RunKey(spec, chosen), levels_of(spec, what))
    about = replace(what.about, trained_on=(*what.about.trained_on, *trained_on))
    _draw_trained(chosen, about)
    job: RunJob | None = state.workspace().job(RUN)
    if chosen:
        is_busy = job is not None and job.is_busy
        _draw_start(on_screen.key, about, on_screen.levels, is_busy=is_busy)
    else:
        st.info("Choose a recording.")
    return on_screen


def draw_last(on_screen: OnScreen | None) -> None:
    """The run that is under way or done, whatever is chosen by now; None: that cannot be run."""
    job: RunJob | None = state.workspace().job(RUN)
    if job is None:
        return
    if on_screen is None:
        st.header(HEADER)
    doing = f"Running {job.key}"
    if draw_job(job, RUN, thing="run", doing=doing, with_steps=True) is JobState.DONE:
        finished.draw(job, on_screen)


def _choose_recordings(seen: Sequence[str]) -> tuple[str, ...]:
    """Names of the recordings that the detector is to be run on.

    Parameters
    ----------
    seen
        Those that it was trained on: they are not chosen at first, unless there is no other.
    """
    names, pictures = state.recording_names(), state.workspace().pictures.sources
    usable = [name for number, name in enumerate(names) if number in pictures]
    unseen = [name for name in usable if name not in seen]
    first = unseen or usable
    chosen = st.multiselect(
        "Recordings",
        usable,
        first,
        key=f"detector_recordings_{state.workspace().n_opened}_{key_of(usable, first)}",
        persist_state="session",
        help="The new comparison is of these recordings alone. Those that the detector was trained "
        "on are not chosen at first.",
    )
    if len(usable) < len(names):
        without = [name for name in names if name not in usable]
        st.caption(
            f"Without pictures, so left out: {plain(', '.join(without[:5]))}"
            f"{f' and {len(without) - 5} more' if len(without) > 5 else ''}."
        )
    return tuple(name for name in usable if name in chosen)


def _ask_for_training(about: About) -> list[TrainedOn]:
    """Recordings that it was trained on, where it does not say so itself."""
    known = {part.recording for part in about.trained_on}
    chosen = st.multiselect(
        "Also trained on (if the model does not say so)",
        [name for name in state.recording_names() if name not in known],
        key=f"detector_trained_{state.workspace().n_opened}",
        persist_state="session",
        placeholder="none of these recordings",
        help="The audit then says that the detector is scored on what it has learned from.",
    )
    return [TrainedOn(recording=name) for name in chosen]


def _draw_trained(chosen: Sequence[str], about: About) -> None:
    """Which of the chosen recordings the detector was trained on."""
    seen = [name for name in trained_recordings(about) if name in chosen]
    if seen:
        is_all = len(seen) == len(chosen)
        part = "all that is chosen" if is_all else f"{len(seen):,} of these {len(chosen):,}"
        st.caption(
            f":material/warning: Trained on {part}: {plain(listed(seen, most=MOST_NAMED))}. "
            "Figures on them say nothing of others."
        )


def as_run(spec: DetectorSpec, about: About, levels: Levels) -> DetectorSpec:
    """The detector with the overlap as it is set, and boxes as low as either threshold."""
    name = DETECTORS[about.kind].threshold
    own = about.settings[name]
    assert isinstance(own, int | float)
    lowest = min(float(own), levels.threshold)
    changes = {"overlap": levels.overlap, name: lowest}
    return spec.with_settings(
        {name: value for name, value in changes.items() if value != about.settings[name]}
    )


def _draw_start(key: RunKey, about: About, levels: Levels, *, is_busy: bool) -> None:
    """The button that times the run; once that is done, how long it takes and its own button."""
    timing: BackgroundJob[Expectation] | None = state.workspace().job(TIMING)
    is_timed = timing is not None and timing.key == key
    if not is_timed and button(
        "How long will it take?",
        icon=":material/timer:",
        key="time_detector",
        type="primary",
        disabled=is_busy,
    ):
        _start_timing(key, about)
        st.rerun()
    if timing is None or not is_timed:
        return
    if draw_job(timing, TIMING, thing="estimate", doing="Timing it") is not JobState.DONE:
        if not timing.is_busy:
            drop = partial(state.workspace().drop_job, TIMING)
            st.button("Try again", key="drop_timing", on_click=drop)
        return
    assert timing.output is not None
    st.markdown(f"**{plain(str(timing.output))}**")
    if (
        button(
            "Run the detector",
            icon=":material/play_arrow:",
            key="run_detector",
            type="primary",
            disabled=is_busy,
        )
        and not is_busy
    ):  # a browser can be made to click what is disabled
        _start_run(key, about, levels)
        st.rerun()
    st.caption(
        "It goes on while you look at other pages. Opening something else, or changing what is "
        "compared, ends it."
    )


def _start_timing(key: RunKey, about: About) -> None:
    space = state.workspace()
    detector = ConfinedDetector(key.spec, about)
    pictures = _pictures(space, key.recordings)

    def work(progress: Progress) -> Expectation:
        try:
            return expect(detector, pictures, n_threads=n_threads(), progress=progress)
        finally:
            detector.close()

    space.put_job(TIMING, BackgroundJob(work, while_open(space), key=key))


def n_threads() -> int:
    """Pictures at a time."""
    return max(1, (os.cpu_count() or 1) // SHARE_OF_CORES)


def _pictures(space: Workspace, names: tuple[str, ...]) -> RecordingPictures:
    """The pictures of these recordings, numbered as in a dataset of them alone."""
    rows = [number for number, name in enumerate(state.recording_names()) if name in names]
    return space.pictures.renumbered({row: number for number, row in enumerate(rows)})


def _start_run(key: RunKey, about: About, levels: Levels) -> None:
    space, opened = state.workspace(), state.opened()
    x, y = state.systems()
    session = live_session(opened.session, opened.dataset, state.params(), x=x, y=y)
    dataset = opened.dataset.with_settings(session)
    if set(key.recordings) != set(state.recording_names()):
        dataset = dataset.only(names=key.recordings)
    pictures = _pictures(space, key.recordings)
    folder = new_run_folder(space, session, RUN, FOLDER)
    job = start_job(space, key, about, levels, dataset, pictures, folder, x)
    space.put_job(RUN, job)


def start_job(
    space: Workspace,
    key: RunKey,
    about: About,
    levels: Levels,
    dataset: Dataset,
    pictures: RecordingPictures,
    folder: Path,
    x: str,
) -> RunJob:
    """Start; it ends with the session, and when the session opens something else."""
    spec = as_run(key.spec, about, levels)
    # the record is of the detector that ran, whose settings and fingerprint are its own
    about = replace(described(spec).about, trained_on=about.trained_on)
    detector = ConfinedDetector(spec, about)

    def work(progress: Progress) -> WrittenRun:
        try:
            run = run_detector(
                detector, dataset, pictures, n_threads=n_threads(), progress=progress
            )
            return write_detections(
                run, dataset, folder / ANNOTATION_FOLDERS, threshold=levels.threshold, against=x
            )
        finally:
            detector.close()

    return RunJob(space, folder, OnScreen(key, levels), work, name=about.name)
