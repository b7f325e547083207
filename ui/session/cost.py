"""What missing a pedestrian would cost in a recording, made once for the settings it depends on."""

from __future__ import annotations

from nvcore.metrics.cost_map import CostMap, map_cost
from nvcore.params.metadata import COST
from ui.session import state


def cost_map_of(recording: int) -> CostMap:
    """The cost map of a recording with the live parameters."""
    dataset, settings = state.opened().dataset, state.params().only_for(COST)
    return state.cached(
        "cost_map",
        (settings, recording),
        lambda: map_cost(dataset.truth, dataset.frame_columns, settings, recording),
        most=8,
    )
