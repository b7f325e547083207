"""The primary question: the measure whose difference a comparison is to be decided by."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from datetime import UTC, datetime
from typing import Any, Final

DEFAULT: Final = "severity_s_per_encounter"
"""The paper's argument: that a miss counts by how near, how long and how late it is, and that a
count of misses does not say so (docs/decisions/066)."""


@dataclass(frozen=True)
class Primary:
    """The measure that is tested by itself; all others follow only where it shows a difference.

    Attributes
    ----------
    key
        Of `nvcore.measures.table.EVIDENCE_KEYS`.
    fixed_at
        When it was chosen (ISO 8601, UTC); empty: not by anybody, it is the default.
    fingerprint
        Of the data for which it was chosen; empty: before there were any.
    is_changed
        Whether it was chosen anew after a verdict on these data had been shown: then it is tested
        as one of all measures.
    """

    key: str = DEFAULT
    fixed_at: str = ""
    fingerprint: str = ""
    is_changed: bool = False

    @property
    def when(self) -> str:
        """When it was chosen, to the minute: "on 2026-11-26 at 17:40 UTC"."""
        day, _, time = self.fixed_at.partition("T")
        return f"on {day} at {time[:5]} UTC" if time else "in the session file"

    def choose(self, key: str, *, fixed_at: str) -> Primary:
        """Another measure; changed where this one was fixed with a verdict on the data."""
        if key == self.key:
            return self
        return Primary(key, fixed_at, self.fingerprint, self.is_changed or bool(self.fingerprint))

    def given(self) -> dict[str, str | bool]:
        """As a session file names it; empty: the default, of no data."""
        table: dict[str, str | bool] = {
            "measure": self.key,
            "fixed_at": self.fixed_at,
            "fingerprint": self.fingerprint,
            "changed": self.is_changed,
        }
        return {} if self == Primary() else {key: value for key, value in table.items() if value}

    def of_data(self, fingerprint: str) -> Primary:
        """The same for these data: on others no verdict has been shown yet."""
        if self.fingerprint in ("", fingerprint):
            return self
        return Primary(self.key, self.fixed_at)


def now_text() -> str:
    """The time, for `Primary.fixed_at`."""
    return datetime.now(UTC).isoformat(timespec="seconds")


def primary_from(table: Mapping[str, Any]) -> Primary:
    """From the table of a session file."""
    names = {"measure": "key", "changed": "is_changed"}
    return Primary(**{names.get(key, key): value for key, value in table.items()})
