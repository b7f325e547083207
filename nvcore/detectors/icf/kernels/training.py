"""Loops over the windows and features of a training."""

from __future__ import annotations

import numpy as np

from nvcore.detectors.icf.kernels.pictures import rectangle_sum
from nvcore.metrics.kernels import compiled

BINS = 256
_BLOCK = 16  # features whose values share a line of the cache


@compiled
def feature_values(lo, hi, integral, base, offsets, values):
    """Value of every feature at windows lo..hi: ``values[window, feature]``, int32.

    Parameters
    ----------
    integral
        Flat, int32; of one picture, or of many windows one after another.
    base
        Where each window begins in it, int64.
    offsets
        (n_features, 8) int32, as the first columns of the nodes of `scan`.
    """
    for window in range(lo, hi):
        for feature in range(offsets.shape[0]):
            values[window, feature] = rectangle_sum(integral, base[window], offsets[feature])


@compiled
def to_bins(lo, hi, values, edges, bins):
    """Number of edges at or below each value, of features lo..hi: ``bins[feature, window]``.

    Parameters
    ----------
    values
        (n_windows, n_features) int32.
    edges
        (n_features, 255) int32, ascending.
    """
    n_edges = edges.shape[1]
    for first in range(lo, hi, _BLOCK):
        last = min(first + _BLOCK, hi)
        for window in range(values.shape[0]):
            for feature in range(first, last):
                value = values[window, feature]
                start, stop = 0, n_edges
                while start < stop:
                    middle = (start + stop) // 2
                    if edges[feature, middle] <= value:
                        start = middle + 1
                    else:
                        stop = middle
                bins[feature, window] = start


@compiled
def best_stumps(lo, hi, bins, features, rows, node, signed, gain, cut):
    """Best split of each node by each of the features lo..hi.

    The gain of a split is how far apart both sides are, ``abs(right - left)`` of their sums of
    signed weights: twice the gain is what the weighted error of a stump falls by. Of equal ones
    the lowest cut counts.

    Parameters
    ----------
    bins
        (n_features, n_windows) uint8.
    features
        Those that are tried, int64.
    rows, node, signed
        Windows that take part, the node (0 or 1) that each has come to, and its weight, negative
        for background.
    gain, cut
        Out, (n_tried, 2): of the best split; windows of bins above the cut go right.
    """
    histogram = np.empty((4, 2 * BINS))
    n = rows.size
    n_whole = n - n % 4
    for tried in range(lo, hi):
        values = bins[features[tried]]
        histogram[:] = 0.0
        # four histograms: else each sum would wait for the one before it
        for i in range(0, n_whole, 4):
            histogram[0, node[i] * BINS + values[rows[i]]] += signed[i]
            histogram[1, node[i + 1] * BINS + values[rows[i + 1]]] += signed[i + 1]
            histogram[2, node[i + 2] * BINS + values[rows[i + 2]]] += signed[i + 2]
            histogram[3, node[i + 3] * BINS + values[rows[i + 3]]] += signed[i + 3]
        for i in range(n_whole, n):
            histogram[0, node[i] * BINS + values[rows[i]]] += signed[i]
        for side in range(2):
            whole = 0.0
            for k in range(side * BINS, (side + 1) * BINS):
                histogram[0, k] += histogram[1, k] + histogram[2, k] + histogram[3, k]
                whole += histogram[0, k]
            left = 0.0
            best = -1.0
            best_cut = 0
            for k in range(BINS - 1):
                left += histogram[0, side * BINS + k]
                apart = abs(whole - 2.0 * left)
                if apart > best:
                    best = apart
                    best_cut = k
            gain[tried, side] = best
            cut[tried, side] = best_cut


@compiled
def running_sums(lo, hi, values, feature, threshold, leaves, sums):
    """Sum of the confidences after each tree, of windows lo..hi: ``sums[window, tree]``.

    Parameters
    ----------
    values
        (n_windows, n_features) int32.
    feature, threshold
        (n_trees, 3): root, left and right node of each tree.
    leaves
        (n_trees, 4).
    """
    for window in range(lo, hi):
        total = 0.0
        for tree in range(feature.shape[0]):
            right = 1 if values[window, feature[tree, 0]] >= threshold[tree, 0] else 0
            leaf = 2 * right
            if values[window, feature[tree, 1 + right]] >= threshold[tree, 1 + right]:
                leaf += 1
            total += leaves[tree, leaf]
            sums[window, tree] = total
