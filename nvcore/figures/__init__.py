"""Figures: tables and results in, Plotly figures out. One module of pure functions per family."""

from nvcore.common.extras import needs

with needs("report", "figures need"):
    from nvcore.figures.curves import CurveKind, curve_plot
    from nvcore.figures.dots import recordings_plot, subgroup_forest
    from nvcore.figures.encounters import (
        fusion_plot,
        lead_time_plot,
        miss_classes_plot,
        position_map,
        weightings_plot,
    )
    from nvcore.figures.inputs import false_alarm_plot, proximity_plot, score_plot
    from nvcore.figures.lanes import lanes_figure, loss_strip_plot
    from nvcore.figures.maps import classes_plot, cost_plot, stability_map
    from nvcore.figures.over_time import TimeLayout, loss_plot, similarity_plot
    from nvcore.figures.saliency import parts_plot, plane_plot, recency_plot
    from nvcore.figures.style import CONFIG
    from nvcore.figures.venn import venn_figure

__all__ = [
    "CONFIG",
    "CurveKind",
    "TimeLayout",
    "classes_plot",
    "cost_plot",
    "curve_plot",
    "false_alarm_plot",
    "fusion_plot",
    "lanes_figure",
    "lead_time_plot",
    "loss_plot",
    "loss_strip_plot",
    "miss_classes_plot",
    "parts_plot",
    "plane_plot",
    "position_map",
    "proximity_plot",
    "recency_plot",
    "recordings_plot",
    "score_plot",
    "similarity_plot",
    "stability_map",
    "subgroup_forest",
    "venn_figure",
    "weightings_plot",
]
