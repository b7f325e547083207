"""AdaBoost over trees of depth 2."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from nvcore.common.progress import Progress, no_progress
from nvcore.metrics.kernels import over_ranges
from nvcore.subjects.detectors.icf.kernels import BINS, best_stumps

_SAMPLED: Final = 4096
"""Number of windows sampled to compute bin edges."""
_BLOCK: Final = 512


@dataclass(frozen=True, eq=False)
class Trees:
    """Trees with three decisions and four leaves.

    Attributes
    ----------
    feature
        Feature of the root, the left and the right node; int32, (n, 3).
    threshold
        A window goes right if the feature's value is at least this; int32, (n, 3).
    leaves
        Confidence of each leaf from left to right, alpha or -alpha; float64, (n, 4).
    """

    feature: NDArray[np.int32]
    threshold: NDArray[np.int32]
    leaves: NDArray[np.float64]

    def __len__(self) -> int:
        return len(self.leaves)

    def leaves_of(self, values: NDArray[np.int32]) -> NDArray[np.int64]:
        """Return each window's leaf in each tree, 0..3 from left to right, (n_windows, n_trees).

        Parameters
        ----------
        values
            Values of all features, (n_windows, n_features).
        """
        root, left, right = (
            values[:, node] >= at for node, at in zip(self.feature.T, self.threshold.T, strict=True)
        )
        leaf: NDArray[np.int64] = 2 * root.astype(np.int64) + np.where(root, right, left)
        return leaf

    def running_sums(self, values: NDArray[np.int32]) -> NDArray[np.float64]:
        """Return the sum of confidences after each tree, float64, (n_windows, n_trees)."""
        sums = np.empty((len(values), len(self)))
        # in blocks, as indices of all windows take too much memory
        for first in range(0, len(values), _BLOCK):
            block = slice(first, first + _BLOCK)
            leaves = self.leaves_of(values[block])
            self.leaves[np.arange(len(self)), leaves].cumsum(axis=1, out=sums[block])
        return sums


@dataclass(frozen=True, eq=False)
class BoostingRound:
    """Result of one round of boosting.

    Attributes
    ----------
    trees
        Trees in the order in which they were learned.
    error
        Share of windows that the trees up to this one misclassify; float64, (n_trees,). 0 is best.
    """

    trees: Trees
    error: NDArray[np.float64]


def bin_edges(values: NDArray[np.int32]) -> NDArray[np.int32]:
    """Return edges that split each feature's values into 256 bins of about equal counts.

    Parameters
    ----------
    values
        (n_windows, n_features).

    Returns
    -------
    int32, (n_features, 255), ascending. Edges repeat if a feature has few values.
    """
    step = max(1, len(values) // _SAMPLED)
    sample = np.sort(values[::step], axis=0)
    rank = (np.arange(1, BINS) * len(sample)) // BINS
    return np.ascontiguousarray(sample[rank].T)


def boost(
    values: NDArray[np.int32],
    is_object: NDArray[np.bool_],
    *,
    n_trees: int,
    feature_share: float = 1.0,
    patience: int | None = None,
    seed: int = 0,
    progress: Progress = no_progress,
) -> BoostingRound:
    """Run discrete AdaBoost over trees of depth 2.

    Each tree is grown node by node, by the split whose sides differ most in signed weight. ``eps``
    is the weight of the misclassified windows, and ``alpha = ln((1 - eps) / eps) / 2`` the
    confidence of the tree. Weights are then multiplied by ``exp(-alpha)`` if correctly classified,
    by ``exp(alpha)`` otherwise, and normalised. Initially objects and background have a total
    weight of one half each.

    Parameters
    ----------
    values
        Feature values, int32, (n_windows, n_features).
    is_object
        Bool, (n_windows,); at least one window of each kind.
    n_trees, feature_share, patience
        As in `nvcore.subjects.detectors.icf.settings.IcfSettings`.

    Returns
    -------
    BoostingRound
        It has fewer trees if a tree makes no error and would be repeated, or no tree is better than
        chance.

    References
    ----------
    Y. Freund, R. Schapire: A decision-theoretic generalization of on-line learning, JCSS 1997;
    P. Dollár et al.: Integral channel features, BMVC 2009.
    """
    rng = np.random.default_rng(seed)
    edges = bin_edges(values)
    bins = np.empty((values.shape[1], len(values)), np.uint8)
    for of_feature, at, out in zip(values.T, edges, bins, strict=True):
        out[:] = np.searchsorted(at, of_feature, side="right")
    sign = np.where(is_object, 1.0, -1.0)
    weights = np.where(is_object, 0.5 / is_object.sum(), 0.5 / (~is_object).sum())
    total = np.zeros(len(values))
    nodes, leaves, error = [], [], []
    n_tried = max(1, round(feature_share * len(bins)))
    for tree in range(n_trees):
        progress(tree / n_trees, "boosting")
        tried = np.arange(len(bins))
        if n_tried < len(bins):
            tried = np.sort(rng.choice(len(bins), n_tried, replace=False))
        split, leaf = _grow(bins, tried, weights * sign)
        side = np.where(np.bincount(leaf, weights * sign, 4) > 0, 1.0, -1.0)
        is_wrong = side[leaf] != sign
        eps = float(weights[is_wrong].sum())
        if eps >= 0.5:
            break
        # an error of 0 would give infinite confidence: count half a window of mean weight as wrong
        share_wrong = eps if eps > 0 else 0.5 / len(weights)
        alpha = float(0.5 * np.log((1 - share_wrong) / share_wrong))
        weights = weights * np.exp(np.where(is_wrong, alpha, -alpha))
        weights /= weights.sum()
        total += alpha * side[leaf]
        nodes.append(split)
        leaves.append(alpha * side)
        error.append(float(((total > 0) != is_object).mean()))
        # equal weights would give the same tree again
        is_repeated = eps <= 0 and n_tried == len(bins)
        if is_repeated or _is_at_end(error, patience):
            break
    splits = np.array(nodes, np.int64).reshape(-1, 3, 2)
    feature, cut = splits[..., 0], splits[..., 1]
    trees = Trees(feature.astype(np.int32), edges[feature, cut], np.array(leaves).reshape(-1, 4))
    return BoostingRound(trees, np.array(error))


def _is_at_end(error: Sequence[float], patience: int | None) -> bool:
    """Whether the error has not fallen during the last `patience` trees."""
    if patience is None or len(error) <= patience:
        return False
    return min(error[-patience:]) >= min(error[:-patience])


def _grow(
    bins: NDArray[np.uint8], tried: NDArray[np.int64], signed: NDArray[np.float64]
) -> tuple[list[tuple[int, int]], NDArray[np.int64]]:
    """Return feature and cut of the three nodes, and the leaf (0..3) of each window."""
    node = np.zeros(len(signed), np.uint8)
    (root,) = _splits(bins, tried, node, signed, 1)
    node = (bins[root[0]] > root[1]).astype(np.uint8)
    left, right = _splits(bins, tried, node, signed, 2)
    below = np.where(node, bins[right[0]] > right[1], bins[left[0]] > left[1])
    return [root, left, right], 2 * node.astype(np.int64) + below


def _splits(
    bins: NDArray[np.uint8],
    tried: NDArray[np.int64],
    node: NDArray[np.uint8],
    signed: NDArray[np.float64],
    n_nodes: int,
) -> list[tuple[int, int]]:
    """Return the best feature and cut of each node. Ties go to the first feature."""
    gain = np.empty((len(tried), 2))
    cut = np.empty((len(tried), 2), np.int64)
    over_ranges(best_stumps, len(tried), bins, tried, node, signed, gain, cut, least=1)
    best = gain[:, :n_nodes].argmax(axis=0)
    return [(int(tried[i]), int(cut[i, k])) for k, i in enumerate(best)]
