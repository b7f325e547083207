"""Encounters: how X and Y miss them, who sees them first, and where in the picture."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Final

import numpy as np
import pandas as pd
import plotly.graph_objects as go

from nvcore.figures.marks import marks
from nvcore.figures.style import (
    LOOK,
    axis,
    counts_axis,
    draw,
    empty_figure,
    faded,
    plain,
    system_label,
    which_is_which,
)
from nvcore.objects import Objects
from nvcore.palette import Theme
from nvcore.schema import MISS_CLASS_TEXT, Category, MissClass
from nvcore.wording import count_text

LABELS: Final = {"x": "X", "y": "Y", "x_or_y": "X or Y", "x_and_y": "X and Y"}
SYMBOLS: Final = {"x": "circle", "y": "diamond", "x_or_y": "star", "x_and_y": "square"}


def _label_of(system: str, alike: Sequence[str]) -> str:
    """What stands beside a mark: the names of all systems at its place, beside the first."""
    return " = ".join(LABELS[name] for name in alike) if system == alike[0] else ""


def fusion_plot(fusion: pd.DataFrame, *, theme: Theme) -> go.Figure:
    """Four points: up is more encounters detected, left is fewer false alerts.

    Parameters
    ----------
    fusion
        `nvcore.tables.encounters.miss_classes.fusion_table`.
    """
    n_encounters = int(fusion["encounters"].max()) if len(fusion) else 0
    if not n_encounters:
        return empty_figure("There is no encounter that counts.", theme=theme)
    look = LOOK[theme]
    colour = {"x": look.x, "y": look.y, "x_or_y": look.ink, "x_and_y": look.muted}
    symbol = {**SYMBOLS, "x": look.symbol("x"), "y": look.symbol("y")}
    rows: list[Any] = list(fusion.itertuples(index=False))
    places: dict[tuple[int, int], list[str]] = {}
    for row in rows:
        places.setdefault((row.false_alert_episodes, row.encounters_detected), []).append(
            row.system
        )
    # of systems at one place each mark lies inside the one before, and one label names them all
    alike = {name: names for names in places.values() for name in names}
    traces = [
        go.Scatter(
            x=[row.false_alert_episodes],
            y=[row.encounters_detected],
            mode="markers+text",
            text=[_label_of(row.system, alike[row.system])],
            textposition="middle right",
            cliponaxis=False,
            textfont={
                "size": 13,
                "color": colour[row.system] if len(alike[row.system]) == 1 else look.ink,
            },
            marker={
                "size": 14 + NEST_PX * (len(alike[row.system]) - 1 - place),
                "symbol": symbol[row.system],
                "color": colour[row.system],
                "line": {"width": 1, "color": look.surface},
            },
            hovertext=[
                f"{LABELS[row.system]}: {plain(row.name)}<br>{row.encounters_detected} of "
                f"{n_encounters} encounters<br>{row.false_alert_episodes:,} false-alert episodes"
            ],
            hovertemplate="%{hovertext}<extra></extra>",
            name=LABELS[row.system],
        )
        for row in rows
        for place in (alike[row.system].index(row.system),)
    ]
    most = float(fusion["false_alert_episodes"].max())
    ends = [-0.05 * most, 1.2 * most or 1.0]
    return draw(
        traces,
        theme,
        title="What using both would gain and cost",
        subtitle=f"{n_encounters:,} encounters that count; best is top left{which_is_which(theme)}",
        hoverdistance=24,
        showlegend=False,
        xaxis=axis(theme, "false-alert episodes", range=ends, fixedrange=True),
        yaxis=axis(theme, "encounters detected", range=[0, 1.08 * n_encounters], fixedrange=True),
    )


CLASS_WORDS: Final = {
    MissClass.NEVER: "never",
    MissClass.LATE: "late",
    MissClass.DROPOUT: "dropout",
    MissClass.LOST_EARLY: "lost early",
    MissClass.BRIEF: "brief",
    MissClass.NONE: "no failure",
}
NEST_PX: Final = 10
"""By how much a mark is larger than the one inside it."""
NONE_LEFT: Final = "No encounter is left: widen the filters."
MAX_BINS: Final = 25
LEAD_STEPS_S: Final = (0.05, 0.1, 0.2, 0.5, 1.0, 2.0, 5.0, 10.0)
"""Widths of the bins of lead time that are easy to read."""
FEW: Final = 6
"""Counts up to which every whole number gets a tick."""
MAX_MARKS: Final = 4000
"""Encounters on the map; detected ones are thinned out first."""
MAP_KINDS: Final = (
    (Category.DISTANT, "distant", "pale", "circle-open"),
    (Category.BOTH, "detected by both", "muted", "circle-open"),
    (Category.Y_ONLY, "missed by X", "x", "x"),
    (Category.X_ONLY, "missed by Y", "y", "triangle-down"),
    (Category.NEITHER, "missed by both", "ink", "square-x"),
)
"""Category, words, colour and symbol; the later ones are drawn on top."""
MAP_SIZES: Final = (6.0, 22.0)
"""Of a mark without severity, and of the one with the largest, px."""


def miss_classes_plot(
    encounters: pd.DataFrame, names: tuple[str, str], *, theme: Theme, objects: Objects
) -> go.Figure:
    """How many encounters have which miss class, X against Y; `customdata` is the class.

    Pointing at a bar tells what its failures weigh.

    Parameters
    ----------
    encounters
        `nvcore.tables.result.encounters_table`, or rows of it.
    names
        Names of X and Y.
    """
    near = encounters[encounters["category"] != Category.DISTANT.value]
    if near.empty:
        return empty_figure(NONE_LEFT, theme=theme)
    place = np.arange(len(MissClass), dtype=float)
    kinds = [kind.value for kind in MissClass]
    look = LOOK[theme]
    traces = []
    for letter, name in zip("xy", names, strict=True):
        of_class = near.groupby(f"miss_class_{letter}")[f"severity_s_{letter}"]
        counts, severity_s = (
            values.reindex(kinds, fill_value=0) for values in (of_class.size(), of_class.sum())
        )
        # a dashed system's bars are outlined
        colour = look.of(letter)
        marker = {
            "color": colour if look.dash(letter) == "solid" else faded(colour, 0.3),
            "line": {"width": 2, "color": colour},
            "cornerradius": 3,
        }
        traces.append(
            go.Bar(
                x=place,
                y=counts.to_numpy(),
                customdata=kinds,
                name=system_label(letter, name),
                text=counts.to_numpy(),
                textposition="outside",
                cliponaxis=False,
                hovertext=[
                    f"{objects.say(MISS_CLASS_TEXT[kind])}<br>"
                    f"severity in all {severity_s[kind]:.2f} s"
                    for kind in MissClass
                ],
                hovertemplate=f"{letter.upper()}: %{{y}}<br>%{{hovertext}}<extra></extra>",
                marker=marker,
            )
        )
    return draw(
        traces,
        theme,
        title="How encounters are missed",
        subtitle=f"{count_text(len(near), 'encounter')} that came near enough to count",
        bargap=0.3,
        bargroupgap=0.08,
        xaxis=axis(
            theme,
            "miss class",
            tickvals=place,
            ticktext=[CLASS_WORDS[kind].replace(" ", "<br>") for kind in MissClass],
            tickangle=0,  # turned, the last label may find no room and is left out
            showgrid=False,
            fixedrange=True,
        ),
        yaxis=counts_axis(theme),
    )


def lead_bins(lead_s: np.ndarray) -> tuple[np.ndarray, float]:
    """Centres and width of the bins of lead time, seconds; one of them is centred at 0."""
    reach = float(np.abs(lead_s).max(initial=0))
    width = next(
        (step for step in LEAD_STEPS_S if 2 * reach / step <= MAX_BINS - 1),
        2 * reach / (MAX_BINS - 1),
    )
    half = max(2, int(np.floor(reach / width + 0.5)))
    return np.arange(-half, half + 1) * width, width


def lead_time_plot(encounters: pd.DataFrame, *, theme: Theme, objects: Objects) -> go.Figure:
    """How much earlier X matches an encounter than Y; right of 0 X is first.

    Parameters
    ----------
    encounters
        `nvcore.tables.result.encounters_table`, or rows of it.
    """
    lead_s = encounters["lead_time_s"].to_numpy(dtype=float)
    lead_s = lead_s[np.isfinite(lead_s)]
    if not len(lead_s):
        return empty_figure("No encounter here was matched by both systems.", theme=theme)
    centre, width = lead_bins(lead_s)
    # a multiple of the width lies in the middle of its bin, whatever the rounding
    bin_of = np.clip(np.round(lead_s / width).astype(int) + len(centre) // 2, 0, len(centre) - 1)
    most = np.bincount(bin_of).max()
    look = LOOK[theme]
    traces = []
    # the bin around 0 also holds small leads: whoever leads is told by the lead, not by the bin
    for label, colour, leads in (
        ("Y first", look.y, lead_s < 0),
        ("at the same time", look.muted, lead_s == 0),
        ("X first", look.x, lead_s > 0),
    ):
        counts = np.bincount(bin_of[leads], minlength=len(centre))
        bins = counts > 0
        traces.append(
            go.Bar(
                x=centre[bins],
                y=counts[bins],
                width=0.9 * width,
                name=label,
                marker={"color": colour, "cornerradius": 2},
                hovertemplate=f"%{{x:.2f}} s (± {width / 2:g} s): %{{y}}<extra></extra>",
            )
        )
    matched = f"{count_text(len(lead_s), 'encounter')} matched by both"
    tick = {"dtick": 1} if most <= FEW else {}
    ends = [centre[0] - width, centre[-1] + width]
    lead = "← Y first        lead time of X over Y (s)        X first →"
    return draw(
        traces,
        theme,
        title=objects.say("Who sees {a_one} first"),
        subtitle=(
            f"{matched}: X first in {int((lead_s > 0).sum())}, Y in {int((lead_s < 0).sum())}; "
            f"median {np.median(lead_s) + 0.0:+.2f} s{which_is_which(theme)}"
        ),
        barmode="stack",
        xaxis=axis(theme, lead, range=ends),
        yaxis=counts_axis(theme, **tick),
    )


def _severities(row: Any) -> str:
    return f"severity X {row.severity_s_x:.2f} s, Y {row.severity_s_y:.2f} s"


def position_map(encounters: pd.DataFrame, *, theme: Theme, objects: Objects) -> go.Figure:
    """Where in the picture each system misses: sideways position by height.

    `customdata` is the row of the encounter (the index of the table).

    Parameters
    ----------
    encounters
        `nvcore.tables.result.encounters_table`, or rows of it with its index.
    """
    if encounters.empty:
        return empty_figure(NONE_LEFT, theme=theme)
    look = LOOK[theme]
    category = encounters["category"].to_numpy()
    n_misses = int(np.isin(category, [kind.value for kind, *_ in MAP_KINDS[2:]]).sum())
    share = max(0, MAX_MARKS - n_misses) / max(1, len(encounters) - n_misses)
    step = max(1, int(np.ceil(1 / share))) if share > 0 else len(encounters)
    traces = []
    n_drawn = 0
    severity_s = encounters[["severity_s_x", "severity_s_y"]].max(axis=1).fillna(0.0)
    relative = severity_s / max(float(severity_s.max()), 1e-9)
    size_px = MAP_SIZES[0] + (MAP_SIZES[1] - MAP_SIZES[0]) * np.sqrt(relative)
    for kind, words, colour, symbol in MAP_KINDS:
        part = encounters[category == kind.value]
        if kind in (Category.DISTANT, Category.BOTH):
            part = part.iloc[::step]
        else:
            part = part.iloc[:MAX_MARKS]
        n_drawn += len(part)
        text = [
            f"{plain(row.recording)}, {objects.singular} {row.track}: {words}<br>"
            f"{row.peak_height:.0f} px tall"
            + ("" if np.isnan(row.severity_s_x) else f"<br>{_severities(row)}")
            for row in part.itertuples(index=False)
        ]
        shade = getattr(look, colour)
        line = {"width": 1.5, "color": shade}
        traces.append(
            marks(
                part["lateral_position"].to_numpy(),
                part["peak_height"].to_numpy(),
                text,
                customdata=part.index.to_numpy(),
                name=f"{words} ({np.count_nonzero(category == kind.value):,})",
                marker={
                    "symbol": symbol,
                    "size": size_px[part.index].to_numpy(),
                    "color": shade,
                    "line": line,
                },
            )
        )
    extent = count_text(len(encounters), "encounter")
    if n_drawn < len(encounters):
        extent += f", {n_drawn:,} of them drawn"
    tallest = float(encounters["peak_height"].max())
    return draw(
        traces,
        theme,
        title=f"Where {objects.plural} are missed",
        subtitle=f"{extent}; colour: the system that misses, size: severity{which_is_which(theme)}",
        height=430,
        showlegend=True,
        hoverdistance=24,
        xaxis=axis(
            theme,
            "mean position in the picture",
            range=[-1.05, 1.05],
            fixedrange=True,
            tickvals=[-1, -0.5, 0, 0.5, 1],
            ticktext=["left", "", "middle", "", "right"],
        ),
        yaxis=axis(theme, "largest height (px)", range=[0, 1.06 * tallest]),
    )
