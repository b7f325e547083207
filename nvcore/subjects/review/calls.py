"""The call of Python users: `nvcore.open_project`."""

from __future__ import annotations

import os
import tempfile
from functools import cached_property
from pathlib import Path
from typing import Any, Final

import click
import numpy as np
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
from nvcore.evidence.measures import primary_of
from nvcore.inputs.session.toml import read_session, write_session
from nvcore.subjects.review.cases import CaseList, find_cases
from nvcore.subjects.review.decisions import (
    cases_as_cvat,
    decided,
    make_decision,
    reviewed_measures,
)
from nvcore.subjects.review.robust import PER_ENCOUNTER, Robustness, find_robustness
from nvcore.subjects.review.store import Project, ProjectStore

VARIABLE: Final = "NVCORE_PROJECTS"
"""Environment variable with the path of the file of projects."""
FILE_NAME: Final = "projects.sqlite"


def open_store(path: PathLike | None = None) -> ProjectStore:
    """Open the file of projects: ``$NVCORE_PROJECTS``, or in the user's application folder."""
    usual = os.environ.get(VARIABLE) or Path(click.get_app_dir("nvcore")) / FILE_NAME
    return ProjectStore(Path(path or usual))


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
        changed = self._store.changed_inputs(self.project.token)
        if changed:
            raise InputError(f"{self.project.name}: changed since it was kept: {changed[0]}")
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "session.toml"
            path.write_text(self.project.session, encoding="utf-8")
            session = read_session(path)
        root, tree = self.project.root, self._store.tree(self.project.token)

        def moved(path: str) -> str:
            is_copy = bool(root) and Path(path).is_relative_to(root)
            return str(tree / Path(path).relative_to(root)) if is_copy else path

        return compare(load(session.with_paths(moved, folder=tree)))

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
        key = primary_of(self._result.dataset).key
        is_open = ~self.cases["is_done"].to_numpy(bool)
        measure = next((of for of in PER_ENCOUNTER if of.startswith(key)), key)
        return find_robustness(self._result, self._cases, np.asarray(is_open), measure)

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
    return OpenProject(file, keep_session(file, name, Path(session)))


def keep_session(file: ProjectStore, name: str, path: Path, **options: Any) -> Project:
    """Keep a session file as a new project. Its inputs stay where they are."""
    session = read_session(path)
    dataset = load(session)
    text = write_session(session, version=nvcore.__version__, fingerprint=dataset.fingerprint)
    inputs = [session.folder / one for one in session.paths()]
    return file.create(name, text, inputs=[one for one in inputs if one.is_file()], **options)
