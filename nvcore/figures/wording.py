"""Figures in the words for what the boxes of a dataset are of."""

from __future__ import annotations

from typing import Any, Final

import numpy as np
import plotly.graph_objects as go

from nvcore.dataset import Dataset

TEXTS: Final = frozenset({"text", "name", "hovertemplate", "hovertext", "ticktext"})
"""What of a figure people read, by Plotly's names; a title's text is such a text, too."""


def worded(figure: go.Figure, dataset: Dataset) -> go.Figure:
    """The figure with its texts in the dataset's words; the figure itself of pedestrians.

    Parameters
    ----------
    dataset
        What is shown; its names stay as they are (`nvcore.dataset.Dataset.words`).
    """
    if dataset.objects.are_pedestrians:
        return figure
    return go.Figure(_worded(figure.to_dict(), dataset))


def _worded(part: Any, dataset: Dataset, key: str = "") -> Any:
    """Part of a figure; the texts in it stand under some key of `TEXTS`."""
    if isinstance(part, dict):
        return {name: _worded(value, dataset, name) for name, value in part.items()}
    if isinstance(part, list | tuple | np.ndarray):
        if key not in TEXTS and not any(isinstance(item, dict) for item in part):
            return part  # numbers, as many as there are frames
        return [_worded(item, dataset, key) for item in part]
    return dataset.words(part) if key in TEXTS and isinstance(part, str) else part
