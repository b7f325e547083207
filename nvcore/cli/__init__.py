"""The command line: parse, load, audit, analyse, report.

Commands import what they need when they are called: `nvcore --help` need not wait for numpy,
pandas and numba.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from nvcore.cli.commands import main as main


def __getattr__(name: str) -> Any:
    """Load ``main`` on first use: the commands of subjects import from this package themselves."""
    if name == "main":
        from nvcore.cli.commands import main

        return main
    raise AttributeError(f"module 'nvcore.cli' has no attribute {name!r}")
