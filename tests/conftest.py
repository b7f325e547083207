"""Fixtures for all tests."""

from __future__ import annotations

import gc
import os
from pathlib import Path

import pytest
from hypothesis import HealthCheck, settings
from inputs import drive
from published import load_kaist

from nvcore.dataset import Dataset

# a busy machine is no fault of the code: how long an example takes is not judged
settings.register_profile("steady", deadline=None, suppress_health_check=[HealthCheck.too_slow])
settings.load_profile("steady")
# modules are many and stay: looking through them again and again takes a tenth of the time
gc.set_threshold(50_000, 50, 100)


def pytest_collection_finish() -> None:
    """Leave alone what is there before the first test."""
    gc.collect()
    gc.freeze()


@pytest.fixture(scope="session")
def realdata() -> Path:
    """Folder of the real recordings; tests that need it are skipped where it is absent."""
    folder = os.environ.get("NVCORE_REALDATA", "")
    if not folder or not Path(folder).is_dir():
        pytest.skip(f"no real recordings in {folder!r}: set NVCORE_REALDATA to their folder")
    return Path(folder).resolve()


@pytest.fixture(scope="session")
def golden(realdata: Path) -> Path:
    """Folder of the reference figures, beside the real recordings."""
    folder = realdata.parent / "golden"
    if not folder.is_dir():
        pytest.skip(f"reference figures not found in {folder}")
    return folder


@pytest.fixture(scope="session")
def kaist(realdata: Path) -> Dataset:
    """KAIST's test set with the five systems."""
    return load_kaist(realdata)


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """The files of `drive`, in a folder of their own."""
    return drive(tmp_path / "drive")
