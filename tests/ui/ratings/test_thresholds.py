"""Score thresholds of rated clips beside those in use."""

from __future__ import annotations

from types import SimpleNamespace

import pytest

from ui.subjects.ratings import thresholds


@pytest.mark.parametrize(
    ("of_clips", "now", "expected"),
    [
        (0.5, 0.5, {}),
        (0.5, 0.6, {"X": (0.5, 0.6)}),
        (0.1, None, {}),  # every detection: none scores less
        (0.1, 0.2, {"X": (None, 0.2)}),
        (2.0, 0.9, {}),  # as high as the highest score
        (None, None, {}),
    ],
)
def test_thresholds_differ_if_they_show_other_boxes(monkeypatch, of_clips, now, expected):
    monkeypatch.setattr(thresholds, "shown_thresholds", lambda: {"X": now, "unscored": None})
    spans = {"X": (0.1, 0.9), "unscored": None}
    monkeypatch.setattr(thresholds.state, "score_span", spans.__getitem__)
    study = SimpleNamespace(thresholds={"X": of_clips, "unscored": 0.3})
    assert thresholds.thresholds_apart(study) == expected
