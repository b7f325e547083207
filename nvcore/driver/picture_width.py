"""Warn about pictures whose width differs from that of the training pictures.

Features that depend on the picture size differ there.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

from nvcore.driver.estimators import Estimator
from nvcore.driver.features import FEATURES
from nvcore.driver.run import RecordingFeatures
from nvcore.notes import Note
from nvcore.wording import MOST_NAMED, listed, one_line

WIDTH_FACTOR: Final = 1.1
"""Factor above which the widths of pictures count as different. (Our choice.)"""


def other_widths(recordings: Sequence[RecordingFeatures], estimator: Estimator) -> dict[str, int]:
    """Return picture widths that differ from those of the training, by recording name.

    Grey pictures that are not declared as visible light are left out: nothing is estimated from
    them. Empty if the width in the training is unknown, or no feature depends on it.
    """
    if estimator.origin.picture_px is None or not _labels_of_scale(estimator):
        return {}
    trained = estimator.origin.picture_px[0]
    return {
        part.name: part.picture_px[0]
        for part in recordings
        if part.picture_px is not None
        and not part.may_be_of_heat
        and max(part.picture_px[0], trained) > WIDTH_FACTOR * min(part.picture_px[0], trained)
    }


def other_width_notes(recordings: Sequence[RecordingFeatures], estimator: Estimator) -> list[Note]:
    """Return a note for each differing width, with the recordings that have it."""
    names: dict[int, list[str]] = {}
    for name, width in other_widths(recordings, estimator).items():
        names.setdefault(width, []).append(one_line(name))
    picture_px = estimator.origin.picture_px
    return [
        Note(
            "driver.other_width",
            names=listed(of_width, most=MOST_NAMED),
            width=width,
            trained=picture_px[0],
            features=_labels_of_scale(estimator),
        )
        for width, of_width in names.items()
        if picture_px is not None
    ]


def _labels_of_scale(estimator: Estimator) -> list[str]:
    """Return the labels of the estimator's features that depend on the picture size in pixels."""
    taken = estimator.features
    return [feature.label for feature in FEATURES if feature.is_of_scale and feature.key in taken]
