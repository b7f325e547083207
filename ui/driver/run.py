"""Driver page: features and estimates of the open recordings, in the background."""

from __future__ import annotations

import shutil
from collections.abc import Sequence
from pathlib import Path
from typing import Final

import streamlit as st

from nvcore.dataset import Dataset
from nvcore.driver.inputs.record import EstimateRecord
from nvcore.driver.writing import WrittenEstimates, write_estimates
from nvcore.errors import InputError, NvcoreError
from nvcore.progress import Progress
from nvcore.wording import count_text, listed
from ui.driver import estimator, finished
from ui.driver.confined import EstimatorSpec, run_confined
from ui.driver.finished import JOB, EstimateJob
from ui.driver.known import opened_run
from ui.jobs.progress import draw_job, draw_job_aside
from ui.jobs.runs import new_run_folder
from ui.session import state
from ui.session.opening import live_session
from ui.session.uploads import ANNOTATION_FOLDERS, check_room, count_folder, remove_folder
from ui.session.workspace import Workspace
from ui.shell.messages import shown_error, without_paths
from ui.widgets.buttons import button
from ui.widgets.text import docs_link, plain

FOLDER: Final = "driver"
MODEL: Final = "estimator.npz"
TITLE: Final = "Features and estimate"
HOW_LONG: Final = (
    "It looks at every {one} in every frame, and goes on while you look at other pages. The "
    "comparison is then updated, whichever page is open. Opening something else, or changing "
    "what is compared, ends it."
)
COMMANDS: Final = """nvcore driver train trials.csv --features study.csv --out driver.npz
nvcore driver estimate session.toml --model driver.npz --out seen
nvcore app seen/session.toml"""


def draw(*, is_known: bool) -> None:
    """The estimator, the recordings, and the run.

    Parameters
    ----------
    is_known
        Whether there are estimates already: the form is then folded away, unless it is at work.
    """
    job: EstimateJob | None = state.workspace().job(JOB)
    if not is_known:
        st.header(TITLE)
        _draw_form(job)
        return
    with st.expander(f"{TITLE}: choose estimator and recordings", expanded=job is not None):
        _draw_form(job)


def _draw_form(job: EstimateJob | None) -> None:
    spec = estimator.draw()
    chosen = _choose_recordings()
    is_busy = job is not None and job.is_busy
    interpolate = st.checkbox(
        "Interpolate between the estimators of two periods",
        key="driver_interpolate",
        help="Else that of the nearest adaptation period is taken.",
    )
    if (
        button(
            "Estimate",
            icon=":material/visibility:",
            key="driver_estimate",
            type="primary",
            disabled=is_busy or spec is None or not chosen,
        )
        and spec is not None
        and not is_busy
        and chosen
    ):  # a browser can be made to click what is disabled
        try:
            _start(spec, chosen, interpolate=interpolate)
        except NvcoreError as error:
            st.error(shown_error(error), icon=":material/error:")
        else:
            st.rerun()
    if job is None:
        st.caption(state.say(HOW_LONG))
    else:
        _draw_job(job)
    if text := finished.trouble():
        st.error(text, icon=":material/error:")


def _draw_job(job: EstimateJob) -> None:
    doing = "Looking at the pictures"
    job_state = draw_job(job, JOB, thing="estimate", doing=doing, with_steps=True)
    job.is_told = not job_state.is_busy
    if finished.is_waiting(job):
        draw_job_aside(job, doing, until=lambda: finished.is_ready(job))


def draw_notes() -> None:
    """What the open estimates rest on, and the files; nothing where they come from elsewhere."""
    known = opened_run()
    if known is None:
        return
    head, *lines = str(known.run).splitlines()
    with st.expander(f"How it was estimated: {plain(head)}"):
        st.markdown("\n".join(f"- {plain(without_paths(line))}" for line in lines))
        columns = st.columns(3)
        for place, path in zip(columns, known.files, strict=False):
            place.download_button(
                path.name,
                path.read_bytes,
                path.name,
                "application/json" if path.suffix == ".json" else "text/csv",
                on_click="ignore",
                icon=":material/download:",
                key=f"download_{path.stem}",
                width="stretch",
            )
        st.caption(
            f"What the columns mean: {docs_link('the files', 'the-files', doc='driver-reference')}."
        )


def _choose_recordings() -> tuple[str, ...]:
    """Those with pictures; at first those with pictures of visible light, where there are any."""
    space, names = state.workspace(), state.recording_names()
    visible = [names[number] for number in sorted(space.visible.sources)]
    usable = [
        name
        for number, name in enumerate(names)
        if number in space.visible.sources or number in space.pictures.sources
    ]
    chosen = st.multiselect(
        "Recordings",
        usable,
        visible or usable,
        key=f"driver_recordings_{space.n_opened}_{len(names)}",
    )
    own = [name for name in chosen if name not in visible]
    recordings = count_text(len(names), "recording")
    text = f"Pictures of visible light: {len(visible):,} of {recordings}"
    how = docs_link("in the session", "pictures", doc="driver-reference")
    if not usable:
        st.caption(f"No recording has pictures. They are named {how}.")
    elif own:
        st.caption(
            f"{text}; of {count_text(len(own), 'chosen one')} the own pictures are taken. Where "
            f"these are grey, nothing is estimated ({how})."
        )
    else:
        st.caption(f"{text} ({how}).")
    if warning := lost_words(state.opened().dataset.of("driver"), names, chosen):
        st.caption(plain(warning))
    return tuple(name for name in usable if name in chosen)


def lost_words(estimate: EstimateRecord | None, names: Sequence[str], chosen: Sequence[str]) -> str:
    """Which recordings lose the estimates that they have, in words; empty: none.

    Parameters
    ----------
    names, chosen
        All recordings, and those that are estimated anew; where none is, nothing is lost.
    """
    had = frozenset[str]() if estimate is None else estimate.estimated_in
    lost = [name for name in names if name in had and name not in chosen]
    if not lost or not chosen:
        return ""
    return f"New estimates take the place of all there are: {listed(lost)} would lose theirs."


def _start(spec: EstimatorSpec, names: Sequence[str], *, interpolate: bool) -> None:
    space, opened = state.workspace(), state.opened()
    x, y = state.systems()
    session = live_session(opened.session, opened.dataset, state.params(), x=x, y=y)
    dataset = opened.dataset.with_settings(session)
    if set(names) != set(state.recording_names()):
        dataset = dataset.only(names=names)
    folder = new_run_folder(space, session, JOB, FOLDER)
    try:
        own = _copied(space, spec, folder)
    except NvcoreError:
        remove_folder(space, folder)
        raise
    space.put_job(JOB, start_job(space, own, dataset, folder, interpolate=interpolate))


def _copied(space: Workspace, spec: EstimatorSpec, folder: Path) -> EstimatorSpec:
    """A copy of the estimator among the files of the run: another may be sent meanwhile.

    Raises
    ------
    NvcoreError
        If the file is gone, or there is no room.
    """
    own = EstimatorSpec(folder / ANNOTATION_FOLDERS / MODEL, f"{folder.name} {spec.version}")
    try:
        check_room(space, spec.path.stat().st_size)
        shutil.copyfile(spec.path, own.path)
    except OSError as error:
        raise InputError(f"cannot be copied ({error.strerror})", file=spec.path.name) from error
    count_folder(space, folder)
    return own


def start_job(
    space: Workspace, spec: EstimatorSpec, dataset: Dataset, folder: Path, *, interpolate: bool
) -> EstimateJob:
    """Start; it ends with the session, and when the session opens something else."""

    def work(progress: Progress) -> WrittenEstimates:
        run = run_confined(dataset, spec, interpolate=interpolate, progress=progress)
        return write_estimates(run, dataset, folder / ANNOTATION_FOLDERS)

    return EstimateJob(space, folder, spec, work)


def draw_missing() -> None:
    """What is missing."""
    text = state.say(
        "Whether the driver sees the {many} is not known yet. Press *Estimate* below: an "
        "estimator tells it from pictures of visible light. The supplied one was trained on "
        "simulated subjects, not on people."
    )
    st.info(text, icon=":material/visibility_off:")


def draw_commands() -> None:
    """The same by commands."""
    with st.expander("By the command line"):
        st.code(COMMANDS, language="console")
