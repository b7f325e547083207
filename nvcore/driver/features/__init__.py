"""Features that say how visible a pedestrian is in a picture of visible light.

    features_of(picture, boxes, fixation)      one row a pedestrian, one column a feature

The box is the pedestrian, a ring around it the surround; both end at the edge of the picture.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from nvcore.extras import needs

with needs("driver", "features of pictures need"):
    from nvcore.driver.features.registry import FEATURE_KEYS, FEATURES, LABELS, Feature, words_of
    from nvcore.driver.features.settings import FeatureSettings
    from nvcore.driver.features.view import view_of
    from nvcore.driver.shapes import check_picture
    from nvcore.pictures import Picture

__all__ = [
    "FEATURES",
    "FEATURE_KEYS",
    "LABELS",
    "Feature",
    "FeatureSettings",
    "features_of",
    "words_of",
]


def features_of(
    picture: Picture,
    boxes: NDArray[np.float64],
    fixation: NDArray[np.float64] | tuple[float, float] | None = None,
    settings: FeatureSettings | None = None,
) -> NDArray[np.float64]:
    """Compute the features of the pedestrians in one picture.

    Parameters
    ----------
    picture
        Grey (h, w) or RGB (h, w, 3), uint8. One whose channels differ nowhere by more than 8 levels
        is grey.
    boxes
        (n, 4): x, y, w, h of each pedestrian, px of the picture.
    fixation
        Where the driver looks, x and y, px of the picture; or one point for each pedestrian (n, 2);
        None: unknown.
    settings
        What the paper leaves open; None: our defaults.

    Returns
    -------
    float64, shape (n, n_features), columns as in `FEATURE_KEYS`. NaN: undefined, as colours are in
    a grey picture, all but the sizes of a box without a pixel, contrasts where the picture ends
    with the box, and everything of a box outside the picture.

    Raises
    ------
    ParameterError
        If the picture has no pixel, or anything is of another shape or type.

    Examples
    --------
    >>> picture = np.zeros((100, 100), np.uint8)
    >>> picture[20:60, 40:60] = 50
    >>> dict(zip(FEATURE_KEYS, features_of(picture, np.array([[40, 20, 20, 40.0]]))[0].tolist()))
    ... # doctest: +ELLIPSIS, +NORMALIZE_WHITESPACE
    {'width_px': 20.0, 'height_px': 40.0, 'luminance_sd': 0.0, 'luminance_contrast': 50.0, ...}
    """
    check_picture(picture)
    view = view_of(picture, boxes, fixation, settings or FeatureSettings())
    return np.stack([feature.of(view) for feature in FEATURES], axis=1)
