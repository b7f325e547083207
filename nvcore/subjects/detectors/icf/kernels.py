"""Compiled loops for training and detection.

Like those of `nvcore.metrics.kernels`, they take a range (``lo``, ``hi``), release the interpreter
lock and write into arrays of the caller, so that threads share the work. No result depends on where
a range ends. Sums over rectangles are differences of four values of a 32-bit integral image modulo
2^32, which is exact for pictures of any size.
"""

from __future__ import annotations

import numpy as np

from nvcore.metrics.kernels import compiled

GREY_LEVELS = 511
"""Number of possible differences of two grey levels, -255..255."""
BINS = 256
"""Number of bins of a feature's values."""


@compiled
def gradients(grey, table, magnitude, orientations):
    """Compute the gradient magnitude of each pixel, also in the plane of its orientation.

    Differences are between the two neighbours of a pixel; at the edge, between the neighbour and
    the pixel. ``table[(gy + 255) * 511 + gx + 255]`` is the magnitude plus 256 times the
    orientation bin. `orientations` (bins, h, w) must hold zeros. It or `magnitude` (h, w) may be
    empty.
    """
    height, width = grey.shape
    for y in range(height):
        above, below = max(y - 1, 0), min(y + 1, height - 1)
        for x in range(width):
            gx = np.int64(grey[y, min(x + 1, width - 1)]) - grey[y, max(x - 1, 0)]
            gy = np.int64(grey[below, x]) - grey[above, x]
            entry = table[(gy + 255) * GREY_LEVELS + gx + 255]
            if magnitude.size:
                magnitude[y, x] = entry & 255
            if orientations.size:
                orientations[entry >> 8, y, x] = entry & 255


@compiled
def corner_sum(integral, base, corners, node, half):
    """Return the sum over a rectangle at a window from its corner offsets. All are unsigned.

    It is short so that the compiler inlines it. Otherwise the loops take seven times as long.
    """
    one, two, three = np.uint64(1), np.uint64(2), np.uint64(3)
    return (
        np.int64(integral[base + np.uint64(corners[node, half])])
        - integral[base + np.uint64(corners[node, half + one])]
        - integral[base + np.uint64(corners[node, half + two])]
        + integral[base + np.uint64(corners[node, half + three])]
    )


@compiled
def scan(
    lo, hi, integral, width, stride, corners, threshold, has_second, leaves, floors, restarts,
    is_open, score, depth,
):  # fmt: skip
    """Compute the confidence of the windows in rows lo..hi of the grid, NaN if rejected.

    The outer loop runs over trees, the inner one over the remaining windows of a row, as neighbours
    read the same cache lines of the integral images. Indices are unsigned, and the path of a window
    is computed without a branch. Together this is four times as fast.

    Parameters
    ----------
    integral
        Integral images of all planes one after another, int32, flat.
    width
        Width of an integral image.
    corners
        (n_trees * 3, 8) uint32: the corners of two rectangles (`corner_offsets`) of each tree's
        root, left and right node.
    threshold
        (n_trees * 3,) int32.
    has_second
        Whether any feature is a difference of two rectangles.
    leaves
        (n_trees, 4): confidence of each leaf.
    floors, restarts
        Minimum sum to pass each tree, and whether that sum restarts at the tree.
    is_open
        (rows, columns) windows to evaluate.
    score, depth
        Output: sum over all trees, and number of evaluated trees.
    """
    n_trees, n_columns = floors.size, is_open.shape[1]
    zero, one, two, four = np.uint64(0), np.uint64(1), np.uint64(2), np.uint64(4)
    step = np.uint64(stride)
    column = np.empty(n_columns, np.uint64)
    total, part = np.empty(n_columns), np.empty(n_columns)
    for row in range(lo, hi):
        n_left = zero
        for c in range(n_columns):
            score[row, c] = np.nan
            depth[row, c] = 0
            if is_open[row, c]:
                column[n_left] = c
                total[n_left] = part[n_left] = 0.0
                n_left += one
        first = np.uint64(row * stride * width)
        for tree in range(n_trees):
            root = np.uint64(3 * tree)
            restart, floor = restarts[tree], floors[tree]
            n_staying = zero
            i = zero
            while i < n_left:
                base = first + column[i] * step
                value = corner_sum(integral, base, corners, root, zero)
                if has_second:
                    value -= corner_sum(integral, base, corners, root, four)
                right = np.uint64(np.int32(value) >= threshold[root])
                child = root + one + right
                value = corner_sum(integral, base, corners, child, zero)
                if has_second:
                    value -= corner_sum(integral, base, corners, child, four)
                leaf = two * right + np.uint64(np.int32(value) >= threshold[child])
                confidence = leaves[tree, leaf]
                sum_of_part = confidence if restart else part[i] + confidence
                at = column[i]
                depth[row, at] = tree + 1
                column[n_staying] = at
                total[n_staying] = total[i] + confidence
                part[n_staying] = sum_of_part
                n_staying += np.uint64(sum_of_part >= floor)
                i += one
            n_left = n_staying
            if n_left == zero:
                break
        i = zero
        while i < n_left:
            score[row, column[i]] = total[i]
            i += one


@compiled
def feature_values(lo, hi, integral, base, corners, has_second, values):
    """Compute the value of every feature at windows lo..hi: ``values[window, feature]``, int32.

    Parameters
    ----------
    integral
        Flat, int32, for one picture or for many windows one after another.
    base
        Offset of each window in the array, int64.
    corners, has_second
        (n_features, 8); see `scan`.
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
def best_stumps(lo, hi, bins, features, node, signed, gain, cut):
    """Find the best split of each node by each of the features lo..hi.

    The gain of a split is the difference of both sides, ``abs(right - left)`` of their sums of
    signed weights. The weighted error of a stump is lowest where the gain is highest. Ties go to
    the lowest cut.

    Parameters
    ----------
    bins
        (n_features, n_windows) uint8.
    features
        Candidate features, int64.
    node, signed
        Node (0 or 1) that each window has reached, and its weight, negative for background.
    gain, cut
        Output, (n_tried, 2), for the best split. Windows in bins above the cut go right.
    """
    n, shift = node.size, np.uint64(8)  # a node's histogram has 2^8 bins
    n_whole = n - n % 4
    # four independent sums, so that no addition waits for the previous one
    sums = np.empty((4, 2 * BINS))
    for tried in range(lo, hi):
        values = bins[features[tried]]
        sums[:] = 0.0
        for i in range(0, n_whole, 4):
            for lane in range(4):
                k = i + lane
                sums[lane, (np.uint64(node[k]) << shift) + np.uint64(values[k])] += signed[k]
        for k in range(n_whole, n):
            sums[0, (np.uint64(node[k]) << shift) + np.uint64(values[k])] += signed[k]
        for side in range(2):
            whole = 0.0
            for b in range(side * BINS, (side + 1) * BINS):
                sums[0, b] += sums[1, b] + sums[2, b] + sums[3, b]
                whole += sums[0, b]
            left, best, best_cut = 0.0, -1.0, 0
            for b in range(BINS - 1):
                left += sums[0, side * BINS + b]
                apart = abs(whole - 2.0 * left)
                if apart > best:
                    best, best_cut = apart, b
            gain[tried, side], cut[tried, side] = best, best_cut
