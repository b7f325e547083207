"""Figure of a measure over the versions of a system, with the gate's limit."""

from __future__ import annotations

import numpy as np
import pandas as pd
import plotly.graph_objects as go

from nvcore.common.palette import Theme
from nvcore.common.wording import capitalised
from nvcore.comparison.compare import Result
from nvcore.comparison.measures.table import label_words
from nvcore.figures.marks import curve_line, rule
from nvcore.figures.style import LOOK, plain
from nvcore.report.gate.measures import MEASURE_OF
from nvcore.report.gate.rules import parse_rule


def version_plot(result: Result, measures: pd.DataFrame, *, theme: Theme) -> go.Figure:
    """Plot one measure over the versions. Crosses break the gate's rule, whose limit is a line.

    Parameters
    ----------
    measures
        Rows of `nvcore.subjects.releases.versions.measures_of_versions` about the measure.
    """
    look, name, text = LOOK[theme], measures["measure"].iloc[0], measures["rule"].iloc[0]
    form, title = "g", capitalised(name.replace("_", " "))
    if (measure := MEASURE_OF.get(name)) is not None:
        form = measure.form.replace("d", ".0f")
        title = capitalised(result.objects.say(measure.label, **label_words(result)))
    versions = [plain(version, max_length=14) for version in measures["version"]]
    values = measures["value"].to_numpy(dtype=float)
    limit = parse_rule(text).limit if pd.notna(text) else np.nan
    known = np.array([*values, limit])[np.isfinite([*values, limit])]
    if not np.isfinite(values).any():
        return look.empty(f"{title}: undefined.")
    low, high = known.min(), known.max()
    room = 0.15 * (high - low) or 1.0
    is_broken = measures["is_met"].eq(False).fillna(False).to_numpy(dtype=bool)
    symbols = np.where(is_broken, "x", "circle")
    trace = curve_line(
        np.arange(len(versions)),
        values,
        [f"{version}: {value:{form}}" for version, value in zip(versions, values, strict=True)],
        line={"width": 2, "color": look.muted},
        marker={"size": 9, "color": look.ink, "symbol": symbols},
    )
    figure = look.draw(
        [trace],
        title=title,
        subtitle=plain(text, max_length=60) if pd.notna(text) else "",
        height=240,
        showlegend=False,
        xaxis=look.cells_axis("", versions, range=[-0.4, len(versions) - 0.6]),
        yaxis=look.axis(
            tickformat=f"{form[:-1]}~{form[-1]}", nticks=4, range=[low - room, high + room]
        ),
    )
    if pd.notna(text):
        rule(figure, "y", limit, color=look.ink, dash="dash")
    return figure
