"""Measures of pedestrians: saliency, encounters, severity, miss classes."""

from __future__ import annotations

from math import nan
from typing import Final

import numpy as np

from nvcore.comparison.compare import Result
from nvcore.comparison.measures.entry import (
    HIGHER,
    LOWER,
    NO_FRAMES,
    AxisScale,
    Inference,
    Measure,
    MeasureTable,
)
from nvcore.comparison.measures.values import (
    detected_by_recording,
    detected_parts,
    largest_event,
    rate_by_recording,
    ratio_of,
    relevant_share,
    saliency_parts,
    saliency_values,
    severity_by_recording,
    severity_parts,
)
from nvcore.comparison.scoring import SystemResult
from nvcore.dataset.schema import MissClass
from nvcore.settings.stages import ENCOUNTERS, EVENTS, MATCH, SALIENCY, SEVERITY

DETECTED: Final = "encounters_detected"
"""Key of the measure."""
_NONE_NEAR: Final = "no encounter is near enough to count"


def _miss_class(kind: MissClass) -> Measure:
    def count(result: Result, system: SystemResult) -> int:
        is_kind = (system.encounters["miss_class"] == kind.value).to_numpy()
        return int(np.count_nonzero(is_kind & result.is_near))

    words = "no failure" if kind is MissClass.NONE else kind.value.replace("_", " ")
    return Measure(
        key=f"miss_classes.{kind.value}",
        label=words,
        part=words,
        form="d",
        better=HIGHER if kind is MissClass.NONE else LOWER,
        stages=(ENCOUNTERS,),
        is_worsened_by_alarms=False,
        of=count,
        unit="encounters",
        meaning=f"Encounters with the miss class `{kind.value}`, those too far to count left out.",
        tables=(MeasureTable.MISS_CLASSES,),
    )


ENCOUNTER_MEASURES: Final[tuple[Measure, ...]] = (
    Measure(
        key="saliency",
        label="saliency, mean {aggregate} (s)",
        form=".3f",
        better=LOWER,
        stages=(SALIENCY,),
        is_worsened_by_alarms=False,
        leads=True,
        of=lambda _, system: system.saliency_s,
        unit="s",
        meaning="Mean over the recordings of each one's saliency: its largest saliency event, or "
        "the sum of all (`saliency_aggregate`); 0 without any.",
        empty=NO_FRAMES,
        by_recording=saliency_values,
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
        key="saliency_largest_event",
        label="largest event of all (s)",
        part="largest event of all (s)",
        form=".3f",
        better=LOWER,
        stages=(EVENTS,),
        is_worsened_by_alarms=False,
        of=lambda _, system: largest_event(system),
        unit="s",
        meaning="Saliency of the most salient event of all recordings; 0 without any.",
        empty=NO_FRAMES,
        tables=(MeasureTable.SCORECARD,),
    ),
    Measure(
        key="saliency_relevant_share",
        label="time of the events in which the {one} counts",
        part="of the events' time, {one} counts",
        form=".0%",
        better="",
        stages=(EVENTS,),
        is_worsened_by_alarms=False,
        of=lambda _, system: relevant_share(system),
        unit="0 to 1",
        meaning="Share of the events' time in which the missed {one} counts (k >= 0.5). The "
        "rest is of {many} far away.",
        empty="no events",
        tables=(MeasureTable.SCORECARD,),
    ),
    Measure(
        key=DETECTED,
        label="encounters detected, of {n_near:,}",
        form="d",
        better=HIGHER,
        stages=(ENCOUNTERS,),
        is_worsened_by_alarms=False,
        leads=True,
        of=lambda _, system: int(system.encounters["is_detected"].sum()),
        unit="encounters",
        meaning="Encounters that the system detected.",
        by_recording=detected_by_recording,
        tables=(MeasureTable.SCORECARD,),
        inference=Inference(
            test="encounters",
            scale=AxisScale(".0%", least=1.0, least_reach=1.0),
            label="share of encounters detected, within these recordings",
            form=".1%",
            split=lambda result: result.venn,
            per="n_encounters",
            repeats="encounters_detected_by_unit",
        ),
    ),
    Measure(
        key="encounters_detected_by_unit",
        label="share of encounters detected, by {units}",
        form=".1%",
        better=HIGHER,
        stages=(ENCOUNTERS,),
        is_worsened_by_alarms=False,
        inference=Inference(
            test="units",
            scale=AxisScale(".0%", least=1.0, least_reach=1.0),
            parts=detected_parts,
            per="n_encounters",
            noun="encounters detected",
        ),
    ),
    Measure(
        key="severity_s",
        label="severity of missed {many} (s)",
        form=".2f",
        better=LOWER,
        stages=(SEVERITY,),
        is_worsened_by_alarms=False,
        of=lambda _, system: float(system.failures["severity_s"].sum()),
        unit="s",
        meaning="What the failures weigh: the sum of cost * time step over the frames that count "
        "in which {a_one} was not matched, of all encounters. 1 s is one second of a "
        "full-weight miss.",
        by_recording=severity_by_recording,
        tables=(MeasureTable.SCORECARD,),
    ),
    Measure(
        key="severity_s_per_min",
        label="severity per minute (s)",
        part="per minute (s)",
        form=".2f",
        better=LOWER,
        stages=(SEVERITY,),
        is_worsened_by_alarms=False,
        of=lambda result, system: (
            60 * ratio_of(system.failures["severity_s"].sum(), result.duration_s)
        ),
        unit="s/min",
        meaning="The same per minute of recording.",
        empty=NO_FRAMES,
        by_recording=rate_by_recording(severity_by_recording, per_s=60),
        tables=(MeasureTable.SCORECARD,),
    ),
    Measure(
        key="severity_s_per_encounter",
        label="severity per encounter (s)",
        part="per encounter (s)",
        form=".3f",
        better=LOWER,
        stages=(SEVERITY,),
        is_worsened_by_alarms=False,
        leads=True,
        of=lambda result, system: ratio_of(system.failures["severity_s"].sum(), result.venn.n_near),
        unit="s",
        meaning="The same per encounter, those too far to count left out.",
        empty=_NONE_NEAR,
        tables=(MeasureTable.SCORECARD,),
        inference=Inference(
            test="units",
            scale=AxisScale(".2f", least=0.1, least_reach=0.01, unit="seconds"),
            label="severity of missed {many} per encounter (s)",
            parts=severity_parts,
            per="n_encounters",
            noun="severity of missed {many}",
            noun_unit=" s per encounter",
            needs_tracks=True,
        ),
    ),
    Measure(
        key="worst_severity_s",
        label="worst encounter (s)",
        part="worst encounter (s)",
        form=".2f",
        better=LOWER,
        stages=(SEVERITY,),
        is_worsened_by_alarms=False,
        leads=True,
        of=lambda result, system: (
            float(system.failures["severity_s"].max()) if result.venn.n_near else nan
        ),
        unit="s",
        meaning="Severity of the encounter in which the failures weigh most.",
        empty=_NONE_NEAR,
        tables=(MeasureTable.SCORECARD,),
    ),
    *(_miss_class(kind) for kind in MissClass),
    Measure(
        key="boxes_matched",
        label="boxes matched, near or far, of {n_boxes:,}",
        form="d",
        better=HIGHER,
        stages=(MATCH,),
        is_worsened_by_alarms=False,
        of=lambda _, system: int(system.matched.sum()),
        unit="boxes",
        meaning="Annotated {one} boxes matched, those too far to count as well.",
        tables=(MeasureTable.SCORECARD,),
    ),
)
