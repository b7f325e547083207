"""The figures of a comparison, each from the tables that it needs."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import TYPE_CHECKING

from nvcore.comparison import Result
from nvcore.detection.curve_summary import summarise_curve
from nvcore.detection.curves import detection_curve
from nvcore.detection.operating_point import false_alarm_curve, score_histogram
from nvcore.errors import InputError
from nvcore.evidence.subgroup_table import subgroup_table
from nvcore.figures.classes import classes_plot
from nvcore.figures.cost_map import cost_plot
from nvcore.figures.curves import CurveKind, curve_plot, legend_text
from nvcore.figures.encounters import (
    fusion_plot,
    lead_time_plot,
    miss_classes_plot,
    position_map,
)
from nvcore.figures.forest import subgroup_forest
from nvcore.figures.inputs import false_alarm_plot, proximity_plot, score_plot
from nvcore.figures.lanes import lanes_figure, loss_strip_plot
from nvcore.figures.over_time import TimeLayout, loss_plot, similarity_plot
from nvcore.figures.paired import recordings_plot
from nvcore.figures.saliency import parts_plot, recency_plot
from nvcore.figures.stability import stability_map
from nvcore.figures.venn import venn_figure
from nvcore.figures.weightings import weightings_plot
from nvcore.metrics.cost_map import map_cost
from nvcore.palette import Shade
from nvcore.scoring import SystemResult
from nvcore.stability.axes import Plane
from nvcore.stability.map import map_stability
from nvcore.stability.scores import Criterion
from nvcore.subjects import contributed
from nvcore.tables.classes import classes_table
from nvcore.tables.encounters.miss_classes import fusion_table
from nvcore.tables.encounters.severity import weighed_encounters
from nvcore.tables.encounters.weightings import compare_weightings
from nvcore.tables.loss_strip import loss_strip
from nvcore.tables.result import encounters_table, recordings_table
from nvcore.wording import MOST_NAMED, did_you_mean, listed

if TYPE_CHECKING:
    import plotly.graph_objects as go

Recording = str | int
"""A recording's name, or its row in ``dataset.recordings``."""


class Figures:
    """Plotly figures of a comparison, as the dashboard and the HTML report draw them.

    Parameters
    ----------
    theme
        ``"light"`` or ``"dark"``.
    """

    def __init__(self, result: Result, theme: Shade = "light"):
        self._result = result
        self._theme = result.scheme(theme)
        self._names = result.names

    def __repr__(self) -> str:
        names = ", ".join(name for name in dir(self) if not name.startswith("_"))
        return f"<figures: {names}>"

    def __dir__(self) -> list[str]:
        own = [name for name in vars(Figures) if not name.startswith("_")]
        return [*own, *(name for known in contributed("figures") for name in known)]

    def __getattr__(self, name: str) -> Callable[..., go.Figure]:
        for known in contributed("figures"):
            if name in known:
                return partial(known[name], self._result, theme=self._theme)
        raise AttributeError(f"there is no figure {name!r}; there are {', '.join(dir(self))}")

    def dark(self) -> Figures:
        """The same figures for a dark page."""
        return Figures(self._result, "dark")

    def timeline(self, recording: Recording = 0, *, layout: TimeLayout = "time") -> go.Figure:
        """Similarity of X and Y over time, with low intervals and saliency events.

        Parameters
        ----------
        layout
            ``"time"``: time to the right. ``"upright"``: time upwards, X to the left and Y to the
            right, mirrored as in the paper's figure 8. ``"side_by_side"``: the same, with
            similarity growing to the right for both.
        """
        return similarity_plot(self._result, self._row(recording), theme=self._theme, layout=layout)

    def losses(self, recording: Recording = 0) -> go.Figure:
        """What each frame loses to misses and to false alarms, 0 is best."""
        return loss_plot(self._result, self._row(recording), theme=self._theme)

    def loss_strip(self) -> go.Figure:
        """Where to look first: over the time of every recording, what the worse system loses."""
        return loss_strip_plot(self._result, loss_strip(self._result), theme=self._theme)

    def lanes(self, recording: Recording = 0) -> go.Figure:
        """When each pedestrian of a recording was matched or missed by X and by Y."""
        return lanes_figure(self._result, self._row(recording), theme=self._theme)

    def venn(self) -> go.Figure:
        """Encounters by who detects them."""
        return venn_figure(
            self._result.venn, self._names, theme=self._theme, objects=self._result.objects
        )

    def miss_classes(self) -> go.Figure:
        """How many encounters each system fails in which way."""
        return miss_classes_plot(
            encounters_table(self._result),
            self._names,
            theme=self._theme,
            objects=self._result.objects,
        )

    def lead_time(self) -> go.Figure:
        """How much earlier X matches a pedestrian than Y, in seconds."""
        return lead_time_plot(
            encounters_table(self._result), theme=self._theme, objects=self._result.objects
        )

    def positions(self) -> go.Figure:
        """Where in the picture each system misses encounters."""
        return position_map(
            encounters_table(self._result), theme=self._theme, objects=self._result.objects
        )

    def fusion(self) -> go.Figure:
        """What ``X or Y`` and ``X and Y`` would gain and cost."""
        return fusion_plot(fusion_table(self._result), theme=self._theme)

    def recordings(self) -> go.Figure:
        """Mean similarity of X and Y in every recording."""
        return recordings_plot(recordings_table(self._result), self._names, theme=self._theme)

    def saliency(self) -> go.Figure:
        """Saliency of X and Y in every recording, in seconds, 0 is best."""
        return recordings_plot(
            recordings_table(self._result), self._names, theme=self._theme, measure="saliency"
        )

    def weightings(self, encounter: int | None = None) -> go.Figure:
        """The weight of one pedestrian over time, as height, horizon and distance tell it.

        Parameters
        ----------
        encounter
            Row of ``encounters``, counted from 0; None: the one whose failures weigh most.

        Raises
        ------
        InputError
            If there is no such row.
        """
        if encounter is None:
            encounter = int(next(iter(weighed_encounters(self._result).index), 0))
        n = len(self._result.encounters)
        if not 0 <= encounter < n:
            raise InputError(f"there is no encounter {encounter}; there are {n:,}")
        weightings = compare_weightings(self._result, encounter)
        return weightings_plot(self._result, encounter, weightings, theme=self._theme)

    def recency(self, recording: Recording | None = None) -> go.Figure:
        """The recency curve with every event on it; of one recording, or of all."""
        return recency_plot(self._result, theme=self._theme, recording=self._maybe_row(recording))

    def saliency_parts(self, recording: Recording | None = None) -> go.Figure:
        """The most salient events taken apart; of one recording, or of all."""
        return parts_plot(self._result, theme=self._theme, recording=self._maybe_row(recording))

    def curve(self, kind: CurveKind = "miss_rate") -> go.Figure:
        """A detection curve of X and Y under the session's protocol.

        Parameters
        ----------
        kind
            ``"miss_rate"``, ``"precision_recall"``, ``"roc"`` or ``"f1"``.
        """
        result, protocol = self._result, self._result.dataset.settings.protocol
        curves = [
            detection_curve(result.dataset, system.name, result.params, protocol)
            for _, system in result.sides
        ]
        thresholds = [system.threshold for _, system in result.sides]
        summaries = map(summarise_curve, curves, thresholds)
        return curve_plot(
            curves,
            thresholds,
            kind,
            theme=self._theme,
            summaries=[legend_text(summary, kind) for summary in summaries],
            hint="",
            published=result.dataset.settings.published,
            objects=self._result.objects,
        )

    def subgroups(self, measure: str = "encounters_detected") -> go.Figure:
        """Difference X - Y of one measure with its 95 % interval, by group.

        Parameters
        ----------
        measure
            Its key in the table of evidence (column ``figure``).
        """
        protocol = self._result.dataset.settings.protocol
        table = subgroup_table(self._result, [measure], protocol=protocol)
        return subgroup_forest(table, theme=self._theme)

    def stability(
        self, plane: Plane = "alpha-midpoint", criterion: Criterion = "similarity"
    ) -> go.Figure:
        """Who is better at other settings; see `nvcore.stability.map.map_stability`."""
        return stability_map(map_stability(self._result, plane, criterion), theme=self._theme)

    def scores(self, letter: str = "x") -> go.Figure:
        """Scores of system ``"x"`` or ``"y"``, and which of them its threshold leaves."""
        system = self._system(letter)
        return score_plot(
            score_histogram(self._result.dataset, system.name),
            letter=letter,
            name=system.name,
            threshold=system.threshold,
            theme=self._theme,
        )

    def false_alarms(self, letter: str = "x") -> go.Figure:
        """False alarms per minute that each threshold of system ``"x"`` or ``"y"`` leaves."""
        system = self._system(letter)
        return false_alarm_plot(
            false_alarm_curve(self._result.dataset, system.name, self._result.params),
            letter=letter,
            name=system.name,
            threshold=system.threshold,
            theme=self._theme,
        )

    def classes(self, letter: str = "x") -> go.Figure:
        """What the matches of system ``"x"`` or ``"y"`` were taken for, by the truth's classes."""
        system = self._system(letter)
        return classes_plot(classes_table(self._result), letter, system.name, theme=self._theme)

    def proximity(self) -> go.Figure:
        """How much a pedestrian counts by how near it seems."""
        return proximity_plot(self._result.dataset, self._result.params, theme=self._theme)

    def cost_map(self, recording: Recording = 0) -> go.Figure:
        """What missing a pedestrian would cost, by where in the picture the feet are."""
        result, row = self._result, self._row(recording)
        frames = result.dataset.frame_columns
        cost = map_cost(result.weighed_truth, frames, result.params, row)
        return cost_plot(cost, theme=self._theme, objects=self._result.objects)

    def _system(self, letter: str) -> SystemResult:
        sides = dict(self._result.sides)
        if letter not in sides:
            raise InputError(f"expected the system 'x' or 'y', got {letter!r}")
        return sides[letter]

    def _maybe_row(self, recording: Recording | None) -> int | None:
        return None if recording is None else self._row(recording)

    def _row(self, recording: Recording) -> int:
        names = self._result.dataset.recordings["name"].tolist()
        if recording in names:
            return int(names.index(recording))
        if isinstance(recording, int) and 0 <= recording < len(names):
            return recording
        hint = did_you_mean(str(recording), names, f"there are {listed(names, most=MOST_NAMED)}")
        raise InputError(f"there is no recording {recording!r}; {hint}")
