"""Primary question: the measure whose difference decides a comparison."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from datetime import UTC, datetime
from typing import Any, Final

DEFAULT: Final = "severity_s_per_encounter"
"""Default by the paper's argument that the cost of a miss depends on how near, how long and how
late it is, which a count of misses does not show (docs/decisions/066)."""


@dataclass(frozen=True)
class Primary:
    """Measure that is tested by itself. Others are claimed only if it shows a difference.

    Attributes
    ----------
    key
        One of `nvcore.comparison.measures.table.EVIDENCE_KEYS`.
    fixed_at
        Time of the choice (ISO 8601, UTC); empty for the default, which nobody chose.
    fingerprint
        Fingerprint of the data for which it was chosen; empty if chosen before there were any.
    is_changed
        True if it was changed after a verdict on these data had been shown. It is then tested as
        one of all measures.
    """

    key: str = DEFAULT
    fixed_at: str = ""
    fingerprint: str = ""
    is_changed: bool = False

    @property
    def when(self) -> str:
        """Time of the choice, to the minute, such as "on 2026-11-26 at 17:40 UTC"."""
        day, _, time = self.fixed_at.partition("T")
        return f"on {day} at {time[:5]} UTC" if time else "in the session file"

    def choose(self, key: str, *, fixed_at: str) -> Primary:
        """Return another measure, marked as changed if a verdict on the data has fixed this one."""
        if key == self.key:
            return self
        return Primary(key, fixed_at, self.fingerprint, self.is_changed or bool(self.fingerprint))

    def given(self) -> dict[str, str | bool]:
        """Return the entries of a session file, empty for the default without data."""
        table: dict[str, str | bool] = {
            "measure": self.key,
            "fixed_at": self.fixed_at,
            "fingerprint": self.fingerprint,
            "changed": self.is_changed,
        }
        return {} if self == Primary() else {key: value for key, value in table.items() if value}

    def of_data(self, fingerprint: str) -> Primary:
        """Return the same measure for these data. No verdict on other data has been shown yet."""
        if self.fingerprint in ("", fingerprint):
            return self
        return Primary(self.key, self.fixed_at)


def now_text() -> str:
    """Return the current time for `Primary.fixed_at`."""
    return datetime.now(UTC).isoformat(timespec="seconds")


def primary_from(table: Mapping[str, Any]) -> Primary:
    """Create the primary measure from the table of a session file."""
    names = {"measure": "key", "changed": "is_changed"}
    return Primary(**{names.get(key, key): value for key, value in table.items()})
