"""Measure process costs: the first `nvcore compare` of the sample, the second, and an import."""

from __future__ import annotations

import os
import resource
import subprocess
import sys
import tempfile
from pathlib import Path
from time import perf_counter

SESSION = Path("sample_data") / "session.toml"
COMPARE = ("-m", "nvcore", "compare", str(SESSION))
CALLS = {
    "before": (COMPARE, "other"),
    "first": (COMPARE, "new"),
    "second": (COMPARE, "new"),
    "import": (("-c", "from nvcore import compare"), "new"),
    "libraries": (("-c", "import numba, pandas, pyarrow, scipy.stats"), "new"),
}
"""Python's arguments and the folder of compiled functions (``NUMBA_CACHE_DIR``), by name.

The first call finds no compiled functions. It does find Python's own bytecode, as after an
installation by pip, because the call before fills a separate folder with it.
"""


def measure_command_line(root: Path) -> dict[str, list[float] | str]:
    """Return wall-clock and processor seconds of each of `CALLS`, or why it ``failed``."""
    seconds: dict[str, list[float] | str] = {}
    with tempfile.TemporaryDirectory() as folder:
        environment = {
            **os.environ,
            "PYTHONPATH": str(root),
            "PYTHONPYCACHEPREFIX": str(Path(folder) / "bytecode"),
        }
        environment.pop("PYTHONDONTWRITEBYTECODE", None)
        for call, (arguments, functions) in CALLS.items():
            environment["NUMBA_CACHE_DIR"] = str(Path(folder) / functions)
            start, used = perf_counter(), _processor_s()
            process = subprocess.run(
                [sys.executable, *arguments],
                cwd=root,
                env=environment,
                capture_output=True,
                text=True,
                check=False,
            )
            seconds[call] = [perf_counter() - start, _processor_s() - used]
            # exit code 1 means "findings", unless it comes from a crash
            if process.returncode not in (0, 1) or "Traceback" in process.stderr:
                last = (process.stderr.strip().splitlines() or ["no message"])[-1]
                return {"failed": f"`python {' '.join(arguments)}` fails: {last}"}
    return seconds


def _processor_s() -> float:
    """Return the processor seconds of all child processes that have ended."""
    usage = resource.getrusage(resource.RUSAGE_CHILDREN)
    return usage.ru_utime + usage.ru_stime
