"""Introductions to the sections on how well estimators know what the driver sees."""

from __future__ import annotations

from typing import Final

from nvcore.report.html.blocks import Intro

ERRORS: Final = Intro(
    what="How far estimates are from the share of the subjects who saw the pedestrian: the mean of "
    "the squared differences.",
    how="Every pedestrian is estimated by regressions that were chosen and trained without him. "
    "Switched: the regression of the adaptation period, the time since it became dark. Single: one "
    "for all periods, which does not know the period. Constant: the mean of the other pedestrians' "
    "detectability at that period, without any picture.",
    best="0; an error at or above the constant's means that nothing was learned.",
    limits="It says nothing of other cameras, roads or people than those of the trials.",
)
SEEN: Final = Intro(
    what="Detectability is the share of the subjects who found the pedestrian that long after it "
    "became dark: 0 nobody, 1 everybody.",
)
FEATURES: Final = Intro(
    what="Which features of the pedestrian in the picture the estimators were chosen to look at.",
    how="The choice is made anew without each pedestrian. The ranking of the pairs is of their own "
    "errors: read it as a ranking; what an honest choice is worth is the error of switched, above.",
)
SUBJECTS: Final = Intro(
    what="Who responded, and whose responses are unlike those of the others. Nobody is left out "
    "for being odd.",
)
