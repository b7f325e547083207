"""What is remembered of chosen files, and for how long."""

from __future__ import annotations

import gc
import weakref
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from inputs import write

from nvcore.inputs.load import read_source
from nvcore.inputs.readers.base import Reading
from nvcore.inputs.session import Source
from ui.views.data import file_check
from ui.views.data.file_check import FileCheck, check_files

TRUTH = ("frame,x,y,w,h", "1,2,3,40,90", "2,2,3,40,90")


@pytest.fixture
def check(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Callable[[str], FileCheck]:
    """Checks one file of ground truth under a key, with nothing remembered before."""
    monkeypatch.setattr(file_check.st, "session_state", {})
    write(tmp_path / "t.csv", *TRUTH)
    return lambda key: check_files(lambda: key, Source(("t.csv",)), role="truth", folder=tmp_path)


def test_the_boxes_of_a_checked_file_are_not_kept(
    check: Callable[[str], FileCheck], monkeypatch: pytest.MonkeyPatch
):
    tables: list[weakref.ref[np.ndarray]] = []

    def read(*args: object, **options: object) -> Reading:
        reading = read_source(*args, **options)  # type: ignore[arg-type]
        x = np.full(1_000, 2.0)
        tables.append(weakref.ref(x))
        boxes = pd.DataFrame(
            {"recording": "t", "frame": np.ones(len(x), np.int64), "ignore": False, "x": x}
            | dict.fromkeys(("y", "w", "h", "score"), 1.0),
            copy=False,
        )
        annotated = pd.DataFrame({"recording": "t", "frame": boxes["frame"]})
        return Reading(boxes, reading.recordings, "", annotated=annotated)

    monkeypatch.setattr(file_check, "read_confined", read)
    checked = check("mine")
    gc.collect()
    assert checked.summary.startswith("plain CSV: 1 recording, 1,000 boxes")
    assert len(tables) == 1
    assert tables[0]() is None
    assert checked.reading is not None
    assert checked.reading.annotated is None


def test_the_least_recently_used_check_goes_first(
    check: Callable[[str], FileCheck], monkeypatch: pytest.MonkeyPatch
):
    monkeypatch.setattr(file_check, "MOST_KEPT", 2)
    truth, first = check("truth"), check("first")
    assert check("truth") is truth
    check("second")
    assert check("truth") is truth
    assert check("first") is not first
