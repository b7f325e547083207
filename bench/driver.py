"""Measure the time of the driver's features, against OpenCV calls for each box.

    python -m bench.driver [--frames 20] [--boxes 20] [--size 1920x1080]

Pictures are synthetic: patches of colour, noise, and the given number of boxes per frame, 40 to 400
px high (equal shares of each doubling). Decoding is not included. The plain way cuts out each box
and its surround and calls OpenCV for luminance, L*a*b*, Sobel and histograms. Its values must equal
ours. Ratios are of processor time and therefore valid on a busy machine. Boxes per second are of
wall-clock time.
"""

from __future__ import annotations

import argparse
import os
import statistics
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from time import perf_counter, thread_time

import cv2
import numpy as np

from nvcore.subjects.driver.features import features_of
from nvcore.subjects.driver.features.compute import regions_of

BINS = 16
LOWEST, HIGHEST, ASPECT = 40.0, 400.0, 0.41


def picture(rng: np.random.Generator, width: int, height: int) -> np.ndarray:
    """Draw patches of colour with noise."""
    patches = rng.integers(0, 256, (height // 30, width // 30, 3), dtype=np.uint8)
    large = cv2.resize(patches, (width, height), interpolation=cv2.INTER_CUBIC)
    noisy = large + rng.normal(0, 6, large.shape)
    return np.clip(noisy, 0, 255).astype(np.uint8)


def boxes_of(rng: np.random.Generator, n: int, width: int, height: int) -> np.ndarray:
    h = np.exp(rng.uniform(np.log(LOWEST), np.log(min(HIGHEST, height)), n))
    w = ASPECT * h
    return np.stack([rng.uniform(0, width - w), rng.uniform(0, height - h), w, h], axis=1)


def plain(rgb: np.ndarray, boxes: np.ndarray, fixation: tuple[float, float]) -> np.ndarray:
    """Compute the features with OpenCV calls, box by box."""
    height, width = rgb.shape[:2]
    regions = regions_of(boxes, width, height, 2.0)
    rows = []
    for box, inner, outer in zip(regions.box, regions.inner, regions.outer, strict=True):
        left, top, right, bottom = outer
        # one extra pixel on each side for the gradient
        x0, y0, x1, y1 = (
            max(left - 1, 0),
            max(top - 1, 0),
            min(right + 1, width),
            min(bottom + 1, height),
        )
        cut = rgb[y0:y1, x0:x1]
        own = slice(top - y0, bottom - y0), slice(left - x0, right - x0)
        inside = np.zeros((bottom - top, right - left), np.uint8)
        inside[inner[1] - top : inner[3] - top, inner[0] - left : inner[2] - left] = 255
        around = 255 - inside
        grey = cv2.cvtColor(cut, cv2.COLOR_RGB2GRAY)
        gx, gy = (
            cv2.Sobel(grey, cv2.CV_32F, dx, 1 - dx, borderType=cv2.BORDER_REPLICATE)[own]
            for dx in (1, 0)
        )
        strength = cv2.magnitude(gx, gy)
        grey, colours = grey[own], np.ascontiguousarray(cut[own])
        lab = cv2.cvtColor(colours.astype(np.float32) / 255, cv2.COLOR_RGB2Lab)
        mean, sd = cv2.meanStdDev(grey, mask=inside)
        work = 0.0
        for channel in range(3):
            shares = [
                cv2.calcHist([colours], [channel], mask, [BINS], [0, 256]).ravel()
                for mask in (inside, around)
            ]
            cdf_inside, cdf_around = (np.cumsum(share / share.sum()) for share in shares)
            work += float(np.abs(cdf_inside - cdf_around).sum())
        apart = np.subtract(cv2.mean(lab, inside)[:3], cv2.mean(lab, around)[:3])
        rows.append(
            [
                *(box[2], box[3], sd[0, 0], abs(mean[0, 0] - cv2.mean(grey, around)[0])),
                float(np.linalg.norm(apart)),
                abs(cv2.mean(strength, inside)[0] - cv2.mean(strength, around)[0]),
                work,
                float(
                    np.hypot(box[0] + box[2] / 2 - fixation[0], box[1] + box[3] / 2 - fixation[1])
                ),
            ]
        )
    return np.array(rows)


def processor_seconds(work: Callable[[], object], times: int = 3) -> float:
    """Return the minimum processor time of a few calls in this thread."""
    seconds = []
    for _ in range(times):
        start = thread_time()
        work()
        seconds.append(thread_time() - start)
    return min(seconds)


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--frames", type=int, default=20)
    parser.add_argument("--boxes", type=int, default=20)
    parser.add_argument("--size", default="1920x1080")
    options = parser.parse_args()
    width, height = map(int, options.size.split("x"))
    rng = np.random.default_rng(0)
    pictures = [picture(rng, width, height) for _ in range(min(5, options.frames))]
    frames = [
        (pictures[i % len(pictures)], boxes_of(rng, options.boxes, width, height))
        for i in range(options.frames)
    ]
    fixation = (width / 2, height / 2)
    cv2.setNumThreads(1)
    ours, others = [], []
    for rgb, boxes in frames:
        values = features_of(rgb, boxes, fixation)
        expected = plain(rgb, boxes, fixation)
        # OpenCV interpolates L*a*b* in a coarse grid of colours
        np.testing.assert_allclose(values, expected, rtol=0.02, atol=0.05)
        ours.append(processor_seconds(lambda r=rgb, b=boxes: features_of(r, b, fixation)))
        others.append(processor_seconds(lambda r=rgb, b=boxes: plain(r, b, fixation), times=1))
    n_boxes = options.boxes * len(frames)
    area = statistics.mean(float((boxes[:, 2] * boxes[:, 3]).mean()) for _, boxes in frames)
    print(
        f"{width}x{height}, {options.boxes} boxes a frame, of {area:,.0f} px on average: "
        f"{1000 * sum(ours) / n_boxes:.2f} ms of processor time a box, "
        f"{n_boxes / sum(ours):,.0f} boxes a second on one core; "
        f"by OpenCV calls for each box {sum(others) / sum(ours):.1f} times as long"
    )
    n_threads = os.cpu_count() or 1
    with ThreadPoolExecutor(n_threads) as pool:
        start = perf_counter()
        done = [pool.submit(features_of, rgb, boxes, fixation) for rgb, boxes in frames]
        for future in done:
            future.result()
        seconds = perf_counter() - start
    print(
        f"{n_threads} threads: {n_boxes / seconds:,.0f} boxes a second, "
        f"{len(frames) / seconds:.0f} frames a second, by the clock on the wall"
    )


if __name__ == "__main__":
    main()
