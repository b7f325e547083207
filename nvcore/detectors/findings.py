"""Systems that were trained on what they are scored on, as their records of provenance say."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from typing import Final

import numpy as np
from numpy.typing import NDArray

from nvcore.auditing import Checks
from nvcore.auditing.cases import place_of_frame, spelled
from nvcore.dataset import Dataset
from nvcore.dataset.provenance import Provenance, TrainedOn, is_in_ranges
from nvcore.detectors.training.overlap import training_overlap
from nvcore.findings import Cases, Caveats, Finding, Remedy, Severity, Step

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


def audit_provenance(dataset: Dataset) -> list[Finding]:
    """What the records of systems contradict: scored on their training, not run, other files."""
    findings: list[Finding] = []
    for name in dataset.systems:
        record = dataset.provenance.get(name)
        if record is not None:
            findings += trained_findings(dataset, name, record.about.trained_on)
            findings += _not_run(dataset, name, record)
            findings += _other_files(dataset, name, record)
    return findings


def trained_findings(dataset: Dataset, name: str, trained_on: Sequence[TrainedOn]) -> list[Finding]:
    """Evaluated frames that are among those of the training, and recordings that are in part.

    Parameters
    ----------
    name
        Of the system or detector.
    """
    overlap = training_overlap(dataset, trained_on)
    is_trained = overlap.is_trained
    is_in_part = overlap.has_part[dataset.frame_columns.recording]
    of_frames = partial(_of_frames, dataset, name)
    return [
        *of_frames(
            is_trained,
            "trained-on-tested",
            "Trained on {n} of the {n_all} evaluated frames: {recordings}.",
            "Compare it on recordings that it was not trained on, or on other frames: these say "
            "how well it remembers, not how well it detects.",
            severity=Severity.ERROR,
            steps=(Step(Remedy.OPTION, "", "only"), Step(Remedy.FRAMES)),
        ),
        *of_frames(
            overlap.is_namesake & ~is_trained,
            "trained-on-namesake",
            "Trained on {n} frames of recordings of the same name, with other ground truth: "
            "{recordings}.",
            "Find out whether they are the same recordings: if so, these say how well it "
            "remembers, not how well it detects.",
        ),
        *of_frames(
            is_in_part & ~is_trained,
            "trained-beside-tested",
            "{n} evaluated frames are of recordings of which other frames were its training: "
            "{recordings}.",
            "The people and the place may be the same as in its training: recordings of which it "
            "has seen nothing say more.",
        ),
        *of_frames(
            overlap.is_unchecked & ~is_trained,
            "training-unchecked",
            "The ground truth of {n} of the {n_all} evaluated frames was not compared with the "
            f"{len(trained_on):,} parts of its training, which are too many: {{recordings}}.",
            "They may be of its training, under their own name or another. Compare fewer "
            "recordings at a time.",
            steps=(Step(Remedy.OPTION, "", "only"),),
        ),
    ]


def _not_run(dataset: Dataset, name: str, record: Provenance) -> list[Finding]:
    """Evaluated frames that the detector was never given: their pedestrians count as missed."""
    if not record.frames:
        return []
    frames = dataset.frame_columns
    is_run = np.zeros(len(frames), dtype=bool)
    for number, recording in enumerate(dataset.recordings["name"]):
        rows = frames.rows_of(number)
        is_run[rows] = is_in_ranges(frames.frame[rows], record.frames.get(recording, ()))
    return _of_frames(
        dataset,
        name,
        ~is_run,
        "frames-not-run",
        "Not run on {n} of the {n_all} evaluated frames: {recordings}.",
        f"Their {dataset.objects.plural} count as missed. Run it on them, or leave them out.",
        steps=(Step(Remedy.OPTION, "", "only"), Step(Remedy.FRAMES)),
    )


def _of_frames(
    dataset: Dataset,
    name: str,
    is_concerned: NDArray[np.bool_],
    code: str,
    message: str,
    advice: str,
    *,
    severity: Severity = Severity.WARNING,
    steps: tuple[Step, ...] = (),
) -> list[Finding]:
    """A finding about rows of the frames table; none where no row is concerned.

    Parameters
    ----------
    message
        With places for ``n``, the number of these frames, ``n_all`` and the ``recordings``.
    """
    rows = np.flatnonzero(is_concerned)
    if not len(rows):
        return []
    frames = dataset.frame_columns
    names = dataset.recordings["name"].iloc[np.unique(frames.recording[rows])]
    n, n_all = f"{len(rows):,}", f"{len(frames):,}"
    text = message.format(n=n, n_all=n_all, recordings=spelled(names))
    example, cases = place_of_frame(dataset, int(rows[0])), Cases("frames", rows)
    return [
        Finding(
            severity,
            code,
            name,
            len(rows),
            text,
            advice,
            example=example,
            cases=cases,
            steps=steps,
        )
    ]


def _other_files(dataset: Dataset, name: str, record: Provenance) -> list[Finding]:
    """Detections that are not those which the record is about."""
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


CHECKS: Final = Checks(inputs=(audit_provenance,))
