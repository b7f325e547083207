"""Driver page: features and estimates of the open recordings.

Finished estimates are added to the open session, whichever page the visitor is on.
"""

from __future__ import annotations

import shutil
from collections.abc import Sequence
from dataclasses import replace
from typing import Final

import streamlit as st

from nvcore.common.errors import InputError, NvcoreError
from nvcore.common.progress import Progress
from nvcore.common.wording import count_text, listed
from nvcore.inputs.session import Session
from nvcore.subjects.driver.inputs.record import EstimateRecord
from nvcore.subjects.driver.inputs.session import DriverTable
from nvcore.subjects.driver.running.writing import WrittenEstimates, write_estimates
from ui.jobs.background import BackgroundJob, JobState
from ui.jobs.page_run import Aside, PageRun, dataset_of, named_in, open_written
from ui.jobs.progress import draw_job_aside
from ui.session import state
from ui.session.uploads import ANNOTATION_FOLDERS, check_room, count_folder, remove_folder
from ui.shell.messages import shown_error, without_paths
from ui.shell.navigate import PAGES
from ui.subjects.driver import estimator
from ui.subjects.driver.confined import EstimatorSpec, run_confined
from ui.subjects.driver.known import RUN as OPENED
from ui.subjects.driver.known import OpenedRun, opened_run
from ui.widgets.buttons import download
from ui.widgets.text import docs_link, plain

RUN: Final = PageRun[WrittenEstimates](
    "driver_run", "estimate", "Looking at the pictures", folder="driver", has_time_left=True
)
PAGE: Final = "driver"
"""Path of the page."""
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
_NEWS: Final = "driver_news"
"""Key of the note in the workspace on new estimates, with the page that showed it first."""
_TROUBLE: Final = "driver_trouble"
"""Key of the note on why estimates could not be opened, until the Driver page has shown it."""


def draw(*, is_known: bool) -> None:
    """Draw the choice of estimator and recordings, and the run.

    The form is folded if estimates are known, unless the run is in progress.
    """
    if not is_known:
        st.header(TITLE)
        _draw_form()
        return
    with st.expander(f"{TITLE}: choose estimator and recordings", expanded=RUN.job is not None):
        _draw_form()


def _draw_form() -> None:
    spec = estimator.draw()
    chosen = _choose_recordings()
    interpolate = st.checkbox(
        "Interpolate between the estimators of two periods",
        key="driver_interpolate",
        help="Else that of the nearest adaptation period is taken.",
    )
    job, is_possible = RUN.job, spec is not None and bool(chosen)
    is_clicked = RUN.start_button(
        "Estimate", "visibility", "driver_estimate", is_possible=is_possible, type="primary"
    )
    if is_clicked and spec is not None:
        try:
            _start(spec, chosen, interpolate=interpolate)
        except NvcoreError as error:
            st.error(shown_error(error), icon=":material/error:")
        else:
            st.rerun()
    if job is None:
        st.caption(state.say(HOW_LONG))
    else:
        job.is_told = not RUN.draw(job).is_busy
        if _is_waiting(job):
            draw_job_aside(job, RUN.doing, until=lambda: _is_ready(job))
    if text := _trouble():
        st.error(text, icon=":material/error:")
    state.workspace().notes.pop(_TROUBLE, None)


def _choose_recordings() -> tuple[str, ...]:
    """Ask for recordings with pictures. Those with visible-light pictures are preselected."""
    space, names = state.workspace(), state.recording_names()
    visible = [names[number] for number in sorted(space.visible.sources)]
    with_pictures = {*space.visible.sources, *space.pictures.sources}
    usable = [name for number, name in enumerate(names) if number in with_pictures]
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
    """Say which recordings (`names`) lose their estimates to a run on the chosen ones, or ""."""
    had = frozenset[str]() if estimate is None else estimate.estimated_in
    lost = [name for name in names if name in had and name not in chosen]
    if not lost or not chosen:
        return ""
    return f"New estimates take the place of all there are: {listed(lost)} would lose theirs."


def _start(spec: EstimatorSpec, names: Sequence[str], *, interpolate: bool) -> None:
    """Start a run with a copy of the estimator, as another one may be uploaded meanwhile.

    Raises
    ------
    NvcoreError
        If the file is gone, or there is no space left.
    """
    space, dataset = state.workspace(), dataset_of(names)
    folder = RUN.new_folder()
    target = folder / ANNOTATION_FOLDERS
    own = EstimatorSpec(target / MODEL, f"{folder.name} {spec.version}")
    try:
        check_room(space, spec.path.stat().st_size)
        shutil.copyfile(spec.path, own.path)
        count_folder(space, folder)
    except NvcoreError:
        remove_folder(space, folder)
        raise
    except OSError as error:
        remove_folder(space, folder)
        raise InputError(f"cannot be copied ({error.strerror})", file=spec.path.name) from error

    def work(progress: Progress) -> WrittenEstimates:
        run = run_confined(dataset, own, interpolate=interpolate, progress=progress)
        return write_estimates(run, dataset, target)

    RUN.start(work, key=own, folder=folder)


def draw_notes() -> None:
    """Draw the assumptions behind the open estimates and their files, if made in this session."""
    known = opened_run()
    if known is None:
        return
    head, *lines = str(known.run).splitlines()
    with st.expander(f"How it was estimated: {plain(head)}"):
        st.markdown("\n".join(f"- {plain(without_paths(line))}" for line in lines))
        columns = st.columns(3)
        for place, path in zip(columns, known.files, strict=False):
            key = f"download_{path.stem}"
            download(path.name, path.read_bytes, path.name, key=key, at=place, width="stretch")
        st.caption(
            f"What the columns mean: {docs_link('the files', 'the-files', doc='driver-reference')}."
        )


def draw_missing() -> None:
    """Say that there are no estimates yet, and how to get them."""
    text = state.say(
        "Whether the driver sees the {many} is not known yet. Press *Estimate* below: an "
        "estimator tells it from pictures of visible light. The supplied one was trained on "
        "simulated subjects, not on people."
    )
    st.info(text, icon=":material/visibility_off:")


def draw_commands() -> None:
    """Draw the equivalent commands."""
    with st.expander("By the command line"):
        st.code(COMMANDS, language="console")


def draw_aside(page: str) -> None:
    """Draw progress or outcome of an estimate in the sidebar of a page, and the way to Driver.

    Driver itself shows all of that. The news stays on the page where it first appeared.
    """
    job, trouble, news = RUN.job, _trouble(), _news_on(page)
    if page == PAGE:
        return
    if news:  # no toast, as toasts have no accessible name
        st.success(news, icon=":material/visibility:")
    elif trouble and job is None:
        text = state.say("{What} the driver sees was estimated, but cannot be taken over: ")
        st.error(text + trouble, icon=":material/error:")
    elif job is not None and (job.is_busy or _is_waiting(job)):
        doing = state.say("Estimating {what} the driver sees")
        draw_job_aside(job, doing, until=lambda: _is_ready(job))
    elif job is not None and job.state is JobState.FAILED and not job.is_told:
        text = state.say("{What} the driver sees could not be estimated.")
        st.error(text, icon=":material/error:")
    else:
        return
    st.page_link(PAGES / f"{PAGE}.py", label="Driver", icon=":material/arrow_forward:")


def _news_on(page: str) -> str:
    """Return the news of opened estimates, for the page that showed it first."""
    notes = state.workspace().notes
    text, where = notes.get(_NEWS, ("", None))
    if where not in (None, page) or page == PAGE:
        notes.pop(_NEWS, None)
        return ""
    if text:
        notes[_NEWS] = text, page
    return str(text)


def _trouble() -> str:
    """Return why the estimates for the open data could not be opened, or ""."""
    space = state.workspace()
    n_opened, text = space.notes.get(_TROUBLE, (0, ""))
    return str(text) if n_opened == space.n_opened else ""


def _is_waiting(job: BackgroundJob[WrittenEstimates]) -> bool:
    """Return whether estimates wait for other work of the session, which opening them would end."""
    return job.state is JobState.DONE and state.workspace().is_busy


def _is_ready(job: BackgroundJob[WrittenEstimates]) -> bool:
    """Return whether the run has ended and its output, if any, may be opened."""
    return not job.is_busy and not _is_waiting(job)


def take_over() -> None:
    """Open the session with the estimates of a finished run, and rerun the page.

    Frame, settings and choices stay. Call this once all widgets have been drawn, so that no click
    is lost.
    """
    job = RUN.job
    if job is None or job.output is None or not _is_ready(job):
        return
    written, space, session = job.output, state.workspace(), state.opened().session
    session = with_estimates(session, written)
    named, spec = session.driver.detectability, job.key
    assert named is not None

    def remember() -> None:
        files = written.features, written.detectability, written.record
        space.notes[OPENED] = OpenedRun(named, written.run, spec, files)
        n = count_text(len(written.run.features.recordings), "recording")
        text = "{What} the driver sees is estimated in {n}. All pages count with it now."
        space.notes[_NEWS] = state.say(text, n=n), None

    try:
        open_written(space, job, lambda: state.read_again(session, then=remember))
    except NvcoreError as error:
        space.notes[_TROUBLE] = space.n_opened, shown_error(error)
        RUN.drop()
        st.rerun()  # the sidebar of this run is complete


def with_estimates(session: Session, written: WrittenEstimates) -> Session:
    """Return the session with the estimates, named as by `named_in`."""
    named = [named_in(session, path) for path in (written.detectability, written.record)]
    return replace(session, driver=DriverTable(*named))  # type: ignore[call-arg]


ASIDE: Final = Aside(draw_aside, take_over, RUN.drop)
