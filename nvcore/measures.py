"""Every measure of a comparison, defined once in `MEASURES`.

A measure is a number that describes a system (a figure is a chart). From its entry come the row of
the scorecard, the key of ``summary.json``, the columns of ``recordings.csv``, the name in rules of
the gate, the rows of the table of evidence and of its groups, the axes of forest plots and of the
report's intervals, and the tables of ``docs/report.md``. `nvcore.evidence` resamples and tests its
difference; the entry only says which sums over frames make the measure.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from enum import StrEnum
from operator import attrgetter
from typing import Any, Final, Literal, NamedTuple

import numpy as np

from nvcore.comparison import Result, SystemResult
from nvcore.detection.curve_summary import CurveSummary
from nvcore.schema import Category, MissClass

Better = Literal["higher", "lower", ""]
HIGHER: Final = "higher"
LOWER: Final = "lower"

NO_FRAMES: Final = "no evaluated frames"
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
    """

    test: Literal["encounters", "units", "curve"]
    scale: AxisScale
    label: str = ""
    form: str = ""
    parts: Callable[[Result, SystemResult], Parts | None] | None = None
    per: Literal["n_encounters", "n_frames", "duration_s", "share_of_recording", ""] = ""
    factor: float = 1.0
    not_in_blocks: str = ""
    not_of_pedestrians: str = ""
    noun: str = ""
    noun_unit: str = ""
    needs_tracks: bool = False


@dataclass(frozen=True)
class Measure:
    """One measure.

    Attributes
    ----------
    key
        Its name in files and rules; a dot marks a nested entry of ``summary.json``.
    label
        Its name for people, with unit and denominator. May contain ``{low}``, ``{aggregate}``,
        ``{n_near}`` and ``{n_boxes}`` (`label_words`).
    form
        Format specification of its values; ``d``: whole numbers.
    better
        ``higher``, ``lower``; empty: neither.
    of
        Its value for a system; NaN undefined.
    of_curve
        Its value for a detection curve, instead of `of`.
    unit, meaning, empty
        Unit or range, a sentence, and when it is undefined, for ``summary.json`` and
        ``recordings.csv``; a measure without meaning is not in ``summary.json``.
    by_recording
        Its values by recording, shape (n_recordings,); None: not in ``recordings.csv``.
    meaning_by_recording
        The sentence there, where it differs.
    tables
        Tables in which it has a row.
    part
        Its label where it is a part of the row above.
    of_several
        Whether it is shown only if two recordings or more have frames.
    rule
        Its name in rules of the gate, for detection curves; others go by their key.
    inference
        How its difference is judged; None: it is not in the table of evidence.
    """

    key: str
    label: str
    form: str
    better: Better
    of: Callable[[Result, SystemResult], float] | None = None
    of_curve: Callable[[CurveSummary], float] | None = None
    unit: str = ""
    meaning: str = ""
    empty: str = ""
    by_recording: Callable[[Result, SystemResult], Any] | None = None
    meaning_by_recording: str = ""
    tables: tuple[MeasureTable, ...] = ()
    part: str = ""
    of_several: bool = False
    rule: str = ""
    inference: Inference | None = None


def per_recording(result: Result, values: np.ndarray, recording: np.ndarray) -> np.ndarray:
    """Sum of `values` over each recording; float64, shape (n_recordings,)."""
    return np.bincount(recording, weights=values, minlength=len(result.dataset.recordings))


def duration_of_recordings(result: Result) -> np.ndarray:
    """Sum of the time steps of each recording, s; float64, shape (n_recordings,)."""
    frames = result.dataset.frame_columns
    duration_s: np.ndarray = per_recording(result, frames.gap, frames.recording) / frames.fps
    return duration_s


def label_words(result: Result, units: str = "") -> dict[str, Any]:
    """Settings and counts of a result that labels contain.

    Parameters
    ----------
    units
        What is resampled: ``recordings`` or ``blocks``.
    """
    is_largest = result.params.saliency_aggregate == "max"
    return {
        "low": result.params.low,
        "aggregate": "largest event" if is_largest else "sum of events",
        "n_near": result.venn.n_near,
        "n_boxes": int(result.n_truth.sum()),
        "units": units,
    }


def has_several_recordings(result: Result) -> bool:
    """Whether two recordings or more have frames."""
    return int(np.count_nonzero(np.diff(result.dataset.frame_columns.first))) > 1


def _mean_saliency(result: Result, system: SystemResult) -> float:
    has_frames = np.diff(result.dataset.frame_columns.first) > 0
    return float(result.saliency_of_recordings(system)[has_frames].mean())


def _saliency_parts(result: Result, system: SystemResult) -> Parts | None:
    if result.params.saliency_aggregate == "max":
        return None
    events = system.events
    return Parts(
        events["first_row"].to_numpy(dtype=np.int64), events["saliency_s"].to_numpy(dtype=float)
    )


def _similarity_parts(_: Result, system: SystemResult) -> Parts:
    return Parts(np.arange(len(system.similarity)), system.similarity)


def _low_parts(result: Result, system: SystemResult) -> Parts:
    return Parts(np.arange(len(system.similarity)), system.similarity < result.params.low)


def _detected_parts(result: Result, system: SystemResult) -> Parts:
    is_near = result.category != Category.DISTANT.value
    is_detected = system.encounters["is_detected"].to_numpy(dtype=bool) & is_near
    return Parts(result.encounters.first_row[is_detected], None)


def _episode_parts(_: Result, system: SystemResult) -> Parts:
    return Parts(system.episodes["first_row"].to_numpy(dtype=np.int64), None)


def _detected_by_recording(result: Result, system: SystemResult) -> np.ndarray:
    is_detected = system.encounters["is_detected"].to_numpy()
    return per_recording(result, is_detected, result.encounters.recording).astype(np.int64)


def _alarms_by_recording(result: Result, system: SystemResult) -> np.ndarray:
    recording = result.dataset.frame_columns.recording
    return per_recording(result, system.false_alarms, recording).astype(np.int64)


def _episodes_by_recording(result: Result, system: SystemResult) -> np.ndarray:
    recording = system.episodes["recording"].to_numpy()
    return per_recording(result, np.ones(len(recording)), recording).astype(np.int64)


def _rate_by_recording(
    counts: Callable[[Result, SystemResult], np.ndarray], *, per_s: float
) -> Callable[[Result, SystemResult], np.ndarray]:
    """Counts of each recording per `per_s` seconds of it."""

    def rate(result: Result, system: SystemResult) -> np.ndarray:
        with np.errstate(invalid="ignore"):  # a recording without frames has no rates
            rates: np.ndarray = counts(result, system) / duration_of_recordings(result) * per_s
        return rates

    return rate


def _similarity_by_recording(name: str) -> Callable[[Result, SystemResult], list[float]]:
    def values(_: Result, system: SystemResult) -> list[float]:
        return [getattr(summary, name) for summary in system.summary_of_recordings]

    return values


def _miss_class(kind: MissClass) -> Measure:
    def count(result: Result, system: SystemResult) -> int:
        is_near = result.category != Category.DISTANT.value
        is_kind = (system.encounters["miss_class"] == kind.value).to_numpy()
        return int(np.count_nonzero(is_kind & is_near))

    words = "no failure" if kind is MissClass.NONE else kind.value.replace("_", " ")
    return Measure(
        key=f"miss_classes.{kind.value}",
        label=words,
        part=words,
        form="d",
        better=HIGHER if kind is MissClass.NONE else LOWER,
        of=count,
        unit="encounters",
        meaning=f"Encounters with the miss class `{kind.value}`, distant ones left out.",
        tables=(MeasureTable.MISS_CLASSES,),
    )


def _of_curve(
    key: str, label: str, better: Better, form: str, rule: str = "", **more: Any
) -> Measure:
    """A measure of the detection curve; its key is the attribute of `CurveSummary`."""
    tables = (MeasureTable.DETECTION,)
    return Measure(
        key, label, form, better, of_curve=attrgetter(key), rule=rule, tables=tables, **more
    )


_NO_FRAMES_OF_GROUPS: Final = "a frame belongs to no group of pedestrians"

MEASURES: Final[tuple[Measure, ...]] = (
    Measure(
        key="detections",
        label="detections that count",
        form="d",
        better="",
        of=lambda _, system: int(system.n_det.sum()),
        unit="boxes",
        meaning="Sum of `n_det` of `frames.csv`.",
        tables=(MeasureTable.FALSE_ALERTS,),
    ),
    Measure(
        key="detections_without_distance",
        label="detections without distance",
        form="d",
        better="",
        of=lambda _, system: system.weights.n_without_distance,
        unit="boxes",
        meaning="Of these, weighted by height because `proximity` is `distance` and they have "
        "none.",
    ),
    Measure(
        key="mean_similarity",
        label="mean similarity",
        form=".4f",
        better=HIGHER,
        of=lambda _, system: system.summary.mean,
        unit="0 to 1",
        meaning="Mean similarity of the frames.",
        empty=NO_FRAMES,
        by_recording=_similarity_by_recording("mean"),
        tables=(MeasureTable.SCORECARD,),
        inference=Inference(
            test="units",
            scale=AxisScale(".3f", least=0.01, least_reach=0.001),
            parts=_similarity_parts,
            per="n_frames",
            not_of_pedestrians=_NO_FRAMES_OF_GROUPS,
            noun="mean similarity",
        ),
    ),
    Measure(
        key="min_similarity",
        label="minimum similarity",
        form=".4f",
        better=HIGHER,
        of=lambda _, system: system.summary.minimum,
        unit="0 to 1",
        meaning="Lowest similarity of a frame.",
        empty=NO_FRAMES,
        by_recording=_similarity_by_recording("minimum"),
        tables=(MeasureTable.SCORECARD,),
    ),
    Measure(
        key="percentile_5_similarity",
        label="5th percentile similarity",
        form=".4f",
        better=HIGHER,
        of=lambda _, system: system.summary.percentile_5,
        unit="0 to 1",
        meaning="Similarity that 5 % of the frames are below.",
        empty=NO_FRAMES,
        by_recording=_similarity_by_recording("percentile_5"),
        tables=(MeasureTable.SCORECARD,),
    ),
    Measure(
        key="share_low",
        label="frames with similarity below {low:g}",
        form=".1%",
        better=LOWER,
        of=lambda _, system: system.summary.share_low,
        unit="0 to 1",
        meaning="Share of frames with a similarity below `low`.",
        empty=NO_FRAMES,
        by_recording=_similarity_by_recording("share_low"),
        tables=(MeasureTable.SCORECARD,),
        inference=Inference(
            test="units",
            scale=AxisScale(".1%", least=1.0, least_reach=1.0),
            label="share of frames with similarity below {low:g}",
            parts=_low_parts,
            per="n_frames",
            not_of_pedestrians=_NO_FRAMES_OF_GROUPS,
        ),
    ),
    Measure(
        key="saliency",
        label="saliency, {aggregate} (s)",
        form=".3f",
        better=LOWER,
        of=lambda _, system: system.saliency_s,
        unit="s",
        meaning="The largest saliency event, or the sum of all (`saliency_aggregate`); 0 without "
        "any.",
        by_recording=lambda result, system: result.saliency_of_recordings(system),
        meaning_by_recording="Its largest saliency event, or their sum (`saliency_aggregate`); 0 "
        "without any.",
        tables=(MeasureTable.SCORECARD,),
        inference=Inference(
            test="units",
            scale=AxisScale(".2f", least=0.1, least_reach=0.1, unit="seconds"),
            label="saliency of a recording, {aggregate} (s)",
            form=".2f",
            parts=_saliency_parts,
            per="share_of_recording",
            not_in_blocks="the largest event of a recording cannot be shared out to blocks of time",
            noun="saliency per recording",
            noun_unit=" s",
            needs_tracks=True,
        ),
    ),
    Measure(
        key="mean_saliency",
        label="mean saliency over recordings (s)",
        part="mean over recordings (s)",
        form=".3f",
        better=LOWER,
        of=_mean_saliency,
        tables=(MeasureTable.SCORECARD,),
        of_several=True,
    ),
    Measure(
        key="encounters_detected",
        label="encounters detected, of {n_near}",
        form="d",
        better=HIGHER,
        of=lambda _, system: int(system.encounters["is_detected"].sum()),
        unit="encounters",
        meaning="Encounters that the system detected.",
        by_recording=_detected_by_recording,
        tables=(MeasureTable.SCORECARD,),
        inference=Inference(
            test="encounters",
            scale=AxisScale(".0%", least=1.0, least_reach=1.0),
            label="share of encounters detected",
            form=".1%",
            per="n_encounters",
        ),
    ),
    Measure(
        key="encounters_detected_by_unit",
        label="share of encounters detected, by {units}",
        form=".1%",
        better=HIGHER,
        inference=Inference(
            test="units",
            scale=AxisScale(".0%", least=1.0, least_reach=1.0),
            parts=_detected_parts,
            per="n_encounters",
        ),
    ),
    *(_miss_class(kind) for kind in MissClass),
    Measure(
        key="boxes_matched",
        label="boxes matched, near or far, of {n_boxes}",
        form="d",
        better=HIGHER,
        of=lambda _, system: int(system.matched.sum()),
        unit="boxes",
        meaning="Annotated pedestrian boxes matched, those of distant encounters too.",
        tables=(MeasureTable.SCORECARD,),
    ),
    Measure(
        key="false_alarms",
        label="false alarms",
        form="d",
        better=LOWER,
        of=lambda _, system: system.false_alarm_summary.count,
        unit="boxes",
        meaning="Detections that match nobody.",
        by_recording=_alarms_by_recording,
        tables=(MeasureTable.FALSE_ALERTS,),
    ),
    Measure(
        key="false_alarms_per_frame",
        label="false alarms per frame",
        form=".3f",
        better=LOWER,
        of=lambda _, system: system.false_alarm_summary.per_frame,
        unit="1/frame",
        meaning="The same per evaluated frame.",
        empty=NO_FRAMES,
        tables=(MeasureTable.SCORECARD, MeasureTable.FALSE_ALERTS),
    ),
    Measure(
        key="false_alarms_per_minute",
        label="false alarms per minute",
        form=".1f",
        better=LOWER,
        of=lambda _, system: system.false_alarm_summary.per_minute,
        unit="1/min",
        meaning="The same per minute.",
        empty=NO_FRAMES,
        by_recording=_rate_by_recording(_alarms_by_recording, per_s=60),
        tables=(MeasureTable.FALSE_ALERTS,),
    ),
    Measure(
        key="false_alert_episodes",
        label="false-alert episodes",
        form="d",
        better=LOWER,
        of=lambda _, system: system.false_alarm_summary.episodes,
        unit="episodes",
        meaning="False alarms linked over frames: what the driver notices as one.",
        by_recording=_episodes_by_recording,
        tables=(MeasureTable.SCORECARD, MeasureTable.FALSE_ALERTS),
    ),
    Measure(
        key="false_alert_episodes_per_hour",
        label="false-alert episodes per hour",
        part="per hour",
        form=".1f",
        better=LOWER,
        of=lambda _, system: system.false_alarm_summary.episodes_per_hour,
        unit="1/h",
        meaning="The same per hour.",
        empty=NO_FRAMES,
        by_recording=_rate_by_recording(_episodes_by_recording, per_s=3600),
        tables=(MeasureTable.SCORECARD, MeasureTable.FALSE_ALERTS),
        inference=Inference(
            test="units",
            scale=AxisScale(",.0f", least=1.0, least_reach=1.0, unit="episodes per hour"),
            parts=_episode_parts,
            per="duration_s",
            factor=3600.0,
            not_of_pedestrians="a false alert belongs to no pedestrian",
            noun="false-alert episodes",
            noun_unit=" per hour",
            needs_tracks=True,
        ),
    ),
    Measure(
        key="mean_episode_s",
        label="mean duration of an episode (s)",
        form=".2f",
        better=LOWER,
        of=lambda _, system: system.false_alarm_summary.mean_episode_s,
        unit="s",
        meaning="Mean duration of an episode.",
        empty=NO_EPISODES,
        tables=(MeasureTable.FALSE_ALERTS,),
    ),
    Measure(
        key="longest_episode_s",
        label="longest episode (s)",
        part="longest (s)",
        form=".2f",
        better=LOWER,
        of=lambda _, system: system.false_alarm_summary.longest_episode_s,
        unit="s",
        meaning="The longest one.",
        empty=NO_EPISODES,
        tables=(MeasureTable.SCORECARD, MeasureTable.FALSE_ALERTS),
    ),
    _of_curve(
        "log_average_miss_rate",
        "log-average miss rate",
        LOWER,
        ".2%",
        "lamr",
        inference=Inference(
            test="curve",
            scale=AxisScale(".1%", least=1.0, least_reach=1.0),
            form=".1%",
        ),
    ),
    _of_curve(
        "average_precision_coco", "average precision (COCO, 101 recalls)", HIGHER, ".4f", "ap"
    ),
    _of_curve("average_precision", "average precision (area, monotone)", HIGHER, ".4f", "ap_area"),
    _of_curve("pr_auc", "area under precision-recall (Davis, Goadrich)", HIGHER, ".4f", "pr_auc"),
    _of_curve("best_f1", "best F1 over all thresholds", HIGHER, ".4f"),
    _of_curve("recall", "recall at the threshold", HIGHER, ".4f", "recall"),
    _of_curve("precision", "precision at the threshold", HIGHER, ".4f", "precision"),
    _of_curve("f1", "F1 at the threshold", HIGHER, ".4f", "f1"),
    _of_curve("fppi", "false positives per image at the threshold", LOWER, ".4f", "fppi"),
    _of_curve("n_absorbed", "detections absorbed by ignored boxes at the threshold", "", "d"),
)
"""Every measure, in the order of ``summary.json`` and of all tables."""

_BY_KEY: Final = {measure.key: measure for measure in MEASURES}
_INFERENCE: Final = {
    measure.key: measure.inference for measure in MEASURES if measure.inference is not None
}

EVIDENCE_KEYS: Final = tuple(
    sorted(_INFERENCE, key=lambda key: _INFERENCE[key].per != "n_encounters")
)
"""Keys of the table of evidence: encounters first, then in the order of `MEASURES`."""


def measures_in(table: MeasureTable) -> tuple[Measure, ...]:
    """The measures of a table."""
    return tuple(measure for measure in MEASURES if table in measure.tables)


def measure_of(key: str) -> Measure:
    """The measure with this key."""
    return _BY_KEY[key]


def inference_of(key: str) -> Inference:
    """How the difference of a measure of `EVIDENCE_KEYS` is judged."""
    return _INFERENCE[key]


def evidence_form(key: str) -> str:
    """Format specification of a measure of `EVIDENCE_KEYS` beside its evidence."""
    return inference_of(key).form or _BY_KEY[key].form


def evidence_label(key: str, result: Result, units: str) -> str:
    """What a measure of `EVIDENCE_KEYS` is called beside its evidence.

    Parameters
    ----------
    units
        What is resampled: ``recordings`` or ``blocks``.
    """
    template = inference_of(key).label or _BY_KEY[key].label
    return template.format_map(label_words(result, units))
