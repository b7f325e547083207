"""Findings about detectability estimates: rows without a box, and boxes without an estimate."""

from __future__ import annotations

from typing import Final

import numpy as np

from nvcore.auditing.cases import file_name, place, place_of_frame
from nvcore.common.findings import Cases, Caveats, Finding, Severity
from nvcore.common.wording import count_text
from nvcore.dataset import Dataset
from nvcore.subjects.driver.comparison.judging import is_unknown
from nvcore.subjects.driver.inputs.session import DETECTABILITY

OTHER_FRAMES = "frame not listed"


def audit_detectability(dataset: Dataset) -> list[Finding]:
    """Return findings about a session's file of estimates, or none without such a file."""
    if dataset.of("driver") is None:
        return []
    lost = dataset.left_out.reset_index(drop=True)
    lost = lost[lost["subject"] == DETECTABILITY]
    is_other = lost["reason"] == OTHER_FRAMES
    findings = []
    for code, rows, message, advice in (
        (
            "detectability-without-box",
            lost[~is_other],
            "of no box of the ground truth",
            "Estimate detectability for this ground truth, or correct recording, frame, box or "
            "track of these rows.",
        ),
        (
            "detectability-of-other-frames",
            lost[is_other],
            "of frames that are not evaluated",
            "Nothing to do if only some frames are evaluated; else check the frame numbers.",
        ),
    ):
        if rows.empty:
            continue
        first = rows.iloc[0]
        line = int(first["line"])
        name = file_name(dataset, int(first["file"]), line)
        finding = Finding(
            severity=Severity.WARNING if code.endswith("box") else Severity.NOTE,
            code=code,
            subject=DETECTABILITY,
            count=len(rows),
            message=f"{count_text(len(rows), 'row is', 'rows are')} left out: {message}.",
            advice=advice,
            file=name,
            example=place(first["recording"], int(first["frame"]), line=line, file=name),
            cases=Cases("left_out", rows.index.to_numpy()),
        )
        findings.append(finding)
    truth, is_missing = dataset.truth, is_unknown(dataset)
    if n := int(np.count_nonzero(is_missing)):
        row, noun = int(np.argmax(is_missing)), dataset.objects.singular
        boxes = count_text(n, f"{noun} box has", f"{noun} boxes have")
        finding = Finding(
            severity=Severity.NOTE,
            code="boxes-without-detectability",
            subject=DETECTABILITY,
            count=n,
            message=f"{boxes} no detectability, of {int(np.count_nonzero(~truth.ignore)):,}.",
            advice=f"Encounters in which it is unknown until the {noun} is near enough to count "
            "are counted apart.",
            example=place_of_frame(dataset, int(truth.frame_index[row])),
            cases=Cases("boxes", np.flatnonzero(is_missing) + truth.first_row),
        )
        findings.append(finding)
    return findings


CAVEATS: Final = Caveats(
    warned={},
    lesser={
        "detectability-without-box": "estimates of detectability are of no box of the ground truth",
        "doubtful-light-meter": "a light meter may be of another unit or clock, and with it what "
        "the driver sees",
        "doubtful-visible-pictures": "pictures or gaze may be of another view, and with it what "
        "the driver sees",
        "detectability-other-record": "the record of how detectability was estimated is about "
        "another file",
        "detectability-twice": "ground truth and estimates state different detectabilities",
    },
)
