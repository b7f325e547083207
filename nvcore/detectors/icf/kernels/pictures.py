"""Loops over the pixels and windows of a picture."""

from __future__ import annotations

import numpy as np

from nvcore.metrics.kernels import compiled, intersection

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
def rectangle_sum(integral, base, node):
    """Sum of a feature at a window: its first rectangle, less its second one if it has one."""
    total = (
        np.int64(integral[base + node[0]])
        - integral[base + node[1]]
        - integral[base + node[2]]
        + integral[base + node[3]]
    )
    if node[4] >= 0:
        total -= (
            np.int64(integral[base + node[4]])
            - integral[base + node[5]]
            - integral[base + node[6]]
            + integral[base + node[7]]
        )
    return np.int32(total)


@compiled
def scan(lo, hi, integral, width, stride, nodes, leaves, floors, restarts, is_open, score, depth):
    """Confidence of the windows in rows lo..hi of the grid; NaN where a window is rejected.

    Parameters
    ----------
    integral
        Integral images of all planes one after another, int32, flat.
    width
        Of an integral image.
    nodes
        (n_trees * 3, 9) int32: offsets of the corners of two rectangles, and the threshold, of
        each tree's root, left and right node.
    leaves
        (n_trees * 4): confidence of each leaf.
    floors, restarts
        Lowest sum after each tree with which a window stays, and whether that sum begins anew
        with the tree.
    is_open
        (rows, columns) windows to be looked at.
    score, depth
        Out: sum over all trees, and the number of trees that were evaluated.
    """
    n_trees = floors.size
    for row in range(lo, hi):
        for column in range(is_open.shape[1]):
            score[row, column] = np.nan
            depth[row, column] = 0
            if not is_open[row, column]:
                continue
            base = row * stride * width + column * stride
            total = 0.0
            part = 0.0
            tree = 0
            while tree < n_trees:
                if restarts[tree]:
                    part = 0.0
                root = nodes[3 * tree]
                right = 1 if rectangle_sum(integral, base, root) >= root[8] else 0
                child = nodes[3 * tree + 1 + right]
                leaf = 2 * right
                if rectangle_sum(integral, base, child) >= child[8]:
                    leaf += 1
                confidence = leaves[4 * tree + leaf]
                total += confidence
                part += confidence
                tree += 1
                if part < floors[tree - 1]:
                    break
            else:
                score[row, column] = total
            depth[row, column] = tree


@compiled
def suppress(x, y, w, h, least_overlap, of_smaller, stays):
    """Mark the boxes that stay, of boxes in descending confidence.

    A box goes that overlaps one that stays by `least_overlap` or more, as a share of their union
    or, `of_smaller`, of the smaller one.
    """
    for i in range(x.size):
        stays[i] = True
        for j in range(i):
            if not stays[j]:
                continue
            shared = intersection(x[i], y[i], w[i], h[i], x[j], y[j], w[j], h[j])
            if shared <= 0.0:
                continue
            a, b = w[i] * h[i], w[j] * h[j]
            whole = min(a, b) if of_smaller else a + b - shared
            if shared >= least_overlap * whole:
                stays[i] = False
                break
