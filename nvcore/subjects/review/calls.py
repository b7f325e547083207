"""The call of Python users: `nvcore.open_project`."""

from __future__ import annotations

import glob
import os
import tempfile
from collections.abc import Callable, Iterable, Sequence
from functools import cached_property
from pathlib import Path
from typing import Final

import click
import pandas as pd

import nvcore
from nvcore.api.calls import compare
from nvcore.api.comparison import Comparison
from nvcore.api.inputs import load
from nvcore.auditing import audit
from nvcore.common.arguments import PathLike
from nvcore.common.errors import InputError
from nvcore.common.wording import did_you_mean
from nvcore.comparison.compare import Result
from nvcore.inputs.session import Session
from nvcore.inputs.session.recordings_file import with_recordings_file
from nvcore.inputs.session.toml import read_session, write_session
from nvcore.subjects.review.cases import CaseList, find_cases
from nvcore.subjects.review.decisions import (
    cases_as_cvat,
    decided,
    make_decision,
    reviewed_measures,
)
from nvcore.subjects.review.robust import Robustness, primary_robustness
from nvcore.subjects.review.store import Project, ProjectStore

VARIABLE: Final = "NVCORE_PROJECTS"
"""Environment variable with the path of the file of projects."""
FILE_NAME: Final = "projects.sqlite"
SIDE_FILE: Final = "seqinfo.ini"
"""File beside annotations from which readers take sizes and frame rates."""


def open_store(path: PathLike | None = None) -> ProjectStore:
    """Open the file of projects: ``$NVCORE_PROJECTS``, or in the user's application folder."""
    usual = os.environ.get(VARIABLE) or Path(click.get_app_dir("nvcore")) / FILE_NAME
    return ProjectStore(Path(path or usual))


def session_of(
    store: ProjectStore, project: Project, *, read: Callable[[Path], Session] = read_session
) -> Session:
    """Return the session of a project, with the paths of its inputs as they are now.

    Parameters
    ----------
    read
        Reads the session file.

    Raises
    ------
    InputError
        If inputs have changed since they were kept.
    """
    changed = store.changed_inputs(project.token)
    if changed:
        first = Path(changed[0])
        is_gone = not first.is_absolute() or not first.exists()
        what = "not found" if is_gone else "changed since it was kept"
        raise InputError(f"{project.name}: {what}: {first.name}")
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "session.toml"
        path.write_text(project.session, encoding="utf-8")
        session = read(path)
    root, tree = project.root, store.tree(project.token)

    def moved(path: str) -> str:
        if not root or not Path(path).is_relative_to(root):
            return path
        copy = tree / Path(path).relative_to(root)
        return str(copy) if copy.exists() or glob.glob(str(copy)) else path  # noqa: PTH207

    return session.with_paths(moved, folder=tree)


class OpenProject:
    """A project with its comparison, cases and decisions.

    Attributes
    ----------
    project
        Name, token and session.
    """

    def __init__(self, store: ProjectStore, project: Project):
        self._store = store
        self.project = project

    @cached_property
    def comparison(self) -> Comparison:
        """The comparison, loaded from the project's inputs at first use.

        Raises
        ------
        InputError
            If inputs have changed since they were kept.
        """
        return compare(load(session_of(self._store, self.project)))

    @cached_property
    def _cases(self) -> CaseList:
        return find_cases(self._result, audit(self._result.dataset))

    @property
    def _result(self) -> Result:
        return self.comparison.result

    @property
    def decisions(self) -> pd.DataFrame:
        """All decisions in their order: case, reviewer, decision, note, is_done, at."""
        return self._store.decisions(self.project.token)

    @property
    def cases(self) -> pd.DataFrame:
        """One row per case, with the latest decision on it (docs/review.md)."""
        return decided(self._cases, self.decisions)

    @property
    def measures(self) -> pd.DataFrame:
        """Every measure before and after the review."""
        return reviewed_measures(self._result, self._cases, self.decisions)

    @property
    def robustness(self) -> Robustness | None:
        """How many open misses would have to be wrong truth to turn the primary measure.

        None if that is no mean over encounters.
        """
        return primary_robustness(self._result, self._cases, self.decisions)

    def open_as_cvat(self) -> bytes:
        """Return the frames of all open cases, for annotators (CVAT for images XML 1.1)."""
        is_open = ~self.cases["is_done"].to_numpy(bool)
        return cases_as_cvat(self._result, self._cases, is_open)

    def decide(self, case: str, decision: str, *, reviewer: str = "", note: str = "") -> None:
        """Decide on a case: real miss, false alarm, wrong truth, irrelevant, ask; "" takes back.

        Raises
        ------
        InputError
            If there is no such case or decision.
        """
        known = self._cases.table["case"].tolist()
        if case not in known:
            raise InputError(f"no case {case!r} in {self.project.name}")
        made = make_decision(case, decision, reviewer=reviewer, note=note)
        self._store.decide(self.project.token, made)


def open_project(
    name: str, *, session: PathLike | None = None, store: PathLike | None = None
) -> OpenProject:
    """Open a project by its name, or keep a session as a new one.

    Parameters
    ----------
    name
        Name or token of the project.
    session
        Session file. None: the project exists.
    store
        File of the projects. None: ``$NVCORE_PROJECTS``, or in the application folder.

    Raises
    ------
    InputError
        If there is no such project, or with `session` one exists already.

    Examples
    --------
    >>> project = nv.open_project("Night drive", session="night.toml")  # doctest: +SKIP
    >>> project.cases.query("severity_s > 1")  # doctest: +SKIP
    """
    file = open_store(store)
    known = {of.name: of for of in reversed(file.projects())}
    existing = known.get(name) or file.project(name)
    if session is None:
        if existing is None:
            hint = did_you_mean(name, known, "`nvcore review list` lists the projects")
            raise InputError(f"no project {name!r}: {hint}")
        return OpenProject(file, existing)
    if existing is not None:
        raise InputError(f"there is a project {name!r} already")
    read = read_session(Path(session))
    return OpenProject(file, keep_session(file, name, read, load(read).fingerprint))


def import_project(
    path: Path, *, name: str | None = None, store: PathLike | None = None
) -> Project:
    """Add a project from a file, under another name if one is given.

    Raises
    ------
    InputError
        If there is a project of that name, or the file is something else.
    """
    file = open_store(store)
    made = file.import_(path, name=name)
    if any(of.name == made.name for of in file.projects() if of.token != made.token):
        file.delete(made.token)
        raise InputError(f"there is a project {made.name!r} already: give another name")
    return made


def keep_session(
    file: ProjectStore,
    name: str,
    session: Session,
    fingerprint: str,
    *,
    roots: Sequence[Path] = (),
    owner: str = "",
) -> Project:
    """Keep a session as a new project.

    Parameters
    ----------
    fingerprint
        Fingerprint of its data.
    roots
        Folders of which files are copied, such as uploads. Others stay where they are.
    owner
        First member.

    Raises
    ------
    InputError
        If the name is empty, or the copies exceed the quota.
    """
    text = write_session(session, version=nvcore.__version__, fingerprint=fingerprint)
    # folders of pictures change no number, and are too large to hash
    shown = {path for entry in session.recordings for path in (entry.pictures, entry.visible)}
    inputs: list[Path] = []
    copied: list[Path] = []
    for one in dict.fromkeys(session.paths()):
        path = session.folder / one
        found = [path] if path.exists() else map(Path, sorted(glob.glob(str(path))))  # noqa: PTH207  # absolute
        for each in found:
            is_copied = any(map(each.is_relative_to, roots))
            is_whole = each.is_dir() and (is_copied or one not in shown)
            inside = sorted(each.rglob("*")) if is_whole else [each]
            beside = [folder / SIDE_FILE for folder in (each.parent, each.parent.parent)]
            files = [
                file
                for file in (*inside, *beside)
                if file.is_file() and (not is_copied or any(map(file.is_relative_to, roots)))
            ]
            (copied if is_copied else inputs).extend(files)
    used = [root for root in roots if any(path.is_relative_to(root) for path in copied)]
    return file.create(
        *(name, text),
        owner=owner,
        inputs=dict.fromkeys(inputs),
        copied=dict.fromkeys(copied),
        root=Path(os.path.commonpath(used)) if used else None,
    )


def import_shared(
    file: ProjectStore,
    path: Path,
    roots: Iterable[Path],
    *,
    owner: str = "",
    read: Callable[[Path], Session] = read_session,
    read_table: Callable[[Session], Session] = with_recordings_file,
) -> Project:
    """Add the project of a file that a stranger may have made.

    Parameters
    ----------
    roots
        Folders in which it may name files that it does not bring.
    read, read_table
        Read the session file, and the table of recordings that it names.

    Raises
    ------
    InputError
        If it names other files, or is no project.
    """
    from nvcore.pictures.open import is_below  # needs an extra

    project = file.import_(path, owner=owner)
    tree = file.tree(project.token)
    allowed = [tree, *roots]

    def check(path: Path) -> None:
        if not any(is_below(path, root) for root in allowed):
            raise InputError("it names files that it does not bring")

    try:
        for one in file.inputs(project.token):
            check(tree / one.path)
        session = session_of(file, project, read=read)
        for text in session.paths():
            check(session.folder / text)
        for text in read_table(session).paths():
            check(session.folder / text)
    except BaseException:
        file.delete(project.token)
        raise
    return project
