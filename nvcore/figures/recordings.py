"""Mean similarity of X and Y in every recording."""

from __future__ import annotations

import pandas as pd
import plotly.graph_objects as go

from nvcore.figures.paired import paired_points
from nvcore.palette import Theme


def recordings_plot(recordings: pd.DataFrame, names: tuple[str, str], *, theme: Theme) -> go.Figure:
    """Mean similarity per recording as paired points; `customdata` is the recording's row.

    Parameters
    ----------
    recordings
        `nvcore.tables.recordings_table`.
    names
        Names of X and Y.
    """
    return paired_points(
        recordings, "mean_similarity", names, theme=theme, title="Similarity by recording",
        axis_title="mean similarity (1 = perfect)", higher_is_better=True,
        least_range=(0.5, 1.0),
    )  # fmt: skip
