"""Settings with which a training on the sample takes a second or two."""

from __future__ import annotations

from typing import Any

import pytest

QUICK: dict[str, Any] = {
    "window_width": 20,
    "window_height": 40,
    "object_width": 12.0,
    "object_height": 32.0,
    "features": 200,
    "least_area": 16,
    "trees_per_round": (8, 24),
    "negatives": 400,
    "negatives_per_round": 200,
    "copies": 1,
    "scales": (1.0, 1.5, 2.25, 3.4),
}


@pytest.fixture
def quick() -> dict[str, Any]:
    return dict(QUICK)
