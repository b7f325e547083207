"""Loops over the windows and features of a training."""

from __future__ import annotations

import numpy as np

from nvcore.detectors.icf.kernels.pictures import corner_sum
from nvcore.metrics.kernels import compiled

BINS = 256
_BLOCK = 16  # features whose values share a line of the cache


@compiled
def feature_values(lo, hi, integral, base, corners, has_second, values):
    """Value of every feature at windows lo..hi: ``values[window, feature]``, int32.

    Parameters
    ----------
    integral
        Flat, int32; of one picture, or of many windows one after another.
    base
        Where each window begins in it, int64.
    corners, has_second
        (n_features, 8), as of the kernel `scan`.
    """
    zero, one, four = np.uint64(0), np.uint64(1), np.uint64(4)
    n_features = np.uint64(corners.shape[0])
    for window in range(lo, hi):
        first = np.uint64(base[window])
        feature = zero
        while feature < n_features:
            value = corner_sum(integral, first, corners, feature, zero)
            if has_second:
                value -= corner_sum(integral, first, corners, feature, four)
            values[window, feature] = np.int32(value)
            feature += one


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
def best_stumps(lo, hi, bins, features, node, signed, gain, cut):
    """Best split of each node by each of the features lo..hi.

    The gain of a split is how far apart both sides are, ``abs(right - left)`` of their sums of
    signed weights: the weighted error of a stump is least where it is greatest. Of equal ones the
    lowest cut counts.

    Parameters
    ----------
    bins
        (n_features, n_windows) uint8.
    features
        Those that are tried, int64.
    node, signed
        Node (0 or 1) that each window has come to, and its weight, negative for background.
    gain, cut
        Out, (n_tried, 2): of the best split; windows of bins above the cut go right.
    """
    zero, one, two, three, four = (
        np.uint64(0), np.uint64(1), np.uint64(2), np.uint64(3), np.uint64(4)
    )  # fmt: skip
    eight = np.uint64(8)  # a node's histogram has 2^8 bins
    # four histograms: else each sum would wait for the one before it
    first, second = np.empty(2 * BINS), np.empty(2 * BINS)
    third, fourth = np.empty(2 * BINS), np.empty(2 * BINS)
    n = np.uint64(node.size)
    n_whole = n - n % four
    for tried in range(lo, hi):
        values = bins[features[tried]]
        first[:] = 0.0
        second[:] = 0.0
        third[:] = 0.0
        fourth[:] = 0.0
        i = zero
        while i < n_whole:
            j, k, m = i + one, i + two, i + three
            first[(np.uint64(node[i]) << eight) + np.uint64(values[i])] += signed[i]
            second[(np.uint64(node[j]) << eight) + np.uint64(values[j])] += signed[j]
            third[(np.uint64(node[k]) << eight) + np.uint64(values[k])] += signed[k]
            fourth[(np.uint64(node[m]) << eight) + np.uint64(values[m])] += signed[m]
            i += four
        while i < n:
            first[(np.uint64(node[i]) << eight) + np.uint64(values[i])] += signed[i]
            i += one
        for side in range(2):
            whole = 0.0
            for b in range(side * BINS, (side + 1) * BINS):
                first[b] += second[b] + third[b] + fourth[b]
                whole += first[b]
            left = 0.0
            best = -1.0
            best_cut = 0
            for b in range(BINS - 1):
                left += first[side * BINS + b]
                apart = abs(whole - 2.0 * left)
                if apart > best:
                    best = apart
                    best_cut = b
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
