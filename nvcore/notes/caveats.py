"""Effects of audit findings on a verdict, as texts by the finding's code."""

from __future__ import annotations

from functools import cache
from itertools import chain
from typing import Final

from nvcore.common.findings import Caveats
from nvcore.common.subject import subjects

CAVEATS: Final = Caveats(
    warned={
        "track-reused": "track ids of the ground truth are used again after a gap, so that two "
        "{many} may be taken for one encounter",
        "short-encounters": "most encounters are one frame long, so that counts of them are counts "
        "of frames rather than {many}, and saliency and episodes mean little",
        "score-floors": "X and Y are compared at different operating points; with thresholds the "
        "other may come out better",
        "mixed-weighting": "X and Y are weighted by different rules",
        "same-boxes": "X and Y have the same boxes",
        "truth-as-system": "the ground truth was given as a system",
        "boxes-of-truth": "the boxes of a system are exactly those of the ground truth",
        "several-boxes": "a system has several boxes on most {many} whom it matches",
        "ignored-boxes-detected": "a system detects more of what the ground truth ignores than "
        "{many} who count",
        "false-alarms-like-matches": "a system has many false alarms that look like {people} "
        "missing from the ground truth, as if that were drawn by what the other system shows",
        "size-too-large": "the image size seems wrong",
        "implausible-fps": "the frame rate seems wrong",
        "box-layout": "boxes seem to be written in another way than they were read",
        "no-match": "a system matches not a single {one}",
        "agreed-by-both-alone": "both systems match hardly {anybody} and agree with one another",
        "lying-pedestrians": "nearly all {many} are wider than tall",
        "frame-rate": "a system's frames seem to be numbered at another rate",
        "time-offset": "a system seems to be off in time",
        "pixel-offset": "a system's boxes seem to be displaced",
        "scale-mismatch": "a system's boxes seem to be of another resolution",
        "frames-beyond-boxes": "frames without any box are evaluated",
        "no-detections": "a system has no detections",
        "threshold-keeps-nothing": "a threshold leaves no detection",
    },
    lesser={
        "missing-provenance": "a system's record of its training is not there",
        "kitti-size": "the truth contradicts the picture size of some recordings",
        "outside-picture": "boxes lie outside the picture",
        "boxes-in-fractions": "boxes seem to be in fractions of the picture rather than in pixels",
        "duplicate-box": "boxes are repeated",
        "row-number-ids": "ids of the ground truth number its boxes, so that {many} were linked by "
        "overlap",
        "duplicate-track": "{many} of one frame share a track id",
        "box-disputed-by-both": "both systems agree on other boxes than the ground truth's",
        "loose-boxes": "many false alarms of a system lie on {many} {whom} it thereby misses",
        "missing-score": "some detections have no score and pass every threshold",
        "threshold-without-scores": "a threshold has no effect, as no detection has a score",
        "truth-every-nth-frame": "most evaluated frames have no ground truth",
        "detections-every-nth-frame": "a system has no detections in most evaluated frames",
        "detections-in-part-of-recording": "a system has detections in parts of recordings only",
        "recording-without-detections": "a system has no detections in whole recordings",
        "unknown-recording": "recordings without ground truth are left out",
        "frame-not-listed": "rows of frames that are not evaluated are left out",
    },
)
"""Caveats of the core's own findings."""


@cache
def caveats() -> Caveats:
    """Return the caveats of all findings, including those of subjects."""
    every = (CAVEATS, *chain(*(subject.checks().caveats for subject in subjects())))
    return Caveats(
        warned=dict(chain(*(known.warned.items() for known in every))),
        lesser=dict(chain(*(known.lesser.items() for known in every))),
    )
