"""Every measure, defined once."""

from __future__ import annotations

from operator import attrgetter
from typing import Any, Final

import numpy as np

from nvcore.comparison import Result
from nvcore.measures.entry import (
    HIGHER,
    LOWER,
    NO_EPISODES,
    NO_FRAMES,
    AxisScale,
    Better,
    Inference,
    Measure,
    MeasureTable,
)
from nvcore.measures.values import (
    alarms_by_recording,
    detected_by_recording,
    detected_parts,
    episode_parts,
    episodes_by_recording,
    low_parts,
    mean_saliency,
    rate_by_recording,
    saliency_parts,
    similarity_by_recording,
    similarity_parts,
)
from nvcore.schema import Category, MissClass
from nvcore.scoring import SystemResult


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
        by_recording=similarity_by_recording("mean"),
        tables=(MeasureTable.SCORECARD,),
        inference=Inference(
            test="units",
            scale=AxisScale(".3f", least=0.01, least_reach=0.001),
            parts=similarity_parts,
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
        by_recording=similarity_by_recording("minimum"),
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
        by_recording=similarity_by_recording("percentile_5"),
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
        by_recording=similarity_by_recording("share_low"),
        tables=(MeasureTable.SCORECARD,),
        inference=Inference(
            test="units",
            scale=AxisScale(".1%", least=1.0, least_reach=1.0),
            label="share of frames with similarity below {low:g}",
            parts=low_parts,
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
            parts=saliency_parts,
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
        of=mean_saliency,
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
        by_recording=detected_by_recording,
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
            parts=detected_parts,
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
        by_recording=alarms_by_recording,
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
        by_recording=rate_by_recording(alarms_by_recording, per_s=60),
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
        by_recording=episodes_by_recording,
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
        by_recording=rate_by_recording(episodes_by_recording, per_s=3600),
        tables=(MeasureTable.SCORECARD, MeasureTable.FALSE_ALERTS),
        inference=Inference(
            test="units",
            scale=AxisScale(",.0f", least=1.0, least_reach=1.0, unit="episodes per hour"),
            parts=episode_parts,
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
