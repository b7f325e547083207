"""Workers: measurements in separate processes, each in its own environment."""

from __future__ import annotations

import json
import os
import subprocess
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parent.parent
TOOLS_PYTHON = ROOT / ".venv-bench" / "tools" / "bin" / "python"
"""Interpreter with the tools of requirements-bench.txt."""


def run_worker(python: Path, *arguments: str) -> dict[str, Any]:
    """Run a worker and return the JSON of its last line, or ``{"failed": why}`` if it fails."""
    if not python.exists():
        return {"failed": "not installed; `make bench` installs it"}
    process = subprocess.run(
        [str(python), "-m", *arguments],
        cwd=ROOT,
        env={**os.environ, "PYTHONPATH": str(ROOT)},
        capture_output=True,
        text=True,
        check=False,
    )
    if process.returncode:
        return {"failed": (process.stderr.strip().splitlines() or ["no message"])[-1]}
    figures: dict[str, Any] = json.loads(process.stdout.strip().splitlines()[-1])
    return figures
