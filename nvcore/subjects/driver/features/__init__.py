"""Features of how visible a pedestrian is in a visible-light picture.

    features_of(picture, boxes, fixation)      one row a pedestrian, one column a feature

The box is the pedestrian, and a ring around it the surround. Both end at the edge of the picture.
"""

from nvcore.common.extras import needs
from nvcore.subjects.driver.features.registry import (
    FEATURE_KEYS,
    FEATURES,
    LABELS,
    Feature,
    FeatureSettings,
    words_of,
)

with needs("driver", "features of pictures need"):
    from nvcore.subjects.driver.features.compute import features_of

__all__ = [
    "FEATURES",
    "FEATURE_KEYS",
    "LABELS",
    "Feature",
    "FeatureSettings",
    "features_of",
    "words_of",
]
