"""What an entry of `nvcore.measures.table.MEASURES` says of a measure."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from enum import StrEnum
from typing import Any, Final, Literal, NamedTuple

import numpy as np

from nvcore.comparison import Result
from nvcore.detection.curve_summary import CurveSummary
from nvcore.metrics.venn import Venn
from nvcore.params import SETTINGS
from nvcore.scoring import SystemResult
from nvcore.stages import Stage

Better = Literal["higher", "lower", ""]
HIGHER: Final = "higher"
LOWER: Final = "lower"

HOUR_S: Final = 3600.0
"""Seconds of the rates per hour."""
PER_HOUR: Final = "1/h"
"""Their unit."""
NO_FRAMES: Final = "no evaluated frames"
NO_RATE: Final = "less than ten minutes of evaluated frames"
NO_EPISODES: Final = "no episodes"


class MeasureTable(StrEnum):
    """Tables of measures, X beside Y."""

    SCORECARD = "scorecard"
    MISS_CLASSES = "miss classes"
    FALSE_ALERTS = "false alerts"
    DETECTION = "detection"


class Parts(NamedTuple):
    """The summands of a measure, each in the frame where it begins.

    Attributes
    ----------
    frame
        Row of the frames table; int64, shape (n,).
    value
        The summand, shape (n,); None: 1 each.
    """

    frame: np.ndarray
    value: np.ndarray | None


@dataclass(frozen=True)
class Condition:
    """On which comparisons files have a measure, a column or a key.

    Attributes
    ----------
    holds
        Whether a comparison is one of them.
    otherwise
        When files lack it, to follow "left out": ``without detectability``.
    """

    holds: Callable[[Result], bool]
    otherwise: str


def is_met(condition: Condition | None, result: Result) -> bool:
    """Whether files of a comparison have what depends on this; without a condition they do."""
    return condition is None or condition.holds(result)


@dataclass(frozen=True)
class AxisScale:
    """Axes on which differences of a measure are drawn; shares (``%``) in percentage points.

    Attributes
    ----------
    form
        Format specification of X and Y beside a forest plot.
    least, least_reach
        Least span of a forest plot's axis; half the least span of the report's own axis.
    unit
        Unit in words, to follow "difference"; empty: none, or a share.
    """

    form: str
    least: float
    least_reach: float
    unit: str = ""

    @property
    def is_share(self) -> bool:
        """Whether it is drawn in percentage points."""
        return self.form.endswith("%")


@dataclass(frozen=True)
class Inference:
    """How the difference of a measure is judged and shown with its evidence.

    Attributes
    ----------
    test
        ``encounters``: McNemar's test; ``units``: bootstrap and permutation of sums over units;
        ``curve``: the same of a detection curve (`nvcore.evidence.miss_rate`).
    scale
        Scale of its axes.
    label, form
        Where they differ from the measure's; a label may contain ``{units}``.
    split
        For ``encounters``: how many of those that count are good for both, one, or neither.
    parts, per, factor
        For ``units``: the measure is `factor` times the sum of its parts over the sum of `per`, a
        column of `nvcore.evidence.units.sum_units`. Parts are None where they cannot be shared out
        to blocks of time. ``share_of_recording`` makes it a mean over recordings: if these are the
        units, `by_recording` is used.
    not_in_blocks, not_of_pedestrians
        Why blocks of time, and groups of pedestrians, may lack it; empty: they have it.
    noun, noun_unit
        What the verdict calls it where it lists measures; empty: not listed.
    needs_tracks
        Whether it means little if encounters are single frames.
    repeats
        Key of the measure whose hypothesis this one tests again; empty: it has its own.
    split_in_group
        For ``encounters``: what `split` counts of a group, where that is not who detects the near
        ones; for the columns of ``subgroups.csv``.
    """

    test: Literal["encounters", "units", "curve"]
    scale: AxisScale
    label: str = ""
    form: str = ""
    parts: Callable[[Result, SystemResult], Parts | None] | None = None
    split: Callable[[Result], Venn] | None = None
    per: str = ""
    factor: float = 1.0
    not_in_blocks: str = ""
    not_of_pedestrians: str = ""
    noun: str = ""
    noun_unit: str = ""
    needs_tracks: bool = False
    repeats: str = ""
    split_in_group: str = ""


@dataclass(frozen=True)
class Measure:
    """One measure.

    Attributes
    ----------
    key
        Its name in files and rules; a dot marks a nested entry of ``summary.json``.
    label
        Its name for people, with unit and denominator: a template with words of the objects, as all
        texts here, and with those of `label_words` (``{low}``, ``{n_near}``).
    form
        Format specification of its values; ``d``: whole numbers.
    better
        ``higher``, ``lower``; empty: neither.
    stages
        Steps of the comparison that it is computed from.
    is_worsened_by_alarms
        Whether false alarms can worsen it (or raise it, where neither way is better), so that a
        rule about it can stop a system that fires everywhere.
    of
        Its value for a system; NaN undefined.
    of_curve
        Its value for a detection curve, instead of `of`.
    unit, meaning, empty
        Unit or range, a sentence, and when it is undefined, for ``summary.json`` and
        ``recordings.csv``; a measure without meaning is not in ``summary.json``.
    by_recording
        Its values by recording, shape (n_recordings,); None: not in ``recordings.csv``.
    meaning_by_recording, empty_by_recording
        The sentences there, where they differ.
    tables
        Tables in which it has a row.
    part
        Its label where it is a part of the row above.
    applies
        Whether a comparison has what it measures; without it no table shows the measure, and a rule
        of the gate finds it undefined. None: always.
    only_if
        On which comparisons files have it; None: on all, undefined where it does not apply.
    rule
        Its name in rules of the gate, for detection curves; others go by their key.
    leads
        Whether the scorecard in short has it.
    inference
        How its difference is judged, which needs a better way; None: it is not in the table of
        evidence.
    """

    key: str
    label: str
    form: str
    better: Better
    stages: tuple[Stage, ...]
    is_worsened_by_alarms: bool
    of: Callable[[Result, SystemResult], float] | None = None
    of_curve: Callable[[CurveSummary], float] | None = None
    unit: str = ""
    meaning: str = ""
    empty: str = ""
    by_recording: Callable[[Result, SystemResult], Any] | None = None
    meaning_by_recording: str = ""
    empty_by_recording: str = ""
    tables: tuple[MeasureTable, ...] = ()
    part: str = ""
    applies: Callable[[Result], bool] | None = None
    only_if: Condition | None = None
    rule: str = ""
    leads: bool = False
    inference: Inference | None = None

    def __post_init__(self) -> None:
        assert self.better or not self.inference, f"{self.key}: no difference of it is better"

    def depends_on(self, setting: str) -> bool:
        """Whether a setting of `Params` can change it."""
        return SETTINGS[setting].moves(self.stages)
