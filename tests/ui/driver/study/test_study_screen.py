"""What the page hears of a run in the browser."""

from __future__ import annotations

from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import pytest

from nvcore.subjects.driver.study.settings import StudySettings
from nvcore.subjects.driver.study.touch_task import DetectabilityStore, DetectabilityStudy
from ui.subjects.driver.study import screen
from ui.subjects.driver.study.on_screen import OnScreen

NAME = "practice 1 of ABCDEFGH"
NOW = datetime(2026, 3, 1, tzinfo=UTC)


@pytest.fixture
def hears(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> dict[str, Any]:
    """The component's callbacks and the state that the browser sets, for a run with that name."""
    component: dict[str, Any] = {}
    monkeypatch.setattr(screen, "_COMPONENT", lambda **arguments: component.update(arguments))
    monkeypatch.setattr(screen, "address", lambda _: "/nv/token")
    monkeypatch.setattr(screen.st, "session_state", component.setdefault("session", {}))
    component["runs"] = []
    study = DetectabilityStudy(
        settings=StudySettings(), pictures=(), folder="", begun_at=NOW, ends_at=NOW
    )
    shown = OnScreen(DetectabilityStore(tmp_path / "a.sqlite"), study, "ABCDEFGH", tmp_path)
    screen.draw_run(shown, NAME, "Begin", [], on_end=component["runs"].append)
    return component


@pytest.mark.parametrize(("told", "runs"), [("ended", [NAME]), ("stopped", [])])
def test_a_run_that_was_seen_to_its_end_has_ended(hears: dict[str, Any], told: str, runs: list):
    hears["session"]["study_screen"] = {"ended": None, "stopped": None, told: NAME}
    hears[f"on_{told}_change"]()
    assert hears["runs"] == runs
