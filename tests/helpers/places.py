"""Where the project's own files lie, for tests."""

from __future__ import annotations

from pathlib import Path
from typing import Final

ROOT: Final = Path(__file__).resolve().parents[2]
DATA: Final = ROOT / "tests" / "data"
SAMPLE: Final = ROOT / "sample_data" / "session.toml"
