"""Figures of detectors: boxes on a picture, and what goes on inside of a model."""

from nvcore.extras import needs

with needs("report", "figures need"):
    from nvcore.detectors.figures.boxes import boxes_plot
    from nvcore.detectors.figures.confidence import confidence_plot, traces_plot, training_plot
    from nvcore.detectors.figures.pictures import pictures_plot
    from nvcore.detectors.figures.score_map import score_map_plot
    from nvcore.detectors.figures.tree import tree_plot

__all__ = [
    "boxes_plot",
    "confidence_plot",
    "pictures_plot",
    "score_map_plot",
    "traces_plot",
    "training_plot",
    "tree_plot",
]
