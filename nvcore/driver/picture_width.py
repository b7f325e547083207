"""Whether pictures are as wide as those of the training: sizes mean something else otherwise."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

from nvcore.driver.estimators import Estimator
from nvcore.driver.features import FEATURES
from nvcore.driver.run import RecordingFeatures
from nvcore.notes import Note
from nvcore.wording import MOST_NAMED, listed, one_line

WIDTH_FACTOR: Final = 1.1
"""By more than that the width of pictures differs from that of the training; ours."""


def other_widths(recordings: Sequence[RecordingFeatures], estimator: Estimator) -> dict[str, int]:
    """Width of the pictures of each recording, by name, where the training's is another.

    Grey pictures that nobody calls visible are left out: nothing is estimated from them. Empty
    where it is not known how wide those of the training were, or no feature depends on it.
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
    """Return a note on these pictures for each width."""
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
    """Which features that it takes depend on the number of pixels of a picture."""
    taken = estimator.features
    return [feature.label for feature in FEATURES if feature.is_of_scale and feature.key in taken]
