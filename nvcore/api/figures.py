"""Figures of a comparison for Python users, each built from the tables that it needs."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import TYPE_CHECKING, Any

from nvcore import figures
from nvcore.common.errors import InputError
from nvcore.common.palette import Shade
from nvcore.common.subject import subjects
from nvcore.common.wording import MOST_NAMED, did_you_mean, listed
from nvcore.comparison.compare import Result
from nvcore.comparison.scoring import SystemResult
from nvcore.evidence.stability.axes import Plane
from nvcore.evidence.stability.map import map_stability
from nvcore.evidence.stability.scores import Criterion
from nvcore.evidence.subgroups.table import subgroup_table
from nvcore.metrics.cost_map import map_cost
from nvcore.metrics.detection.curve_summary import summarise_curve
from nvcore.metrics.detection.curves import detection_curve
from nvcore.metrics.detection.operating_point import false_alarm_curve, score_histogram
from nvcore.tables.classes import classes_table
from nvcore.tables.encounters.miss_classes import fusion_table
from nvcore.tables.encounters.severity import weighed_encounters
from nvcore.tables.encounters.weightings import compare_weightings
from nvcore.tables.loss_strip import loss_strip
from nvcore.tables.result import encounters_table, recordings_table

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
        self._worded: dict[str, Any] = {"theme": self._theme, "objects": result.objects}

    def __repr__(self) -> str:
        return f"<figures: {', '.join(name for name in dir(self) if not name.startswith('_'))}>"

    def __dir__(self) -> list[str]:
        own = [name for name in vars(Figures) if not name.startswith("_")]
        return [*own, *(name for subject in subjects() for name in subject.figures().named)]

    def __getattr__(self, name: str) -> Callable[..., go.Figure]:
        for subject in subjects():
            if draw := subject.figures().named.get(name):
                return partial(draw, self._result, theme=self._theme)
        raise AttributeError(f"there is no figure {name!r}; there are {', '.join(dir(self))}")

    def dark(self) -> Figures:
        """Return the same figures for a dark page."""
        return Figures(self._result, "dark")

    def timeline(
        self, recording: Recording = 0, *, layout: figures.TimeLayout = "time"
    ) -> go.Figure:
        """Plot the similarity of X and Y over time, with low intervals and saliency events.

        Parameters
        ----------
        layout
            ``"time"``: time to the right. ``"upright"``: time upwards, X to the left and Y to the
            right, mirrored as in the paper's figure 8. ``"side_by_side"``: the same, with
            similarity growing to the right for both.
        """
        return figures.similarity_plot(
            self._result, self._row(recording), theme=self._theme, layout=layout
        )

    def losses(self, recording: Recording = 0) -> go.Figure:
        """Plot each frame's loss to misses and to false alarms (0 is best)."""
        return figures.loss_plot(self._result, self._row(recording), theme=self._theme)

    def loss_strip(self) -> go.Figure:
        """Plot the worse system's loss over the time of every recording, to find where to look."""
        return figures.loss_strip_plot(self._result, loss_strip(self._result), theme=self._theme)

    def lanes(self, recording: Recording = 0) -> go.Figure:
        """Plot the frames in which X and Y match or miss each pedestrian of a recording."""
        return figures.lanes_figure(self._result, self._row(recording), theme=self._theme)

    def venn(self) -> go.Figure:
        """Plot the numbers of encounters that X, Y, both or neither detects."""
        return figures.venn_figure(self._result.venn, self._result.names, **self._worded)

    def miss_classes(self) -> go.Figure:
        """Plot the number of encounters that each system fails, by kind of failure."""
        encounters = encounters_table(self._result)
        return figures.miss_classes_plot(encounters, self._result.names, **self._worded)

    def lead_time(self) -> go.Figure:
        """Plot the lead time of X over Y in first matching a pedestrian, in seconds."""
        return figures.lead_time_plot(encounters_table(self._result), **self._worded)

    def positions(self) -> go.Figure:
        """Plot the places in the picture where each system misses encounters."""
        return figures.position_map(encounters_table(self._result), **self._worded)

    def fusion(self) -> go.Figure:
        """Plot gain and cost of the fusions ``X or Y`` and ``X and Y``."""
        return figures.fusion_plot(fusion_table(self._result), theme=self._theme)

    def recordings(self) -> go.Figure:
        """Plot the mean similarity of X and Y in every recording."""
        recordings = recordings_table(self._result)
        return figures.recordings_plot(recordings, self._result.names, theme=self._theme)

    def saliency(self) -> go.Figure:
        """Plot the saliency of X and Y in every recording, in seconds (0 is best)."""
        recordings, names = recordings_table(self._result), self._result.names
        return figures.recordings_plot(recordings, names, theme=self._theme, measure="saliency")

    def weightings(self, encounter: int | None = None) -> go.Figure:
        """Plot the weight of one pedestrian over time, by height, by horizon and by distance.

        Parameters
        ----------
        encounter
            Row of ``encounters``, counted from 0. None: the encounter with the costliest failures.

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
        return figures.weightings_plot(self._result, encounter, weightings, theme=self._theme)

    def recency(self, recording: Recording | None = None) -> go.Figure:
        """Plot the recency curve with every event of one recording, or of all."""
        row = None if recording is None else self._row(recording)
        return figures.recency_plot(self._result, theme=self._theme, recording=row)

    def saliency_parts(self, recording: Recording | None = None) -> go.Figure:
        """Plot the parts of the most salient events of one recording, or of all."""
        row = None if recording is None else self._row(recording)
        return figures.parts_plot(self._result, theme=self._theme, recording=row)

    def curve(self, kind: figures.CurveKind = "miss_rate") -> go.Figure:
        """Plot a detection curve of X and Y under the session's protocol.

        Parameters
        ----------
        kind
            ``"miss_rate"``, ``"precision_recall"``, ``"roc"`` or ``"f1"``.
        """
        result, settings = self._result, self._result.dataset.settings
        curves = [
            detection_curve(result.dataset, name, result.params, settings.protocol)
            for name in result.names
        ]
        thresholds = [system.threshold for _, system in result.sides]
        return figures.curve_plot(
            curves,
            thresholds,
            kind,
            summaries=[*map(summarise_curve, curves, thresholds)],
            hint="",
            published=settings.published,
            **self._worded,
        )

    def subgroups(self, measure: str = "encounters_detected") -> go.Figure:
        """Plot the difference X - Y of one measure with its 95 % interval, by group.

        Parameters
        ----------
        measure
            Key of the measure in the table of evidence (column ``figure``).
        """
        protocol = self._result.dataset.settings.protocol
        table = subgroup_table(self._result, [measure], protocol=protocol)
        return figures.subgroup_forest(table, theme=self._theme)

    def stability(
        self, plane: Plane = "alpha-midpoint", criterion: Criterion = "similarity"
    ) -> go.Figure:
        """Map the better system over other settings (`evidence.stability.map.map_stability`)."""
        survey = map_stability(self._result, plane, criterion)
        return figures.stability_map(survey, theme=self._theme)

    def scores(self, letter: str = "x") -> go.Figure:
        """Plot the scores of system ``"x"`` or ``"y"`` and its threshold."""
        system = self._system(letter)
        histogram = score_histogram(self._result.dataset, system.name)
        return figures.score_plot(histogram, **self._setting(letter, system))

    def false_alarms(self, letter: str = "x") -> go.Figure:
        """Plot false alarms per minute by the threshold of system ``"x"`` or ``"y"``."""
        system = self._system(letter)
        curve = false_alarm_curve(self._result.dataset, system.name, self._result.params)
        return figures.false_alarm_plot(curve, **self._setting(letter, system))

    def classes(self, letter: str = "x") -> go.Figure:
        """Plot the classes read by system ``"x"`` or ``"y"``, by the class in the truth."""
        name, table = self._system(letter).name, classes_table(self._result)
        return figures.classes_plot(table, letter, name, theme=self._theme)

    def proximity(self) -> go.Figure:
        """Plot the proximity weight of a pedestrian."""
        result = self._result
        return figures.proximity_plot(result.dataset, result.params, theme=self._theme)

    def cost_map(self, recording: Recording = 0) -> go.Figure:
        """Map the cost of missing a pedestrian, by the position of the feet in the picture."""
        result, row = self._result, self._row(recording)
        cost = map_cost(result.weighed_truth, result.dataset.frame_columns, result.params, row)
        return figures.cost_plot(cost, **self._worded)

    def _setting(self, letter: str, system: SystemResult) -> dict[str, Any]:
        """Return the arguments of a score figure: letter, name, threshold and theme."""
        of = {"letter": letter, "name": system.name, "threshold": system.threshold}
        return {**of, "theme": self._theme}

    def _system(self, letter: str) -> SystemResult:
        sides = dict(self._result.sides)
        if letter not in sides:
            raise InputError(f"expected the system 'x' or 'y', got {letter!r}")
        return sides[letter]

    def _row(self, recording: Recording) -> int:
        names = self._result.dataset.recordings["name"].tolist()
        if recording in names:
            return int(names.index(recording))
        if isinstance(recording, int) and 0 <= recording < len(names):
            return recording
        hint = did_you_mean(str(recording), names, f"there are {listed(names, most=MOST_NAMED)}")
        raise InputError(f"there is no recording {recording!r}; {hint}")
