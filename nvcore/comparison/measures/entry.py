"""Entries of `nvcore.comparison.measures.table.MEASURES`."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from enum import StrEnum
from typing import Any, Final, Literal, NamedTuple

import numpy as np

from nvcore.comparison.compare import Result
from nvcore.comparison.scoring import SystemResult
from nvcore.metrics.detection.curve_summary import CurveSummary
from nvcore.metrics.venn import Venn
from nvcore.settings.params import SETTINGS
from nvcore.settings.stages import Stage

Better = Literal["higher", "lower", ""]
HIGHER: Final = "higher"
LOWER: Final = "lower"

HOUR_S: Final = 3600.0
"""Seconds per hour, for hourly rates."""
PER_HOUR: Final = "1/h"
"""Unit of hourly rates."""
NO_FRAMES: Final = "no evaluated frames"
NO_RATE: Final = "less than ten minutes of evaluated frames"
NO_EPISODES: Final = "no episodes"


class MeasureTable(StrEnum):
    """Tables of measures that show X beside Y."""

    SCORECARD = "scorecard"
    MISS_CLASSES = "miss classes"
    FALSE_ALERTS = "false alerts"
    DETECTION = "detection"


class Parts(NamedTuple):
    """Summands of a measure, each in the frame where it begins.

    Attributes
    ----------
    frame
        Row of the frames table; int64, shape (n,).
    value
        Summands, shape (n,); None: 1 each.
    """

    frame: np.ndarray
    value: np.ndarray | None


@dataclass(frozen=True)
class Condition:
    """Condition on a comparison for its files to have a measure, a column or a key.

    Attributes
    ----------
    holds
        Returns True if a comparison meets the condition.
    otherwise
        Description of the other comparisons, to follow "left out": ``without detectability``.
    """

    holds: Callable[[Result], bool]
    otherwise: str


def is_met(condition: Condition | None, result: Result) -> bool:
    """Whether a comparison meets a condition, which is always true for None."""
    return condition is None or condition.holds(result)


@dataclass(frozen=True)
class AxisScale:
    """Axes for differences of a measure, with shares (``%``) in percentage points.

    Attributes
    ----------
    form
        Format specification for the values of X and Y beside a forest plot.
    least, least_reach
        Least span of a forest plot's axis, and half the least span of the report's axis.
    unit
        Unit in words, to follow "difference"; empty for shares and measures without a unit.
    """

    form: str
    least: float
    least_reach: float
    unit: str = ""

    @property
    def is_share(self) -> bool:
        """Whether the difference is drawn in percentage points."""
        return self.form.endswith("%")


@dataclass(frozen=True)
class Inference:
    """Statistical test of a measure's difference, and its presentation.

    Attributes
    ----------
    test
        ``encounters``: McNemar's test; ``units``: bootstrap and permutation of sums over units;
        ``curve``: the same for a detection curve (`nvcore.evidence.miss_rate`).
    scale
        Scale of its axes.
    label, form
        Label and format if they differ from the measure's. A label may contain ``{units}``.
    split
        For ``encounters``: function that counts the relevant encounters that are good for both,
        one, or neither.
    parts, per, factor
        For ``units``: the measure is `factor` times the sum of its parts over the sum of `per`, a
        column of `nvcore.evidence.units.sum_units`. Parts are None if they cannot be split into
        blocks of time. ``share_of_recording`` makes it a mean over recordings, which uses
        `by_recording` if recordings are the units.
    not_in_blocks, not_of_pedestrians
        Reasons why blocks of time, or groups of pedestrians, may lack the measure; empty if they
        have it.
    noun, noun_unit
        Name and unit in the verdict's list of measures; empty if not listed.
    needs_tracks
        True if the measure means little when encounters are single frames.
    repeats
        Key of the measure whose hypothesis this one tests again; empty for a hypothesis of its own.
    split_in_group
        For ``encounters``: meaning of `split` within a group for the columns of ``subgroups.csv``,
        unless it counts detected near encounters.
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
    """A measure: a number that describes a system.

    Attributes
    ----------
    key
        Name in files and rules. A dot marks a nested entry of ``summary.json``.
    label
        Name for people, with unit and denominator. Like all texts here it is a template with words
        for the objects; it may also use the words of `label_words` (``{low}``, ``{n_near}``).
    form
        Format specification of the values; ``d``: whole numbers.
    better
        ``higher``, ``lower``, or empty for neither.
    stages
        Stages of the comparison that the measure is computed from.
    is_worsened_by_alarms
        True if false alarms can worsen the measure (or raise it, if neither direction is better),
        so that a rule on it can reject a system that fires everywhere.
    of
        Function that returns the value for a system, NaN if undefined.
    of_curve
        Function that returns the value for a detection curve, instead of `of`.
    unit, meaning, empty
        Unit or range, a sentence, and the case in which it is undefined, for ``summary.json`` and
        ``recordings.csv``. A measure without `meaning` is not in ``summary.json``.
    by_recording
        Function that returns the values by recording, shape (n_recordings,); None: not in
        ``recordings.csv``.
    meaning_by_recording, empty_by_recording
        Texts for ``recordings.csv`` if they differ.
    tables
        Tables in which the measure has a row.
    part
        Label in a table where it is a part of the row above.
    applies
        Returns True if the measure applies to a comparison. Otherwise no table shows it, and a gate
        rule treats it as undefined. None: always.
    only_if
        Condition for including the measure in files; None: always included, undefined where it does
        not apply.
    rule
        Name in gate rules, for detection curves. Other measures use their key.
    leads
        True if the short scorecard includes it.
    inference
        Test of the difference, which requires `better`; None: not in the table of evidence.
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
        """Whether a setting of `Params` can change the measure."""
        return SETTINGS[setting].moves(self.stages)
