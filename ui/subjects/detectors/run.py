"""Detectors page: the detector run over recordings, as a system to compare."""

from __future__ import annotations

import io
import zipfile
from collections.abc import Sequence
from contextlib import closing
from dataclasses import replace
from typing import Final, NamedTuple

import streamlit as st

from nvcore.common.errors import NvcoreError
from nvcore.common.progress import Progress
from nvcore.common.wording import MOST_NAMED, listed, minus
from nvcore.dataset import Dataset
from nvcore.dataset.provenance import About, TrainedOn
from nvcore.inputs.session import Session
from nvcore.pictures import RecordingPictures
from nvcore.subjects.detectors.registry import DETECTORS
from nvcore.subjects.detectors.running.run import Expectation, expect, run_detector
from nvcore.subjects.detectors.running.writing import WrittenRun, write_detections
from ui.access.files import safe_name
from ui.confined.process import N_THREADS
from ui.jobs.background import BackgroundJob, JobState
from ui.jobs.page_run import PageRun, dataset_of, named_in, open_written
from ui.session import state, store
from ui.session.uploads import ANNOTATION_FOLDERS
from ui.shell.messages import shown_error
from ui.shell.navigate import ask_for_page
from ui.subjects.detectors.asking import described, key_of, trained_recordings
from ui.subjects.detectors.confined import ConfinedDetector, DetectorFacts, DetectorSpec
from ui.subjects.detectors.trial import Levels, levels_of
from ui.widgets.buttons import button, download
from ui.widgets.text import docs_link, plain

RUN: Final = PageRun[WrittenRun](
    "detector_run", "run", "Running {title}", folder="detector", outlasts=True, has_time_left=True
)
TIMING: Final = PageRun[Expectation]("detector_timing", "estimate", "Timing it")
HEADER: Final = "Run it over the recordings"
BEFORE: Final = "detector_before"


class Before(NamedTuple):
    """Session that was open before a run was compared. That comparison has number `n_opened`."""

    n_opened: int
    session: Session
    label: str


class RunSettings(NamedTuple):
    """Settings of a run, as they are on the page."""

    spec: DetectorSpec
    recordings: tuple[str, ...]
    levels: Levels


def draw(spec: DetectorSpec, what: DetectorFacts) -> RunSettings:
    """Draw the choice of recordings, how long the run takes, and the button that starts it."""
    st.header(HEADER)
    chosen = _choose_recordings(trained_recordings(what.about))
    about = replace(what.about, trained_on=(*what.about.trained_on, *_ask_for_training(what.about)))
    seen = [name for name in trained_recordings(about) if name in chosen]
    if seen:
        is_all = len(seen) == len(chosen)
        part = "all that is chosen" if is_all else f"{len(seen):,} of these {len(chosen):,}"
        st.caption(
            f":material/warning: Trained on {part}: {plain(listed(seen, most=MOST_NAMED))}. "
            "Figures on them say nothing of others."
        )
    settings = RunSettings(spec, chosen, levels_of(spec, what))
    if chosen:
        _draw_start(settings, about)
    else:
        st.info("Choose a recording.")
    return settings


def draw_last(now: RunSettings | None) -> None:
    """Draw the newest run, whatever is chosen now (None: the detector cannot be run)."""
    job = RUN.job
    if job is None:
        return
    if now is None:
        st.header(HEADER)
    if RUN.draw(job) is JobState.DONE:
        _draw_finished(job, now)


def _choose_recordings(seen: Sequence[str]) -> tuple[str, ...]:
    """Ask for the recordings of the run. Those of the training are not chosen at first."""
    names, pictures = state.recording_names(), state.workspace().pictures.sources
    usable = [name for number, name in enumerate(names) if number in pictures]
    first = [name for name in usable if name not in seen] or usable
    chosen = st.multiselect(
        "Recordings",
        usable,
        first,
        key=f"detector_recordings_{state.workspace().n_opened}_{key_of(usable, first)}",
        persist_state="session",
        help="The new comparison is of these recordings alone. Those that the detector was trained "
        "on are not chosen at first.",
    )
    without = [name for name in names if name not in usable]
    if without:
        st.caption(
            f"Without pictures, so left out: {plain(', '.join(without[:5]))}"
            f"{f' and {len(without) - 5} more' if len(without) > 5 else ''}."
        )
    return tuple(name for name in usable if name in chosen)


def _ask_for_training(about: About) -> list[TrainedOn]:
    """Ask for recordings that it was trained on, beside those that it states itself."""
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


def _draw_start(settings: RunSettings, about: About) -> None:
    """Draw the button that times the run, then how long it takes and the button that runs it."""
    timing, key = TIMING.job, settings[:2]
    if timing is None or timing.key != key:
        if RUN.start_button("How long will it take?", "timer", "time_detector", type="primary"):
            _start_timing(settings, about)
            st.rerun()
        return
    if TIMING.draw(timing) is not JobState.DONE:
        if not timing.is_busy:
            st.button("Try again", key="drop_timing", on_click=TIMING.drop)
        return
    st.markdown(f"**{plain(str(timing.output))}**")
    if RUN.start_button("Run the detector", "play_arrow", "run_detector", type="primary"):
        _start(settings, about)
        st.rerun()
    st.caption(
        "It goes on while you look at other pages. Opening something else, or changing what is "
        "compared, ends it."
    )


def _start_timing(settings: RunSettings, about: About) -> None:
    pictures = _pictures(settings.recordings)

    def work(progress: Progress) -> Expectation:
        with closing(ConfinedDetector(settings.spec, about)) as detector:
            return expect(detector, pictures, n_threads=N_THREADS, progress=progress)

    TIMING.start(work, key=settings[:2])


def _pictures(names: tuple[str, ...]) -> RecordingPictures:
    """Return the pictures of these recordings, numbered as in a dataset of them alone."""
    rows = [number for number, name in enumerate(state.recording_names()) if name in names]
    return state.workspace().pictures.renumbered({row: number for number, row in enumerate(rows)})


def _start(settings: RunSettings, about: About) -> None:
    levels, against = settings.levels, state.systems()[0]
    # boxes as low as either threshold, for the curves
    threshold = DETECTORS[about.kind].threshold
    own = about.settings[threshold]
    assert isinstance(own, int | float)
    changes = {"overlap": levels.overlap, threshold: min(float(own), levels.threshold)}
    spec = settings.spec.with_settings(
        {name: value for name, value in changes.items() if value != about.settings[name]}
    )
    # the record is of the detector that ran, whose settings and fingerprint are its own
    about = replace(described(spec).about, trained_on=about.trained_on)
    dataset, pictures = dataset_of(settings.recordings), _pictures(settings.recordings)
    folder = RUN.new_folder()

    def work(progress: Progress) -> WrittenRun:
        with closing(ConfinedDetector(spec, about)) as detector:
            run = run_detector(detector, dataset, pictures, n_threads=N_THREADS, progress=progress)
        target = folder / ANNOTATION_FOLDERS
        return write_detections(run, dataset, target, threshold=levels.threshold, against=against)

    RUN.start(work, key=settings, title=about.name, folder=folder)


def _draw_finished(job: BackgroundJob[WrittenRun], now: RunSettings | None) -> None:
    """Draw the output of a run, the button that compares it, and its files."""
    written, started = job.output, job.key
    assert written is not None
    first, *others = str(written.run).splitlines()
    names = listed(
        [part.name for part in written.run.recordings if len(part.frames)], most=MOST_NAMED
    )
    st.success(
        f"**{plain(written.name)}**: {plain(first)}. Run over {plain(names)}.",
        icon=":material/check_circle:",
    )
    if now is not None and (differences := differences_of(started, now)):
        st.info(
            "It was run with other settings than those now on screen: "
            f"{plain(listed(differences))}.",
            icon=":material/info:",
        )
    if others:
        st.warning(plain(" ".join(others)), icon=":material/warning:")
    left, right = st.columns([1, 1])
    if button(
        f"Compare with {plain(state.systems()[0])}",
        icon=":material/arrow_forward:",
        key="compare_detector",
        type="primary",
        at=left,
    ):
        _open(job, written)
    download(
        "Boxes and how they were made (ZIP)",
        lambda: packed(written),
        f"{safe_name(written.name)}.zip",
        key="download_detector",
        at=right,
    )
    link = docs_link("how", "never-scored-on-its-training-in-silence", doc="detectors")
    st.caption(
        f"It becomes Y, at the threshold {_number(started.levels.threshold)}: where the slider "
        "stood when the run was started. With its boxes goes the record of how they were made: the "
        f"audit says where it was trained on what it is scored on ({link})."
    )


def differences_of(started: RunSettings, now: RunSettings) -> list[str]:
    """Return the settings of a run that differ from the current ones, in words."""
    before, after = started.spec, now.spec
    if (before.text, before.version) != (after.text, after.version):
        return ["another detector"]
    names = {name for name, _ in {*before.settings} ^ {*after.settings}}
    differences = [name.replace("_", " ") for name in sorted(names)]
    for name, value in vars(started.levels).items():
        value_now = getattr(now.levels, name)
        if value != value_now:
            differences.append(f"{name} {_number(value)} (now {_number(value_now)})")
    if started.recordings != now.recordings:
        differences.append("recordings")
    return differences


def _number(value: float) -> str:
    return minus(f"{value:.4g}")


def packed(written: WrittenRun) -> bytes:
    """Return the files of a run as a ZIP archive."""
    content = io.BytesIO()
    with zipfile.ZipFile(content, "w", zipfile.ZIP_DEFLATED) as archive:
        for path in (*written.files, written.provenance):
            archive.write(path, path.name)
    return content.getvalue()


def _open(job: BackgroundJob[WrittenRun], written: WrittenRun) -> None:
    """Add the new system to what is open, as Y."""
    opened, space, live = state.opened(), state.workspace(), state.live_session()
    session = with_system(live, opened.dataset, written, x=state.systems()[0])
    ask_for_page("overview")
    is_moved = state.params() != state.session_params()
    before = live if is_moved else opened.session
    space.notes[BEFORE] = Before(space.n_opened + 1, before, opened.label)
    label = f"{opened.label}, with {written.name}"
    try:
        open_written(space, job, lambda: state.open_session(session, label=label))
    except NvcoreError as error:
        store.NEXT_PAGE.pop()
        space.notes.pop(BEFORE, None)
        st.error(shown_error(error), icon=":material/error:")


def draw_way_back() -> None:
    """Draw the button that reopens what was open before the run was compared, while that is."""
    space = state.workspace()
    before: Before | None = space.notes.get(BEFORE)
    if before is None or before.n_opened != space.n_opened:
        return
    if button(
        f"Back to {plain(before.label)}",
        icon=":material/arrow_back:",
        key="before_detector",
        help="Opens what was open before the run was compared.",
    ):
        try:
            state.open_session(before.session, label=before.label)
        except NvcoreError as error:
            st.error(shown_error(error), icon=":material/error:")


def with_system(session: Session, dataset: Dataset, written: WrittenRun, *, x: str) -> Session:
    """Return the session with the new system as its last one and as Y."""
    *path, provenance = (named_in(session, file) for file in (*written.files, written.provenance))
    system = replace(written.system, path=tuple(path), provenance=provenance)
    others = [  # a new system must not change their names
        replace(source, name=own)
        for source, own in zip(session.systems, dataset.systems, strict=True)
    ]
    names = tuple(part.name for part in written.run.recordings)
    is_part = {*names} != {*dataset.recordings["name"]}
    return replace(
        session,
        systems=(*others, system),
        x=x,
        y=written.name,
        only=names if is_part else session.only,
    )
