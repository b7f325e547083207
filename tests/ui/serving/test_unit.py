"""The service of systemd in `deploy`."""

from __future__ import annotations

import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from places import ROOT

ANALYZE = shutil.which("systemd-analyze")


@pytest.mark.skipif(ANALYZE is None, reason="needs systemd")
def test_systemd_finds_no_fault_in_the_unit(tmp_path: Path):
    unit = (ROOT / "deploy" / "nvcore.service").read_text(encoding="utf-8")
    program = "ExecStart=/opt/nvcore/bin/nvcore "
    assert unit.count(program) == 1
    # where the program is not installed, systemd only says so
    path = tmp_path / "nvcore.service"
    path.write_text(unit.replace(program, f"ExecStart={sys.executable} "), encoding="utf-8")
    run = subprocess.run([str(ANALYZE), "verify", path], capture_output=True, text=True)
    assert (run.returncode, run.stdout + run.stderr) == (0, "")
