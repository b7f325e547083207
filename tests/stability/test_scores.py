"""Every cell of a stability map is a comparison of its own, with the settings of that cell."""

from __future__ import annotations

from dataclasses import replace
from typing import Any, get_args

import numpy as np
import pytest
from scenes import draw_scene

from nvcore.comparison.compare import Result, compare
from nvcore.evidence.stability.axes import Plane
from nvcore.evidence.stability.map import StabilityMap, map_stability
from nvcore.evidence.stability.scores import Criterion
from nvcore.settings.params import Params

PLANES: tuple[Plane, ...] = get_args(Plane)
CRITERIA: tuple[Criterion, ...] = get_args(Criterion)


def difference_of(result: Result, criterion: Criterion) -> float:
    """What a cell should hold, from the comparison at that setting; NaN where undefined."""
    if criterion == "similarity":
        return result.x.summary.mean - result.y.summary.mean
    if criterion == "saliency":
        return result.y.saliency_s - result.x.saliency_s
    near = result.category[result.category != "distant"]
    counts = int((near == "x_only").sum()) - int((near == "y_only").sum())
    return float(counts) if len(near) else np.nan


def assert_cells_are_comparisons(
    stability: StabilityMap, result: Result, cells: np.ndarray
) -> None:
    names = (result.x.name, result.y.name)
    for cell in cells:
        params = replace(result.params, **stability.settings(int(cell)))
        there = compare(result.dataset, params, x=names[0], y=names[1])
        assert stability.difference.ravel()[cell] == pytest.approx(
            difference_of(there, stability.criterion), abs=1e-12, nan_ok=True
        ), (stability.plane, stability.criterion, stability.settings(int(cell)))


SETTINGS: list[dict[str, Any]] = [
    {},
    {"threshold_x": 0.35, "match": "lateral", "saliency_aggregate": "sum", "iou": 0.45},
    {"proximity": "distance", "saliency_scope": "encounter", "distance": "ground"},
    {"proximity": "horizon", "threshold_y": 0.5, "alpha": 0.33, "edge_weight": 0.2},
    {"proximity": "none", "coverage": 0.3, "tolerance": 0.01},
    {"midpoint": 31.4, "spread": 9.0, "threshold_x": 2.0},
]


@pytest.mark.parametrize(
    ("plane", "number"),
    [  # every plane with half of the settings
        (plane, (2 * i + j) % len(SETTINGS))
        for j, plane in enumerate(PLANES)
        for i in range(len(SETTINGS) // 2)
    ],
)
def test_every_cell_is_the_comparison_at_its_setting(plane: Plane, number: int) -> None:
    # scenes have ignore regions, missing scores, pictures of different sizes, tracks given twice
    rng = np.random.default_rng(number)
    result = compare(draw_scene(40 + number).dataset(), Params(**SETTINGS[number]))
    for criterion in CRITERIA:
        stability = map_stability(result, plane, criterion, n_points=4)
        cells = rng.choice(stability.difference.size, 4, replace=False)
        assert_cells_are_comparisons(stability, result, cells)


def test_one_matching_gives_every_threshold_where_all_detections_have_scores() -> None:
    scene = draw_scene(7, is_grid=True)
    scene.x = [box._replace(score=0.3 if np.isnan(box.score) else box.score) for box in scene.x]
    result = compare(scene.dataset(), Params(threshold_x=0.5))
    for criterion in CRITERIA:
        stability = map_stability(result, "thresholds", criterion, n_points=4)
        assert_cells_are_comparisons(stability, result, np.arange(stability.difference.size))
