"""Detectors page: the detector over recordings, in the background, as a system to compare."""

from __future__ import annotations

import io
import os
import zipfile
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Final

import streamlit as st

from nvcore.dataset import Dataset
from nvcore.dataset.provenance import About, TrainedOn
from nvcore.detectors.registry import DETECTORS
from nvcore.detectors.run import run_detector
from nvcore.detectors.timing import Expectation, expect
from nvcore.detectors.writing import WrittenRun, write_detections
from nvcore.errors import NvcoreError
from nvcore.inputs.session import Session
from nvcore.pictures import RecordingPictures
from nvcore.progress import Progress
from nvcore.wording import MOST_NAMED, listed
from ui.confined.detectors import ConfinedDetector, DetectorFacts, DetectorSpec
from ui.detectors.asking import described, key_of
from ui.detectors.training import trained_recordings
from ui.detectors.trial import Levels, levels_of
from ui.jobs.background import BackgroundJob, JobState, while_open
from ui.jobs.progress import draw_job
from ui.jobs.runs import FolderJob, is_uploaded, new_run_folder, open_written
from ui.session import state
from ui.session.opening import live_session, relative_path
from ui.session.uploads import ANNOTATION_FOLDERS, safe_name
from ui.session.workspace import Workspace
from ui.shell.messages import shown_error
from ui.shell.navigate import ask_for_page
from ui.widgets.text import docs_link, plain

TIMING: Final = "detector_timing"
RUN: Final = "detector_run"
FOLDER: Final = "detector"
SHARE_OF_CORES: Final = 2
"""One picture for so many cores at a time, each in one thread: the others are for visitors."""


@dataclass(frozen=True)
class RunKey:
    """What is run on which recordings: what its time depends on."""

    spec: DetectorSpec
    recordings: tuple[str, ...]


class RunJob(FolderJob[WrittenRun]):
    """A run.

    Attributes
    ----------
    threshold
        Of the new system.
    """

    def __init__(
        self,
        space: Workspace,
        folder: Path,
        threshold: float,
        work: Callable[[Progress], WrittenRun],
        *,
        key: str,
    ):
        """Start to run; see `FolderJob`. `key` is the name."""
        self.threshold = threshold
        super().__init__(space, folder, work, key=key)


def draw(spec: DetectorSpec, what: DetectorFacts) -> None:
    """Which recordings, how long that will take, the run, and the way to its comparison."""
    st.header("Run it over the recordings")
    chosen = _choose_recordings(trained_recordings(what.about))
    trained_on = _ask_for_training(what.about)
    levels = levels_of(spec, what)
    key = RunKey(spec, chosen)
    about = replace(what.about, trained_on=(*what.about.trained_on, *trained_on))
    _draw_trained(chosen, about)
    job: RunJob | None = state.workspace().job(RUN)
    is_busy = job is not None and job.is_busy
    if chosen:
        _draw_start(key, about, levels, is_busy=is_busy)
    else:
        st.info("Choose a recording.")
    if job is not None:
        doing = f"Running {job.key}"
        if draw_job(job, RUN, thing="run", doing=doing, with_steps=True) is JobState.DONE:
            _draw_done(job)


def _choose_recordings(seen: Sequence[str]) -> tuple[str, ...]:
    """Names of the recordings that the detector is to be run on.

    Parameters
    ----------
    seen
        Those that it was trained on: they are not chosen at first, unless there is no other.
    """
    names, pictures = state.recording_names(), state.workspace().pictures
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
        "Trained on, where the model does not say so itself",
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
        st.caption(
            f":material/warning: Trained on {len(seen):,} of these {len(chosen):,}: "
            f"{plain(listed(seen, most=MOST_NAMED))}. Figures on them say nothing of others."
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
    if not is_timed and st.button(
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
            st.button("Try again", key="drop_timing", on_click=_drop_timing)
        return
    assert timing.output is not None
    st.markdown(f"**{plain(str(timing.output))}**")
    if (
        st.button(
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


def _drop_timing() -> None:
    state.workspace().drop_job(TIMING)


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
    number_of = {row: number for number, row in enumerate(rows)}
    return RecordingPictures(
        {number_of[row]: space.pictures[row] for row in rows},
        {number_of[row]: space.picture_rows[row] for row in rows},
        notes={number_of[row]: space.picture_notes.get(row, "") for row in rows},
    )


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

    return RunJob(space, folder, levels.threshold, work, key=about.name)


def _draw_done(job: RunJob) -> None:
    """What came out, the button that compares it, and the files."""
    written = job.output
    assert written is not None
    first, *others = str(written.run).splitlines()
    names = listed(
        [part.name for part in written.run.recordings if len(part.frames)], most=MOST_NAMED
    )
    st.success(
        f"**{plain(written.name)}**: {plain(first)}. Run over {plain(names)}.",
        icon=":material/check_circle:",
    )
    if others:
        st.warning(plain(" ".join(others)), icon=":material/warning:")
    left, right = st.columns([1, 1])
    if left.button(
        f"Compare with {plain(state.systems()[0])}",
        icon=":material/arrow_forward:",
        key="compare_detector",
        type="primary",
    ):
        _open(job, written)
    right.download_button(
        "Boxes and how they were made (ZIP)",
        lambda: packed(written),
        f"{safe_name(written.name)}.zip",
        "application/zip",
        on_click="ignore",
        icon=":material/download:",
        key="download_detector",
    )
    link = docs_link("how", "never-scored-on-its-training-in-silence", doc="detectors")
    st.caption(
        "It becomes Y. With its boxes goes the record of how they were made: the audit says where "
        f"it was trained on what it is scored on ({link})."
    )


def packed(written: WrittenRun) -> bytes:
    """The files of a run as an archive."""
    content = io.BytesIO()
    with zipfile.ZipFile(content, "w", zipfile.ZIP_DEFLATED) as archive:
        for path in (*written.files, written.provenance):
            archive.write(path, path.name)
    return content.getvalue()


def _open(job: RunJob, written: WrittenRun) -> None:
    """Go on with what is open, and the new system as Y."""
    opened, label = state.opened(), state.opened().label
    space = state.workspace()
    x, y = state.systems()
    live = live_session(opened.session, opened.dataset, state.params(), x=x, y=y)
    session = with_system(
        live,
        opened.dataset,
        written,
        x=x,
        threshold=job.threshold,
        is_upload=is_uploaded(space, live),
    )
    ask_for_page("overview")
    try:
        open_written(space, job, session, label=f"{label}, with {written.name}")
    except NvcoreError as error:
        st.session_state.pop("wanted_page", None)
        st.error(shown_error(error), icon=":material/error:")


def with_system(
    session: Session,
    dataset: Dataset,
    written: WrittenRun,
    *,
    x: str,
    threshold: float,
    is_upload: bool,
) -> Session:
    """The session as it is shown, with the new system as its last one and as Y.

    Parameters
    ----------
    is_upload
        Whether its files are uploads, and those of the system lie beside them: they are then named
        from its folder.
    """

    def named(path: Path) -> str:
        return relative_path(path, session.folder) if is_upload else str(path)

    system = replace(
        written.system,
        path=tuple(map(named, written.files)),
        threshold=threshold,
        provenance=named(written.provenance),
    )
    others = [  # their names do not change with the files of another
        replace(source, name=own)
        for source, own in zip(session.systems, dataset.systems, strict=True)
    ]
    names = tuple(part.name for part in written.run.recordings)
    is_part = set(names) != set(dataset.recordings["name"])
    return replace(
        session,
        systems=(*others, system),
        x=x,
        y=written.name,
        only=names if is_part else session.only,
    )
