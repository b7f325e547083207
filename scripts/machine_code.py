"""Compile the loops that a comparison needs, for the wheel of a release.

    python scripts/machine_code.py FOLDER

The loops of the sample's comparison and report are compiled for any x86-64 processor since 2013,
with this Python and its numba. File names contain the version of Python, so that several can fill
one folder. `dashboard_in_wheel.py` puts ``$NVCORE_MACHINE_CODE`` into the wheel.
"""

import os
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

from nvcore.metrics.kernels.compiling import SHIPPED_CPU

SESSION = Path(__file__).parent.parent / "sample_data" / "session.toml"


def compile_loops(folder: Path) -> int:
    """Write index and code of each loop into the folder; return the number of files."""
    folder.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory() as cache, tempfile.TemporaryDirectory() as out:
        name, features = SHIPPED_CPU
        environment = {
            "NUMBA_CACHE_DIR": cache,
            "NUMBA_CPU_NAME": name,
            "NUMBA_CPU_FEATURES": features,
        }
        command = [sys.executable, "-m", "nvcore", "compare", str(SESSION), "--out", out]
        subprocess.run(command, env=os.environ | environment, check=True, stdout=subprocess.DEVNULL)
        made = list(Path(cache).rglob("*.nb?"))
        if len({path.name for path in made}) < len(made):
            raise ValueError("two loops of one name, line and module name")
        for path in made:
            shutil.copy(path, folder)
    return len(made)


if __name__ == "__main__":
    print(compile_loops(Path(sys.argv[1])), "files")
