"""List of a finding's cases on the Timeline: the current entry, and the entries viewed."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from hashlib import sha256
from typing import Any

import numpy as np
import pandas as pd

from nvcore.common.findings import TRUTH_NAME, Cases, Finding
from nvcore.common.wording import capitalised
from nvcore.tables.inputs import NO_ROW, entry_frames, finding_entries
from ui.session import state, store

ListKey = tuple[str, ...]
"""Data fingerprint, code and subject of a finding, and a hash of its cases."""


@dataclass(frozen=True)
class Review:
    """List that is viewed entry by entry.

    Attributes
    ----------
    finding
        Finding with the cases that are the entries.
    at
        Current entry, counted from 0.
    key
        Identifies the list and its data.
    """

    finding: Finding
    at: int
    key: ListKey

    @property
    def cases(self) -> Cases:
        """All entries."""
        assert self.finding.cases is not None
        return self.finding.cases

    @cached_property
    def frame_row(self) -> int:
        """Row of the entry's frame in the frames table, or `NO_ROW` if it is not evaluated."""
        case = Cases(self.cases.table, np.asarray(self.cases.rows)[self.at : self.at + 1])
        return int(entry_frames(state.opened().dataset, case)[0])

    @property
    def entry(self) -> pd.Series[Any]:
        """Row of the current entry in `entries_of`."""
        return entries_of(self.finding, self.key).iloc[self.at]


def finding_key(finding: Finding) -> tuple[str, str, str]:
    """Return a key that identifies a finding in the open data."""
    return state.opened().dataset.fingerprint, finding.code, finding.subject


def subject_text(finding: Finding) -> str:
    """Return a finding's subject: truth, pictures, or a system with its letter. Not yet `plain`."""
    if finding.subject == TRUTH_NAME or finding.is_of_pictures:
        return capitalised(finding.subject)
    x, y = state.systems()
    letter = {x: "X, ", y: "Y, "}.get(finding.subject, "")
    return f"{letter}{finding.subject}"


def list_key(finding: Finding) -> ListKey:
    """Return a key of a finding and its cases, which depend on thresholds, matching, X and Y."""
    assert finding.cases is not None
    rows = np.asarray(finding.cases.rows, dtype=np.int64).tobytes()
    return *finding_key(finding), sha256(rows).hexdigest()[:12]


def entries_of(finding: Finding, key: ListKey) -> pd.DataFrame:
    """Return all entries of a list, one per row (see `nvcore.tables.finding_entries`)."""
    dataset = state.opened().dataset
    table: pd.DataFrame = state.workspace().cached(
        "finding_entries", key, lambda: finding_entries(dataset, [finding])
    )
    return table


def seen_of(key: ListKey) -> frozenset[int]:
    """Return the entries of a list that were viewed."""
    return store.ENTRIES_SEEN.get().get(key, frozenset())


def current() -> Review | None:
    """Return the list that is viewed, or None if there is none for the open data."""
    review = store.REVIEW.get()
    is_of_these = review and review.key[0] == state.opened().dataset.fingerprint
    return review if is_of_these else None


def begin(finding: Finding, at: int) -> bool:
    """View a list from this entry on. Return False if its frame is not evaluated."""
    return _show(Review(finding, at, list_key(finding)), writes=False)  # another page follows


def go_to(at: int) -> None:
    """View another entry of the list. For callbacks."""
    review = current()
    if review is not None and 0 <= at < len(review.cases):
        _show(Review(review.finding, at, review.key))


def end() -> None:
    """Stop viewing the list."""
    store.REVIEW.pop()


def _show(review: Review, *, writes: bool = True) -> bool:
    """View an entry, and go to its frame. Return False if that is not evaluated."""
    store.REVIEW.set(review)
    seen = seen_of(review.key) | {review.at}
    store.ENTRIES_SEEN.set({**store.ENTRIES_SEEN.get(), review.key: seen})
    row = review.frame_row
    if row != NO_ROW:
        state.go_to(*state.place_of(row), writes=writes)
    return row != NO_ROW
