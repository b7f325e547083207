"""The compiled loops start where nothing may be written but temporary files, and without those."""

from __future__ import annotations

import os
import platform
import shutil
import stat
import subprocess
import sys
from pathlib import Path

import pytest
from places import ROOT

from nvcore.metrics.kernels.compiling import SHIPPED_CPU, private_folder

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="needs a POSIX system")
CODE = "from nvcore.metrics.kernels import centre; print(centre(10.0, 4.0, 640.0))"


def hardened(
    folder: Path, code: str = CODE, **environment: str
) -> subprocess.CompletedProcess[str]:
    """Runs code on packages that cannot be written to, without a home."""
    kernels = folder / "nvcore" / "metrics" / "kernels"
    if not kernels.exists():
        shutil.copytree(
            ROOT / "nvcore", folder / "nvcore", ignore=shutil.ignore_patterns("__pycache__")
        )
        (kernels / "__pycache__").write_text("in the way of a folder, of root's too")
    clean = {name: value for name, value in os.environ.items() if name != "NUMBA_CACHE_DIR"}
    return subprocess.run(
        [sys.executable, "-c", code], cwd=folder, capture_output=True, text=True,
        env={**clean, "HOME": "/dev/null", "XDG_CACHE_HOME": "/dev/null", **environment},
    )  # fmt: skip


def test_machine_code_is_kept_in_a_private_folder_if_need_be(tmp_path: Path):
    (tmp_path / "tmp").mkdir()
    run = hardened(tmp_path, TMPDIR=str(tmp_path / "tmp"))
    assert (run.stdout, run.stderr) == ("12.0\n", "")
    (kept,) = (tmp_path / "tmp").iterdir()
    assert stat.S_IMODE(kept.stat().st_mode) == 0o700
    assert list(kept.rglob("*.nbi"))


def test_a_folder_that_others_may_change_is_not_used(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    monkeypatch.setattr("tempfile.gettempdir", lambda: str(tmp_path))
    folder = private_folder()
    assert folder is not None
    folder.chmod(0o777)
    assert private_folder() is None
    folder.rmdir()
    folder.symlink_to(tmp_path)
    assert private_folder() is None


def test_without_any_place_loops_are_compiled_anew(tmp_path: Path):
    (tmp_path / f"nvcore-kernels-{os.getuid()}").write_text("in the way")
    run = hardened(tmp_path, TMPDIR=str(tmp_path))
    assert (run.stdout, run.stderr) == ("12.0\n", "")


@pytest.mark.skipif(platform.machine() != "x86_64", reason="the wheel has code for x86-64")
def test_machine_code_of_the_wheel_is_used_while_the_source_is_the_same(tmp_path: Path):
    hardened(tmp_path)
    kernels, code = tmp_path / "nvcore" / "metrics" / "kernels", tmp_path / "code"
    name, features = SHIPPED_CPU
    hardened(tmp_path, NUMBA_CACHE_DIR=str(code), NUMBA_CPU_NAME=name, NUMBA_CPU_FEATURES=features)
    shutil.copytree(next(code.iterdir()), kernels / "machine_code")
    hits = f"{CODE}; print(sum(centre.stats.cache_hits.values()))"
    assert hardened(tmp_path, hits).stdout == "12.0\n1\n"
    with (kernels / "__init__.py").open("a") as source:
        source.write("# changed\n")
    assert hardened(tmp_path, hits).stdout == "12.0\n0\n"
