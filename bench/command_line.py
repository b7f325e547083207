"""How long `nvcore compare` takes on the sample: the first time, compiling, and the second."""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
from pathlib import Path
from time import perf_counter

SESSION = Path("sample_data") / "session.toml"


def measure_command_line(root: Path) -> dict[str, float | str]:
    """Wall seconds of a first and a second call, or why there are none under ``failed``.

    The first one finds no compiled functions (``NUMBA_CACHE_DIR`` is a new folder). Python's own
    bytecode is there for both, as an installation by pip leaves it, whatever this environment has:
    a call before them fills a folder of its own with it.
    """
    seconds: dict[str, float | str] = {}
    with tempfile.TemporaryDirectory() as folder:
        environment = {**os.environ, "PYTHONPYCACHEPREFIX": str(Path(folder) / "bytecode")}
        environment.pop("PYTHONDONTWRITEBYTECODE", None)
        for call, functions in (("before", "other"), ("first", "new"), ("second", "new")):
            environment["NUMBA_CACHE_DIR"] = str(Path(folder) / functions)
            start = perf_counter()
            process = subprocess.run(
                [sys.executable, "-m", "nvcore", "compare", str(SESSION)],
                cwd=root,
                env=environment,
                capture_output=True,
                text=True,
                check=False,
            )
            seconds[call] = perf_counter() - start
            # 1 is "findings", unless it comes from a crash
            if process.returncode not in (0, 1) or "Traceback" in process.stderr:
                last = (process.stderr.strip().splitlines() or ["no message"])[-1]
                return {"failed": f"`nvcore compare {SESSION.as_posix()}` fails: {last}"}
    return seconds
