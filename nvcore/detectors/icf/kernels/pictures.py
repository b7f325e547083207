"""Loops over the pixels and windows of a picture."""

from __future__ import annotations

import numpy as np

from nvcore.metrics.kernels import compiled

GREY_LEVELS = 511
"""Possible differences of two grey levels, -255..255."""


@compiled
def gradients(grey, table, magnitude, orientations):
    """Magnitude of the gradient of each pixel, and again in the plane of its orientation.

    Differences are those of the two neighbours, at the edge that of the neighbour and the pixel.
    ``table[(gy + 255) * 511 + gx + 255]`` is the magnitude plus 256 times the orientation's bin.
    `orientations` (bins, h, w) holds zeros; it or `magnitude` (h, w) may be empty.
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
    """Sum over a rectangle at a window, from the places of its corners; all unsigned."""
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
    """Confidence of the windows in rows lo..hi of the grid; NaN where a window is rejected.

    The trees go over the windows of a row that are left, one tree after another: neighbours read
    the same lines of the integral images. Indices are unsigned, and which way a window goes is
    arithmetic, not a branch: together this is four times as fast.

    Parameters
    ----------
    integral
        Integral images of all planes one after another, int32, flat.
    width
        Of an integral image.
    corners
        (n_trees * 3, 8) uint32: the corners of two rectangles (`corner_offsets`) of each tree's
        root, left and right node.
    threshold
        (n_trees * 3,) int32.
    has_second
        Whether any feature is a difference.
    leaves
        (n_trees, 4): confidence of each leaf.
    floors, restarts
        Lowest sum after each tree with which a window stays, and whether that sum begins anew
        with the tree.
    is_open
        (rows, columns) windows to be looked at.
    score, depth
        Out: sum over all trees, and the number of trees that were evaluated.
    """
    n_trees, n_columns = floors.size, is_open.shape[1]
    zero, one, two, four = np.uint64(0), np.uint64(1), np.uint64(2), np.uint64(4)
    step = np.uint64(stride)
    column = np.empty(n_columns, np.uint64)
    total = np.empty(n_columns)
    part = np.empty(n_columns)
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
