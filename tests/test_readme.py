"""The README shows what the program prints."""

from __future__ import annotations

import re

from click.testing import CliRunner
from places import ROOT

from nvcore.cli import main


def test_the_scorecard_in_the_readme_is_that_of_the_sample_recordings() -> None:
    shown = re.search(r"```text\n(X = .*?)\n```", (ROOT / "README.md").read_text(), re.DOTALL)
    assert shown is not None
    printed = CliRunner().invoke(main, ["compare", str(ROOT / "sample_data" / "session.toml")])
    assert printed.exit_code == 0
    assert shown[1] in printed.stdout
