"""Measures of the detector of speed signs."""

from __future__ import annotations

import numpy as np
from places import ROOT

from nvcore.metrics.detection import DetectionCurve
from nvcore.settings.protocols import PROTOCOLS
from scripts.detectors.sign_measures import first_with_all, missed


def test_false_positives_are_counted_where_all_are_found_first_and_the_page_says_so():
    curve = DetectionCurve(
        system="x",
        protocol=PROTOCOLS["all"],
        threshold=np.array([0.9, 0.8, 0.5, 0.1]),
        tp=np.array([1, 2, 2, 2]),
        fp=np.array([0, 0, 1, 9]),
        n_truth=3,
        n_images=4,
    )
    assert first_with_all(curve) == 1
    assert missed(curve) == 1
    page = (ROOT / "docs" / "validation.md").read_text(encoding="utf-8")
    assert "False positives at the highest threshold that finds all signs that any finds" in page
    assert "False positives at the lowest threshold" not in page
