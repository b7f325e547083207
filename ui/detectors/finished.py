"""Detectors page: a run that is done, the way to its comparison, and the way back."""

from __future__ import annotations

import io
import zipfile
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Final, NamedTuple

import streamlit as st

from nvcore.dataset import Dataset
from nvcore.detectors.writing import WrittenRun
from nvcore.errors import NvcoreError
from nvcore.inputs.session import Session
from nvcore.progress import Progress
from nvcore.wording import MOST_NAMED, listed, minus
from ui.access.files import safe_name
from ui.detectors.confined import DetectorSpec
from ui.detectors.trial import Levels
from ui.jobs.runs import FolderJob, is_uploaded, open_written
from ui.session import state, store
from ui.session.opening import live_session, relative_path
from ui.session.workspace import Workspace
from ui.shell.messages import shown_error
from ui.shell.navigate import ask_for_page
from ui.widgets.buttons import button
from ui.widgets.text import docs_link, plain

RUN: Final = "detector_run"
FOLDER: Final = "detector"
BEFORE: Final = "detector_before"


class Before(NamedTuple):
    """What was open before a run was compared; `n_opened` is the number of that comparison."""

    n_opened: int
    session: Session
    label: str


@dataclass(frozen=True)
class RunKey:
    """What is run on which recordings: what its time depends on."""

    spec: DetectorSpec
    recordings: tuple[str, ...]


@dataclass(frozen=True)
class OnScreen:
    """What a run depends on, as it is set on the page."""

    key: RunKey
    levels: Levels


class RunJob(FolderJob[WrittenRun]):
    """A run.

    Attributes
    ----------
    started
        As the page was set when it was started.
    """

    def __init__(
        self,
        space: Workspace,
        folder: Path,
        started: OnScreen,
        work: Callable[[Progress], WrittenRun],
        *,
        name: str,
    ):
        """Start to run; see `FolderJob`."""
        self.started, self.outlasts = started, True
        super().__init__(space, folder, work, key=name)


def draw(job: RunJob, on_screen: OnScreen | None) -> None:
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
    differences = [] if on_screen is None else differences_of(job.started, on_screen)
    if differences:
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
    threshold = minus(f"{job.started.levels.threshold:.4g}")
    st.caption(
        f"It becomes Y, at the threshold {threshold}: where the slider stood when the run was "
        "started. With its boxes goes the record of how they were made: the audit says where it "
        f"was trained on what it is scored on ({link})."
    )


def differences_of(started: OnScreen, now: OnScreen) -> list[str]:
    """Which settings of a run differ from those of the page by now, in words."""
    before, after = started.key.spec, now.key.spec
    if (before.text, before.version) != (after.text, after.version):
        return ["another detector"]
    own, new = dict(before.settings), dict(after.settings)
    names = sorted(name for name in {*own, *new} if own.get(name) != new.get(name))
    differences = [name.replace("_", " ") for name in names]
    for name in ("threshold", "overlap"):
        value, value_now = getattr(started.levels, name), getattr(now.levels, name)
        if value != value_now:
            differences.append(f"{name} {minus(f'{value:.4g}')} (now {minus(f'{value_now:.4g}')})")
    if started.key.recordings != now.key.recordings:
        differences.append("recordings")
    return differences


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
        threshold=job.started.levels.threshold,
        is_upload=is_uploaded(space, live),
    )
    ask_for_page("overview")
    is_moved = state.params() != state.session_params()
    space.notes[BEFORE] = Before(space.n_opened + 1, live if is_moved else opened.session, label)
    try:
        named = f"{label}, with {written.name}"
        open_written(space, job, lambda: state.open_session(session, label=named))
    except NvcoreError as error:
        store.NEXT_PAGE.pop()
        space.notes.pop(BEFORE, None)
        st.error(shown_error(error), icon=":material/error:")


def draw_way_back() -> None:
    """The button that opens again what was open before the run was compared, while that is."""
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
