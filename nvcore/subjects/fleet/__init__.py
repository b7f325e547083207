"""The fleet: stores of many recordings, and the same comparison over all of them."""

from __future__ import annotations

from collections.abc import Sequence
from typing import ClassVar

from nvcore.common import subject


class Fleet(subject.Subject):
    """Stores of many recordings."""

    name = "fleet"
    names: ClassVar = {
        "nvcore.subjects.fleet.calls": (
            *("ingest", "open_store", "scan", "scan_status", "top", "export_recording"),
        )
    }
    extras: ClassVar = {
        "fleet": ("deltalake", "duckdb", "obstore", "sqlglot"),
        "dask": ("deltalake", "distributed", "duckdb", "obstore", "sqlglot"),
    }
    has_pages = False

    def session_keys(self) -> subject.AddedKeys:
        from nvcore.subjects.fleet.session import FleetEntry

        return subject.AddedKeys(recording=(FleetEntry,))

    def commands(self) -> Sequence[subject.Command]:
        from nvcore.subjects.fleet.commands import ingest, open_, scan, top

        return (ingest, scan, top, open_)
