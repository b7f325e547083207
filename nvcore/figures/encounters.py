"""Figures of encounters: miss classes, lead times, positions of misses, and weightings."""

from __future__ import annotations

from typing import Any, Final

import numpy as np
import pandas as pd
import plotly.graph_objects as go

from nvcore.common.palette import Theme
from nvcore.common.wording import count_text, number
from nvcore.comparison.compare import Result
from nvcore.dataset.schema import MISS_CLASS_TEXT, Category, MissClass
from nvcore.figures.marks import marks, still_line
from nvcore.figures.style import LOOK, Names, faded, plain, system_label, which_is_which
from nvcore.metrics.encounters import RELEVANT_K
from nvcore.settings.objects import Objects
from nvcore.tables.encounters.weightings import Weightings

LABELS: Final = {"x": "X", "y": "Y", "x_or_y": "X or Y", "x_and_y": "X and Y"}
CLASS_WORDS: Final = {
    kind: "no failure" if kind is MissClass.NONE else kind.value.replace("_", " ")
    for kind in MissClass
}
NEST_PX: Final = 10
"""Difference in size between a mark and the one inside it."""
NONE_LEFT: Final = "No encounter is left: widen the filters."
MAX_BINS: Final = 25
LEAD_STEPS_S: Final = (0.05, 0.1, 0.2, 0.5, 1.0, 2.0, 5.0, 10.0)
"""Candidate widths of the bins of lead time, which are easy to read."""
MAX_MARKS: Final = 4000
"""Maximum number of encounters on the map. Detected ones are thinned out first."""
MAP_KINDS: Final = (
    (Category.DISTANT, "distant", "pale", "circle-open"),
    (Category.BOTH, "detected by both", "muted", "circle-open"),
    (Category.Y_ONLY, "missed by X", "x", "x"),
    (Category.X_ONLY, "missed by Y", "y", "triangle-down"),
    (Category.NEITHER, "missed by both", "ink", "square-x"),
)
"""Category, words, colour and symbol. The later ones are drawn on top."""
MAP_SIZES: Final = (6.0, 22.0)
"""Sizes of a mark without severity and of the one with the largest, px."""
WEIGHTINGS: Final = {
    "height": ("solid", 2.0, "ink"),
    "horizon": ("dash", 2.0, "muted"),
    "distance": ("dot", 3.0, "ink"),
}
"""Dash, width and colour of a curve, all different from the systems'."""
LANES: Final = {"x": -0.17, "y": -0.34}
"""Places of the detections of X and Y below the curves."""


def fusion_plot(fusion: pd.DataFrame, *, theme: Theme) -> go.Figure:
    """Plot four points: up is more encounters detected, left is fewer false alerts.

    Parameters
    ----------
    fusion
        `nvcore.tables.encounters.miss_classes.fusion_table`.
    """
    look, n_encounters = LOOK[theme], int(fusion["encounters"].max()) if len(fusion) else 0
    if not n_encounters:
        return look.empty("There is no encounter that counts.")
    looks = {
        "x": (look.x, look.symbol("x")),
        "y": (look.y, look.symbol("y")),
        "x_or_y": (look.ink, "star"),
        "x_and_y": (look.muted, "square"),
    }
    # where systems coincide, each mark lies inside the one before, and one label names them all
    by_place = fusion.groupby(["false_alert_episodes", "encounters_detected"])["system"]
    alike: dict[Any, list[str]] = by_place.agg(list).to_dict()
    traces = []
    rows: Any = fusion.itertuples(index=False)
    for row in rows:
        names = alike[row.false_alert_episodes, row.encounters_detected]
        place, (colour, symbol) = names.index(row.system), looks[row.system]
        trace = go.Scatter(
            x=[row.false_alert_episodes],
            y=[row.encounters_detected],
            mode="markers+text",
            text=["" if place else " = ".join(LABELS[name] for name in names)],
            textposition="middle right",
            cliponaxis=False,
            textfont={"size": 13, "color": colour if len(names) == 1 else look.ink},
            marker={
                "size": 14 + NEST_PX * (len(names) - 1 - place),
                "symbol": symbol,
                "color": colour,
                "line": {"width": 1, "color": look.surface},
            },
            hovertext=[
                f"{LABELS[row.system]}: {plain(row.name)}<br>{row.encounters_detected} of "
                f"{n_encounters} encounters<br>{row.false_alert_episodes:,} false-alert episodes"
            ],
            hovertemplate="%{hovertext}<extra></extra>",
            name=LABELS[row.system],
        )
        traces.append(trace)
    most = float(fusion["false_alert_episodes"].max())
    return look.draw(
        traces,
        title="What using both would gain and cost",
        subtitle=f"{n_encounters:,} encounters that count; best is top left{which_is_which(theme)}",
        hoverdistance=24,
        showlegend=False,
        xaxis=look.axis("false-alert episodes", range=[-0.05 * most, 1.2 * most or 1.0]),
        yaxis=look.axis("encounters detected", range=[0, 1.08 * n_encounters]),
    )


def miss_classes_plot(
    encounters: pd.DataFrame, names: Names, *, theme: Theme, objects: Objects
) -> go.Figure:
    """Plot the number of encounters of each miss class, X against Y.

    `customdata` is the class. The hover text of a bar tells what its failures weigh.

    Parameters
    ----------
    encounters
        `nvcore.tables.result.encounters_table`, or rows of it.
    """
    look, near = LOOK[theme], encounters[encounters["category"] != Category.DISTANT.value]
    if near.empty:
        return look.empty(NONE_LEFT)
    place = np.arange(len(MissClass), dtype=float)
    kinds = [kind.value for kind in MissClass]
    traces = []
    for letter, name in zip("xy", names, strict=True):
        of_class = near.groupby(f"miss_class_{letter}")[f"severity_s_{letter}"]
        counts, severity_s = (
            values.reindex(kinds, fill_value=0) for values in (of_class.size(), of_class.sum())
        )
        colour = look.of(letter)
        bars = go.Bar(
            x=place,
            y=counts.to_numpy(),
            customdata=kinds,
            name=system_label(letter, name),
            text=counts.to_numpy(),
            textposition="outside",
            cliponaxis=False,
            hovertext=[
                f"{objects.say(MISS_CLASS_TEXT[kind])}<br>severity in all {severity_s[kind]:.2f} s"
                for kind in MissClass
            ],
            hovertemplate=f"{letter.upper()}: %{{y}}<br>%{{hovertext}}<extra></extra>",
            marker={
                # a dashed system's bars are outlined
                "color": colour if look.dash(letter) == "solid" else faded(colour, 0.3),
                "line": {"width": 2, "color": colour},
                "cornerradius": 3,
            },
        )
        traces.append(bars)
    return look.draw(
        traces,
        title="How encounters are missed",
        subtitle=f"{count_text(len(near), 'encounter')} that came near enough to count",
        bargap=0.3,
        bargroupgap=0.08,
        xaxis=look.axis(
            "miss class",
            tickvals=place,
            ticktext=[CLASS_WORDS[kind].replace(" ", "<br>") for kind in MissClass],
            tickangle=0,  # turned, the last label may find no room and is left out
            showgrid=False,
        ),
        yaxis=look.counts_axis(),
    )


def lead_bins(lead_s: np.ndarray) -> tuple[np.ndarray, float]:
    """Return centres and width of the bins of lead time, seconds, one of them centred at 0."""
    reach = float(np.abs(lead_s).max(initial=0))
    least = 2 * reach / (MAX_BINS - 1)
    width = next((step for step in LEAD_STEPS_S if 2 * reach / step <= MAX_BINS - 1), least)
    half = max(2, int(np.floor(reach / width + 0.5)))
    return np.arange(-half, half + 1) * width, width


def lead_time_plot(encounters: pd.DataFrame, *, theme: Theme, objects: Objects) -> go.Figure:
    """Plot how much earlier X matches encounters than Y: right of 0 X is first.

    Parameters
    ----------
    encounters
        `nvcore.tables.result.encounters_table`, or rows of it.
    """
    look, lead_s = LOOK[theme], encounters["lead_time_s"].to_numpy(dtype=float)
    lead_s = lead_s[np.isfinite(lead_s)]
    if not len(lead_s):
        return look.empty("No encounter here was matched by both systems.")
    centre, width = lead_bins(lead_s)
    # a multiple of the width lies in the middle of its bin, whatever the rounding
    bin_of = np.clip(np.round(lead_s / width).astype(int) + len(centre) // 2, 0, len(centre) - 1)
    n_x, n_y = int((lead_s > 0).sum()), int((lead_s < 0).sum())
    traces = []
    # the bin around 0 also holds small leads, so the leader follows from the lead, not the bin
    for label, colour, leads in (
        ("Y first", look.y, lead_s < 0),
        ("at the same time", look.muted, lead_s == 0),
        ("X first", look.x, lead_s > 0),
    ):
        counts = np.bincount(bin_of[leads], minlength=len(centre))
        bins = counts > 0
        bars = go.Bar(
            x=centre[bins],
            y=counts[bins],
            width=0.9 * width,
            name=label,
            marker={"color": colour, "cornerradius": 2},
            hovertemplate=f"%{{x:.2f}} s (± {width / 2:g} s): %{{y}}<extra></extra>",
        )
        traces.append(bars)
    ends = [centre[0] - width, centre[-1] + width]
    # few counts get a tick at every whole number
    ticks = {"dtick": 1} if np.bincount(bin_of).max() <= 6 else {}
    lead = "← Y first        lead time of X over Y (s)        X first →"
    return look.draw(
        traces,
        title=objects.say("Who sees {a_one} first"),
        subtitle=f"{count_text(len(lead_s), 'encounter')} matched by both: X first in {n_x}, Y in "
        f"{n_y}; median {np.median(lead_s) + 0.0:+.2f} s{which_is_which(theme)}",
        barmode="stack",
        xaxis=look.axis(lead, can_zoom=True, range=ends),
        yaxis=look.counts_axis(**ticks),
    )


def position_map(encounters: pd.DataFrame, *, theme: Theme, objects: Objects) -> go.Figure:
    """Plot where in the picture each system misses: sideways position by height.

    `customdata` is the row of the encounter (the index of the table).

    Parameters
    ----------
    encounters
        `nvcore.tables.result.encounters_table`, or rows of it with its index.
    """
    look = LOOK[theme]
    if encounters.empty:
        return look.empty(NONE_LEFT)
    category = encounters["category"].to_numpy()
    n_misses = int(np.isin(category, [kind.value for kind, *_ in MAP_KINDS[2:]]).sum())
    room, n_detected = MAX_MARKS - n_misses, len(encounters) - n_misses
    step = max(1, -(-n_detected // room)) if room > 0 else len(encounters)
    severity_s = encounters[["severity_s_x", "severity_s_y"]].max(axis=1).fillna(0.0)
    relative = severity_s / max(float(severity_s.max()), 1e-9)
    size_px = MAP_SIZES[0] + (MAP_SIZES[1] - MAP_SIZES[0]) * np.sqrt(relative)
    traces, n_drawn = [], 0
    for kind, words, colour, symbol in MAP_KINDS:
        part = encounters[category == kind.value]
        name = f"{words} ({len(part):,})"
        is_detected = kind in (Category.DISTANT, Category.BOTH)
        part = part.iloc[::step] if is_detected else part.iloc[:MAX_MARKS]
        n_drawn += len(part)
        rows: Any = part.itertuples(index=False)
        text = [
            f"{plain(row.recording)}, {objects.singular} {row.track}: {words}<br>"
            f"{row.peak_height:.0f} px tall"
            + (
                ""
                if np.isnan(row.severity_s_x)
                else f"<br>severity X {row.severity_s_x:.2f} s, Y {row.severity_s_y:.2f} s"
            )
            for row in rows
        ]
        shade = getattr(look, colour)
        marker = {"symbol": symbol, "color": shade, "line": {"width": 1.5, "color": shade}}
        mark = marks(
            part["lateral_position"].to_numpy(),
            part["peak_height"].to_numpy(),
            text,
            customdata=part.index.to_numpy(),
            name=name,
            marker=marker | {"size": size_px[part.index].to_numpy()},
        )
        traces.append(mark)
    extent = count_text(len(encounters), "encounter")
    if n_drawn < len(encounters):
        extent += f", {n_drawn:,} of them drawn"
    return look.draw(
        traces,
        title=f"Where {objects.plural} are missed",
        subtitle=f"{extent}; colour: the system that misses, size: severity{which_is_which(theme)}",
        height=430,
        showlegend=True,
        hoverdistance=24,
        xaxis=look.axis(
            "mean position in the picture",
            range=[-1.05, 1.05],
            tickvals=[-1, -0.5, 0, 0.5, 1],
            ticktext=["left", "", "middle", "", "right"],
        ),
        yaxis=look.axis(
            "largest height (px)",
            can_zoom=True,
            range=[0, 1.06 * float(encounters["peak_height"].max())],
        ),
    )


def weightings_plot(
    result: Result, encounter: int, weightings: Weightings, *, theme: Theme
) -> go.Figure:
    """Plot the weight k over time by each weighting, and the frames in which X and Y detect.

    Parameters
    ----------
    encounter
        Row of ``result.encounters``.
    weightings
        Of it, from `nvcore.tables.encounters.weightings.compare_weightings`.
    """
    look, curves, noun = LOOK[theme], weightings.curves, result.objects.singular
    time_s = curves["time_s"].to_numpy()
    ends_s, level = time_s[[0, -1]], [RELEVANT_K] * 2
    traces = [still_line(ends_s, level, "counts", color=look.muted, width=1)]
    for kind, (dash, width, colour) in WEIGHTINGS.items():
        k = curves[f"k_{kind}"].to_numpy()
        if np.isnan(k).all():
            continue
        texts = [
            f"frame {frame}, {second:.2f} s<br>k by {kind} {number(value, '.2f')}"
            for frame, second, value in zip(curves["frame"], time_s, k, strict=True)
        ]
        line = {"dash": dash, "width": width, "color": getattr(look, colour)}
        traces.append(marks(time_s, k, texts, mode="lines", name=f"by {kind}", line=line))
    for letter, system in result.sides:
        detected, rim = curves[curves[f"matched_{letter}"]], {"width": 2, "color": look.of(letter)}
        lane = marks(
            detected["time_s"],
            np.full(len(detected), LANES[letter]),
            [f"{letter.upper()} detects the {noun}, frame {frame}" for frame in detected["frame"]],
            name=system_label(letter, system.name),
            showlegend=False,
            marker={"color": look.of(letter), "size": 9, "symbol": "line-ns", "line": rim},
        )
        traces.append(lane)
    name = plain(result.dataset.recordings["name"].iloc[result.encounters.recording[encounter]])
    return look.draw(
        traces,
        title=f"How near {noun} {result.encounters.track[encounter]} of {name} counts",
        subtitle=f"{count_text(len(curves), 'frame')}, which count from k = {RELEVANT_K:g} on; "
        f"below: those in which X and Y detect the {noun}{which_is_which(theme)}",
        height=370,
        xaxis=look.axis("time (s)"),
        yaxis=look.axis(
            "weight k",
            range=[-0.46, 1.05],
            tickvals=[*LANES.values(), 0, 0.5, 1],
            ticktext=["X", "Y", "0", "0.5", "1"],
        ),
    )
