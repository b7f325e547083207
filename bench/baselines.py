"""Hand-written baselines: a numpy loop over the frames, and scipy's Hausdorff distance.

    python -m bench.baselines NAME SET.npz [--repeat 3]

Each baseline does part of the work of `analyse`, and its results are checked against ours:

- ``numpy loop``: per frame and system the greedy matching by IoU, both weighted distances and the
  similarity. No encounters, saliency, episodes or Venn categories.
- ``scipy hausdorff``: per frame and system `scipy.spatial.distance.directed_hausdorff` both ways
  over the lateral positions. No weights, borders or matching.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable
from pathlib import Path

import numpy as np
from scipy.spatial.distance import directed_hausdorff

from bench.measure import measure, report, versions
from bench.ours import to_dataset
from bench.sets import HEIGHT, WIDTH, Boxes, BoxSet, load_set
from nvcore.comparison.compare import Result, compare
from nvcore.settings.params import MIDPOINT_SHARE, SPREAD_SHARE, Params

Figures = list[dict[str, np.ndarray]]


def numpy_loop(boxes: BoxSet) -> Figures:
    """Compute matched pedestrians and similarity of every frame for both systems."""
    params = Params()
    n = boxes.n_frames
    g, g_at = boxes.truth, boxes.truth.offsets(n)
    figures = []
    for system in boxes.systems:
        s_at = system.offsets(n)
        matched, similarity = np.zeros(n, np.int64), np.empty(n)
        for f in range(n):  # the loop is the point of this baseline
            rows, detections = slice(g_at[f], g_at[f + 1]), slice(s_at[f], s_at[f + 1])
            matched[f] = _match(g, rows, system, detections, params.iou)
            miss = _maximin(g, rows, system, detections)
            false = _maximin(system, detections, g, rows)
            effect = params.alpha * miss + (1 - params.alpha) * false
            similarity[f] = 1 - effect / (WIDTH / 2)
        figures.append({"matched": matched, "similarity": similarity})
    return figures


def _match(g: Boxes, rows: slice, s: Boxes, detections: slice, least: float) -> int:
    gx, gy, gw, gh = g.x[rows], g.y[rows], g.w[rows], g.h[rows]
    sx, sy = s.x[detections, None], s.y[detections, None]
    sw, sh = s.w[detections, None], s.h[detections, None]
    if not len(gx) or not len(sx):
        return 0
    across = np.minimum(sx + sw, gx + gw) - np.maximum(sx, gx)
    down = np.minimum(sy + sh, gy + gh) - np.maximum(sy, gy)
    shared = np.maximum(across, 0) * np.maximum(down, 0)
    iou = shared / (sw * sh + gw * gh - shared)
    n_matched = 0
    for d in np.argsort(-s.score[detections], kind="stable"):
        best = iou[d].argmax()
        if iou[d, best] >= least:
            iou[:, best] = -1
            n_matched += 1
    return n_matched


def _maximin(a: Boxes, rows: slice, b: Boxes, others: slice) -> float:
    x, w, h = a.x[rows], a.w[rows], a.h[rows]
    if not len(x):
        return 0.0
    centre = np.clip(x + 0.5 * w, 0, WIDTH)
    k = 1 / (1 + np.exp(-(h - MIDPOINT_SHARE * HEIGHT) / (SPREAD_SHARE * HEIGHT)))
    least = np.minimum(centre, WIDTH - centre)
    if others.stop > others.start:
        other = np.clip(b.x[others] + 0.5 * b.w[others], 0, WIDTH)
        least = np.minimum(least, np.abs(centre[:, None] - other).min(axis=1))
    return float((k * least).max())


def scipy_hausdorff(boxes: BoxSet) -> Figures:
    """Compute the largest distance to the nearest member of the other set, both ways, per system.

    NaN if a set is empty.
    """
    n = boxes.n_frames
    centre = [np.clip(b.x + 0.5 * b.w, 0, WIDTH)[:, None] for b in (boxes.truth, *boxes.systems)]
    offsets = [b.offsets(n) for b in (boxes.truth, *boxes.systems)]
    figures = []
    for source in (1, 2):
        miss, false = np.full(n, np.nan), np.full(n, np.nan)
        for f in range(n):  # the loop is the point of this baseline
            truth = centre[0][offsets[0][f] : offsets[0][f + 1]]
            system = centre[source][offsets[source][f] : offsets[source][f + 1]]
            if len(truth) and len(system):
                miss[f] = directed_hausdorff(truth, system)[0]
                false[f] = directed_hausdorff(system, truth)[0]
        figures.append({"miss": miss, "false": false})
    return figures


def _ours_for_numpy_loop(result: Result) -> Figures:
    return [{"matched": s.matched, "similarity": s.similarity} for s in (result.x, result.y)]


def _ours_for_hausdorff(result: Result) -> Figures:
    n = len(result.n_truth)
    figures = []
    for system in (result.x, result.y):
        both = (result.n_truth > 0) & (system.n_det > 0)
        truth, detections = result.dataset.truth, result.dataset.system(system.name)
        miss = _largest(truth.frame_index, system.nearest.truth, n)
        false = _largest(detections.frame_index, system.nearest.detections, n)
        figures.append(
            {"miss": np.where(both, miss, np.nan), "false": np.where(both, false, np.nan)}
        )
    return figures


def _largest(frame_index: np.ndarray, values: np.ndarray, n: int) -> np.ndarray:
    largest = np.zeros(n)
    np.maximum.at(largest, frame_index, values)
    return largest


BASELINES: dict[str, tuple[Callable[[BoxSet], Figures], Callable[[Result], Figures]]] = {
    "numpy loop": (numpy_loop, _ours_for_numpy_loop),
    "scipy hausdorff": (scipy_hausdorff, _ours_for_hausdorff),
}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("name", choices=sorted(BASELINES))
    parser.add_argument("set", type=Path)
    parser.add_argument("--repeat", type=int, default=3)
    options = parser.parse_args()
    baseline, of_ours = BASELINES[options.name]
    boxes = load_set(options.set)
    figures, seconds, peak_mb = measure(lambda: baseline(boxes), options.repeat)
    expected = of_ours(compare(to_dataset(boxes)))
    off = 0.0
    for theirs, ours in zip(figures, expected, strict=True):
        for name, values in ours.items():
            np.testing.assert_allclose(values, theirs[name], rtol=0, atol=1e-9, err_msg=name)
            off = max(off, float(np.nanmax(np.abs(values - theirs[name]))))
    names = " and ".join(expected[0])
    report(
        seconds=seconds,
        peak_mb=peak_mb,
        agreement=f"{names} of every frame within {off:.0e}",
        versions=versions("numpy", "scipy"),
    )


if __name__ == "__main__":
    main()
