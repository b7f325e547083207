"""Figures of an evaluation: errors, estimates, pairs of features, detectability by period."""

from nvcore.extras import needs

with needs("report", "figures need"):
    from nvcore.driver.evaluation.figures.detectability import (
        detectability_histograms_plot,
        detectability_plot,
    )
    from nvcore.driver.evaluation.figures.errors import estimator_errors_plot
    from nvcore.driver.evaluation.figures.estimates import estimates_plot
    from nvcore.driver.evaluation.figures.pairs import feature_pairs_plot, pair_ranks_plot

__all__ = [
    "detectability_histograms_plot",
    "detectability_plot",
    "estimates_plot",
    "estimator_errors_plot",
    "feature_pairs_plot",
    "pair_ranks_plot",
]
