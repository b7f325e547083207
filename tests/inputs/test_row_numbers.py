"""Ids that occur once each number the boxes: they are no tracks."""

from __future__ import annotations

import pandas as pd
import pytest

import nvcore as nv
from nvcore.common.findings import Finding, Severity
from nvcore.dataset import Dataset
from nvcore.metrics.encounters import encounters_of


def walks(n_frames: int = 12, recording: str = "a") -> pd.DataFrame:
    """Two people who stand 200 px apart for some frames; ids 1 and 2."""
    rows = [
        (recording, frame, 100 + 200 * person, 50, 40, 80, person + 1)
        for frame in range(n_frames)
        for person in range(2)
    ]
    return pd.DataFrame(rows, columns=["recording", "frame", "x", "y", "w", "h", "track"])


def numbered(table: pd.DataFrame) -> pd.DataFrame:
    return table.assign(track=range(1, len(table) + 1))


def loaded(truth: pd.DataFrame, x: pd.DataFrame | None = None) -> Dataset:
    x = walks().drop(columns="track") if x is None else x
    return nv.load(truth=truth, x=x, fps=10, size=(640, 480))


def told(dataset: Dataset) -> list[Finding]:
    return [finding for finding in dataset.findings if finding.code == "row-number-ids"]


def n_encounters(dataset: Dataset) -> int:
    return len(encounters_of(dataset)[1])


def test_people_whose_ids_number_the_rows_are_linked_by_overlap():
    dataset = loaded(numbered(walks()))
    assert n_encounters(dataset) == 2
    (finding,) = told(dataset)
    assert (finding.severity, finding.subject, finding.count) == (Severity.WARNING, "truth", 24)
    assert "24 of 24 track ids occur once only" in finding.message


@pytest.mark.parametrize(
    ("n_twice", "n_people"), [(1, 2), (3, 97 + 2)], ids=["1 of 99 ids", "3 of 97 ids"]
)
def test_nearly_all_ids_are_enough(n_twice: int, n_people: int):
    # 100 rows; so many ids also stand in the row 50 later, 25 frames on
    table = numbered(walks(50))
    table.loc[50 : 49 + n_twice, "track"] = range(1, n_twice + 1)
    dataset = loaded(table)
    assert bool(told(dataset)) == (n_twice == 1)
    assert n_encounters(dataset) == (2 if n_twice == 1 else 97)


def test_few_ids_are_kept():
    dataset = loaded(numbered(walks(4)))
    assert (n_encounters(dataset), told(dataset)) == (8, [])


def test_ids_of_a_single_frame_prove_nothing():
    crowd = pd.concat([walks(1).assign(x=50 * i) for i in range(10)])
    dataset = loaded(numbered(crowd))
    assert (n_encounters(dataset), told(dataset)) == (20, [])


def test_a_numbered_recording_beside_one_with_tracks_is_found():
    dataset = loaded(pd.concat([walks(40), numbered(walks(recording="b"))]), walks())
    assert n_encounters(dataset) == 4
    (finding,) = told(dataset)
    assert (finding.count, finding.example) == (24, "recording b")


def test_short_recordings_are_judged_together():
    parts = [walks(3, recording=name) for name in "abcd"]
    dataset = loaded(numbered(pd.concat(parts)), walks(3))
    assert n_encounters(dataset) == 8
    assert told(dataset)[0].count == 24


def test_a_system_s_row_numbers_are_no_tracks_either():
    dataset = loaded(walks(), numbered(walks()))
    (finding,) = told(dataset)
    assert (finding.severity, finding.subject) == (Severity.NOTE, "X")
    assert {*dataset.system("X").track} == {-1}
    assert loaded(walks(), walks()).findings == ()
