"""Findings about systems that were trained on frames they are scored on, from their provenance."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Final

import numpy as np
from numpy.typing import NDArray

from nvcore.auditing.cases import place_of_frame, spelled
from nvcore.common.findings import Cases, Caveats, Finding, Remedy, Severity, Step
from nvcore.dataset import Dataset
from nvcore.dataset.provenance import Provenance, TrainedOn, is_in_ranges
from nvcore.subjects.detectors.training.overlap import training_overlap

CAVEATS: Final = Caveats(
    warned={
        "trained-on-tested": "a system is scored on frames that it was trained on",
        "trained-on-namesake": "a system may be scored on frames that it was trained on",
        "training-unchecked": "not all frames were compared with what a system was trained on",
    },
    lesser={
        "trained-beside-tested": "a system was trained on other frames of the same recordings",
        "frames-not-run": "a system was not run on all evaluated frames",
        "other-provenance": "a system's record of its training is about other files",
    },
)


_ONLY: Final = Step(Remedy.OPTION, "", "only")
_OF_FRAMES: Final[Mapping[str, tuple[Severity, str, str, tuple[Step, ...]]]] = {
    "trained-on-tested": (
        Severity.ERROR,
        "Trained on {n} of the {n_all} evaluated frames: {recordings}.",
        "Compare it on recordings that it was not trained on, or on other frames: these say how "
        "well it remembers, not how well it detects.",
        (_ONLY, Step(Remedy.FRAMES)),
    ),
    "trained-on-namesake": (
        Severity.WARNING,
        "Trained on {n} frames of recordings of the same name, with other ground truth: "
        "{recordings}.",
        "Find out whether they are the same recordings: if so, these say how well it remembers, "
        "not how well it detects.",
        (),
    ),
    "trained-beside-tested": (
        Severity.WARNING,
        "{n} evaluated frames are of recordings of which other frames were its training: "
        "{recordings}.",
        "The people and the place may be the same as in its training: recordings of which it has "
        "seen nothing say more.",
        (),
    ),
    "training-unchecked": (
        Severity.WARNING,
        "The ground truth of {n} of the {n_all} evaluated frames was not compared with the "
        "{n_parts} parts of its training, which are too many: {recordings}.",
        "They may be of its training, under their own name or another. Compare fewer recordings "
        "at a time.",
        (_ONLY,),
    ),
    "frames-not-run": (
        Severity.WARNING,
        "Not run on {n} of the {n_all} evaluated frames: {recordings}.",
        "Their {objects} count as missed. Run it on them, or leave them out.",
        (_ONLY, Step(Remedy.FRAMES)),
    ),
}
"""Severity, message, advice and suggested fixes of findings about frames, by code."""


def audit_provenance(dataset: Dataset) -> list[Finding]:
    """Find contradictions to provenance records: training frames, frames not run, changed files."""
    findings: list[Finding] = []
    frames = dataset.frame_columns
    for name in dataset.systems:
        record = dataset.provenance.get(name)
        if record is None:
            continue
        findings += trained_findings(dataset, name, record.about.trained_on)
        is_run = np.full(len(frames), not record.frames)
        for number, recording in enumerate(dataset.recordings["name"] if record.frames else ()):
            rows = frames.rows_of(number)
            is_run[rows] = is_in_ranges(frames.frame[rows], record.frames.get(recording, ()))
        findings += _of_frames(dataset, name, {"frames-not-run": ~is_run})
        findings += _other_files(dataset, name, record)
    return findings


def trained_findings(dataset: Dataset, name: str, trained_on: Sequence[TrainedOn]) -> list[Finding]:
    """Return findings about evaluated frames in the training data and about partly used recordings.

    Parameters
    ----------
    name
        Name of the system or detector.
    """
    overlap = training_overlap(dataset, trained_on)
    others = {
        "trained-on-namesake": overlap.is_namesake,
        "trained-beside-tested": overlap.has_part[dataset.frame_columns.recording],
        "training-unchecked": overlap.is_unchecked,
    }
    masks = {code: is_concerned & ~overlap.is_trained for code, is_concerned in others.items()}
    masks = {"trained-on-tested": overlap.is_trained, **masks}
    return _of_frames(dataset, name, masks, n_parts=f"{len(trained_on):,}")


def _of_frames(
    dataset: Dataset, name: str, masks: Mapping[str, NDArray[np.bool_]], **words: str
) -> list[Finding]:
    """Return one finding for each code whose mask selects any frame."""
    frames, findings = dataset.frame_columns, []
    for code, is_concerned in masks.items():
        severity, message, advice, steps = _OF_FRAMES[code]
        rows = np.flatnonzero(is_concerned)
        if len(rows):
            n, n_all = f"{len(rows):,}", f"{len(frames):,}"
            names = spelled(dataset.recordings["name"].iloc[np.unique(frames.recording[rows])])
            findings.append(
                Finding(
                    severity,
                    code,
                    name,
                    len(rows),
                    message.format(n=n, n_all=n_all, recordings=names, **words),
                    advice.format(objects=dataset.objects.plural),
                    example=place_of_frame(dataset, int(rows[0])),
                    cases=Cases("frames", rows),
                    steps=steps,
                )
            )
    return findings


def _other_files(dataset: Dataset, name: str, record: Provenance) -> list[Finding]:
    """Return a finding if the detections differ from the files in the provenance record."""
    own = dataset.inputs[dataset.inputs["subject"] == name]
    others = (
        own["file"][~own["sha256"].isin(record.files.values())] if record.files else own["file"][:0]
    )
    if not len(others):
        return []
    n = "" if len(own) == 1 else f"{len(others):,} of {len(own):,} files: "
    return [
        Finding(
            severity=Severity.WARNING,
            code="other-provenance",
            subject=name,
            count=len(others),
            message="The record of how these detections were made is not about these files "
            f"({n}{spelled(others)}).",
            advice="They have changed since, or the session names a record of another run.",
            file=str(others.iloc[0]) if len(others) == 1 else "",
        )
    ]
