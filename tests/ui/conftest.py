"""Surroundings of the pages' tests: uploads in a folder of their own, no other start or folder."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from functools import cache
from pathlib import Path

import pytest
import streamlit as st
from data_page import Edit
from places import SAMPLE
from streamlit.components.v2 import manifest_scanner

from nvcore.pictures import Pictures, open_pictures, recordings
from ui.session import sample
from ui.session.workspace import Workspace

open_once = cache(open_pictures)
scan_once = cache(manifest_scanner.scan_component_manifests)
"""Every AppTest reads the metadata of all installed packages, which takes longer than a page."""
MAIN = sys.modules["__main__"]


@pytest.fixture(scope="session", autouse=True)
def shared(tmp_path_factory: pytest.TempPathFactory) -> Iterator[None]:
    """What is the same for all tests, done once; a folder for what several of them look at."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(recordings, "open_pictures", open_sample_once)
        patch.setattr(manifest_scanner, "scan_component_manifests", scan_once)
        patch.setenv("NVCORE_UPLOAD_DIR", str(tmp_path_factory.mktemp("uploads")))
        yield


@pytest.fixture(autouse=True)
def surroundings(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    monkeypatch.setenv("NVCORE_UPLOAD_DIR", str(tmp_path / "uploads"))
    monkeypatch.setenv("NVCORE_PROJECTS", str(tmp_path / "projects.sqlite"))
    monkeypatch.delenv("NVCORE_LOCAL_ROOT", raising=False)
    monkeypatch.delenv("NVCORE_SESSION", raising=False)
    if SAMPLE in sample._samples:  # those that tests have opened go first
        sample._samples.move_to_end(SAMPLE)
    for shared in sample._samples.values():  # what other tests moved is not known to this one
        for kind in [kind for kind in shared._caches if kind == sample._moved(kind.split(",")[0])]:
            del shared._caches[kind]
    yield
    sys.modules["__main__"] = MAIN  # where AppTest leaves the page, which a new process would run
    # tests without a session of their own share one
    space = st.session_state.pop("workspace", None)
    if space is not None:
        space.close()


def open_sample_once(path: Path) -> Pictures:
    """As `open_pictures`; each of the sample's videos, of which a page needs few, once for all.

    A closed video opens again when it is read.
    """
    return open_once(path) if path.parent == SAMPLE.parent else open_pictures(path)


@pytest.fixture
def space(surroundings: None) -> Iterator[Workspace]:
    """The workspace of a session, which ends with the test."""
    space = Workspace()
    yield space
    space.close()


@pytest.fixture
def edit(monkeypatch: pytest.MonkeyPatch) -> Edit:
    """Cells of the Data page's table of recordings are changed by it."""
    return Edit(monkeypatch)
