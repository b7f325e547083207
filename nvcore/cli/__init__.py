"""The command line: parse, load, audit, analyse, report.

Commands import numpy, pandas and numba only when they are called, which keeps `nvcore --help`
fast.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from nvcore.cli.commands import main as main


def __getattr__(name: str) -> Any:
    """Load ``main`` on first use, because the commands of subjects import from this package."""
    if name == "main":
        from nvcore.cli.commands import main

        return main
    raise AttributeError(f"module 'nvcore.cli' has no attribute {name!r}")
