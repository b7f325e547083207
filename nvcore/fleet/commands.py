"""Commands of the fleet: ``nvcore ingest``, ``scan``, ``top`` and ``open``."""

from __future__ import annotations

from typing import Any, Final

COMMANDS: Final[tuple[Any, ...]] = ()
