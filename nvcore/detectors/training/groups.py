"""Items held out of a training: whole groups of them, or the end of each recording."""

from __future__ import annotations

from collections.abc import Hashable, Sequence

import numpy as np
from numpy.typing import NDArray

from nvcore.errors import ParameterError


def by_group(groups: Sequence[Hashable], share: float, seed: int) -> NDArray[np.bool_]:
    """Hold out whole groups, so that none is on both sides.

    Groups are recordings; or physical objects, where pictures are tracks of the same one.

    Parameters
    ----------
    groups
        Name of the group of each item, (n,).
    share
        Of the groups to be held out, rounded; where there are two or more, at least one is held
        out and one is not.

    Returns
    -------
    bool, (n,): whether each item is held out.

    Raises
    ------
    ParameterError
        Unless 0 < share < 1.
    """
    _check_share(share)
    names = list(dict.fromkeys(groups))
    n_out = min(max(1, round(share * len(names))), len(names) - 1)
    chosen = np.random.default_rng(seed).permutation(len(names))[: max(n_out, 0)]
    out = {names[i] for i in chosen}
    return np.array([group in out for group in groups], np.bool_)


def by_time(
    recording: NDArray[np.int64], frame: NDArray[np.int64], share: float, gap: int = 0
) -> tuple[NDArray[np.bool_], NDArray[np.bool_]]:
    """Train on the beginning of each recording, hold out its end.

    Parameters
    ----------
    recording, frame
        Of each item, (n,).
    share
        Of each recording's frames, from its first to its last item, to be held out.
    gap
        Frames before the held-out part that are on neither side, since neighbours are alike.

    Returns
    -------
    Whether each item is trained on, and whether it is held out; bool, (n,).

    Raises
    ------
    ParameterError
        Unless 0 < share < 1 and the gap is at least 0.
    """
    _check_share(share)
    if gap < 0:
        raise ParameterError(f"gap: expected 0 or more frames, got {gap}")
    is_trained, is_out = np.zeros(len(frame), np.bool_), np.zeros(len(frame), np.bool_)
    for name in np.unique(recording):
        is_here = recording == name
        first, last = int(frame[is_here].min()), int(frame[is_here].max())
        border = first + round((1 - share) * (last - first + 1))
        is_out |= is_here & (frame >= border)
        is_trained |= is_here & (frame < border - gap)
    return is_trained, is_out


def _check_share(share: float) -> None:
    if not 0 < share < 1:
        raise ParameterError(f"share: expected more than 0 and less than 1, got {share:g}")
