"""Another value than the default for every live parameter; a new parameter is added here."""

from __future__ import annotations

from typing import Any, Final

OTHER: Final[dict[str, Any]] = {
    "alpha": 0.3,
    "distance": "ground",
    "edge_weight": 0.7,
    "proximity": "none",
    "midpoint": 90.0,
    "spread": 30.0,
    "midpoint_m": 20.0,
    "spread_m": 2.0,
    "horizon": 100.0,
    "threshold_x": 0.5,
    "threshold_y": 0.5,
    "match": "lateral",
    "iou": 0.8,
    "lateral_tolerance": 0.1,
    "coverage": 0.9,
    "lag_s": 0.0,
    "gap_s": 0.0,
    "low": 0.99,
    "window": 3.0,
    "tolerance": 0.3,
    "recency_midpoint": 0.2,
    "recency_spread": 0.5,
    "saliency_aggregate": "sum",
    "saliency_scope": "encounter",
}
WITH: Final[dict[str, dict[str, Any]]] = {
    "midpoint_m": {"proximity": "distance"},
    "spread_m": {"proximity": "distance"},
    "horizon": {"proximity": "horizon"},
    "lateral_tolerance": {"match": "lateral", "lateral_tolerance": 0.0},
    "saliency_scope": {"saliency_aggregate": "sum"},
}
"""Where a parameter has an effect at all."""
