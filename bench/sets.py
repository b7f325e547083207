"""Synthetic sets: 4 truth boxes and about 4 + 4 detections per frame, with reproducible bytes.

Four lanes of pedestrians follow one another through each recording, so that every frame has exactly
four. A system sees a pedestrian late, drops it now and then, misses single frames, and raises false
alarms that stay for a while. Tracks, misses and false alarms have plausible lengths.

    python -m bench.sets N SET.npz [--coco]

This module makes only arrays and imports only numpy, so that other tools' environments can read
them. `bench.ours` converts them to a dataset.
"""

from __future__ import annotations

import argparse
from dataclasses import dataclass
from pathlib import Path

import numpy as np

WIDTH, HEIGHT, FPS = 640, 480, 20.0
FRAMES_PER_RECORDING = 1_000
LANES = 4
MEAN_TRACK = 80  # frames
FOCAL = 800.0  # px
BODY = 1.75  # m
SEED = 20110360
MOST_IN_PICTURE = 100  # detections of a picture that COCO counts

COLUMNS = ("x", "y", "w", "h", "score", "track", "frame_index")


@dataclass(frozen=True)
class Boxes:
    """Boxes of one source, sorted by frame, in px, 0-based.

    A detection has its pedestrian's track, a false alarm its own, as from a perfect tracker. Tools
    that score trackers need one.
    """

    x: np.ndarray
    y: np.ndarray
    w: np.ndarray
    h: np.ndarray
    score: np.ndarray
    track: np.ndarray
    frame_index: np.ndarray

    def __len__(self) -> int:
        return len(self.x)

    def offsets(self, n_frames: int) -> np.ndarray:
        """Return offsets such that the boxes of frame f are ``offsets[f]:offsets[f + 1]``."""
        counts = np.bincount(self.frame_index, minlength=n_frames)
        return np.concatenate([[0], np.cumsum(counts)]).astype(np.int64)


@dataclass(frozen=True)
class BoxSet:
    """Truth and two systems over `n_frames` frames, in recordings of 1,000."""

    n_frames: int
    truth: Boxes
    systems: tuple[Boxes, Boxes]

    @property
    def lengths(self) -> np.ndarray:
        """Return the number of frames of each recording."""
        return recording_lengths(self.n_frames)


def recording_lengths(n_frames: int) -> np.ndarray:
    n_whole, n_left = divmod(n_frames, FRAMES_PER_RECORDING)
    return np.array([FRAMES_PER_RECORDING] * n_whole + [n_left] * (n_left > 0), np.int64)


def make_set(n_frames: int) -> BoxSet:
    """Return the set of `n_frames` frames, with a fixed seed."""
    rng = np.random.default_rng([SEED, n_frames])
    truth, lane_track, age = draw_walkers(recording_lengths(n_frames), rng)
    # X sees far and raises more false alarms, Y starts late and drops more
    x = draw_detections(truth, lane_track, age, rng, late=3.0, drop=0.06, clutter=0.42)
    y = draw_detections(truth, lane_track, age, rng, late=9.0, drop=0.08, clutter=0.50)
    return BoxSet(n_frames, truth, (x, y))


def draw_walkers(
    lengths: np.ndarray, rng: np.random.Generator
) -> tuple[Boxes, np.ndarray, np.ndarray]:
    """Draw the truth, and the overall track number and the age in frames of every box.

    `lengths` are the frames of each recording.
    """
    n_frames = int(lengths.sum())
    frame = np.arange(n_frames)
    starts = rng.random((n_frames, LANES)) < 1 / MEAN_TRACK
    starts[np.cumsum(lengths) - lengths] = True
    by_lane = starts.T  # numbered lane by lane, because the tracks of one lane follow one another
    number = np.cumsum(by_lane.ravel()).reshape(LANES, n_frames).T - 1
    first = np.flatnonzero(by_lane.ravel()) % n_frames
    age = (frame[:, None] - first[number]).ravel()
    number = number.ravel()
    n_tracks = len(first)
    time_s = age / FPS
    far_m = rng.uniform(30, 80, n_tracks)[number]
    distance = np.maximum(far_m - rng.uniform(4, 14, n_tracks)[number] * time_s, 8)
    side_m = rng.uniform(-6, 6, n_tracks)[number]
    side_m += rng.uniform(-1.4, 1.4, n_tracks)[number] * time_s
    h = FOCAL * BODY / distance
    w = h * rng.uniform(0.34, 0.5, n_tracks)[number]
    centre = np.clip(WIDTH / 2 + FOCAL * side_m / distance, 5, WIDTH - 5)
    foot = np.minimum(200 + FOCAL * 1.2 / distance, HEIGHT - 1)
    boxes = Boxes(
        x=centre - w / 2,
        y=foot - h,
        w=w,
        h=h,
        score=np.ones(len(h)),
        track=number.astype(np.int64),
        frame_index=np.repeat(frame, LANES),
    )
    return boxes, number, age


def draw_detections(
    truth: Boxes,
    number: np.ndarray,
    age: np.ndarray,
    rng: np.random.Generator,
    *,
    late: float,
    drop: float,
    clutter: float,
) -> Boxes:
    """Draw detections of one system: seen pedestrians, and false alarms.

    `late` is the mean onset in frames, `drop` the share of lost spells of 8 frames, `clutter` the
    mean number of false alarms per frame.
    """
    n_frames = int(truth.frame_index[-1]) + 1
    onset = rng.exponential(late, number.max() + 1)[number]
    spell = truth.frame_index // 8 * LANES + np.tile(np.arange(LANES), n_frames)
    is_lost = (rng.random(spell.max() + 1) < drop)[spell]
    detected = np.flatnonzero((age >= onset) & ~is_lost & (rng.random(len(truth)) > 0.02))
    h = truth.h[detected] * np.exp(rng.normal(0, 0.05, len(detected)))
    w = truth.w[detected] * np.exp(rng.normal(0, 0.08, len(detected)))
    centre = truth.x[detected] + truth.w[detected] / 2 + rng.normal(0, 0.05, len(detected)) * h
    foot = truth.y[detected] + truth.h[detected] + rng.normal(0, 0.04, len(detected)) * h
    score = 0.35 + 0.65 * rng.beta(4, 1.5, len(detected))
    # spells of clutter of 12 frames at one place
    alarm_spell = np.arange(n_frames) // 12
    n_spells = int(alarm_spell[-1]) + 1
    alarms = np.flatnonzero((rng.random(n_spells) < clutter)[alarm_spell])
    spell = alarm_spell[alarms]
    alarm_h = rng.uniform(20, 90, n_spells)[spell]
    alarm_x = rng.uniform(0, WIDTH - 40, n_spells)[spell] + rng.normal(0, 1, len(alarms))
    alarm_y = rng.uniform(150, 300, n_spells)[spell]
    alarm_score = 0.05 + 0.75 * rng.beta(1.5, 2.5, len(alarms))
    frame = np.concatenate([truth.frame_index[detected], alarms])
    order = np.argsort(frame, kind="stable")
    columns = {
        "x": (centre - w / 2, alarm_x),
        "y": (foot - h, alarm_y),
        "w": (w, 0.42 * alarm_h),
        "h": (h, alarm_h),
        "score": (score, alarm_score),
    }
    return Boxes(
        **{name: np.concatenate(both)[order] for name, both in columns.items()},
        track=np.concatenate([truth.track[detected], truth.track.max() + 1 + spell])[order],
        frame_index=frame[order],
    )


def make_coco_shaped(n_images: int) -> BoxSet:
    """Draw pictures like COCO's: few pedestrians, and 100 detections with mostly low scores.

    Pictures are unrelated, so nobody is seen twice.
    """
    rng = np.random.default_rng([SEED, n_images, 2])
    n_truth = rng.poisson(7, n_images)
    truth = _scattered(np.repeat(np.arange(n_images), n_truth), rng)
    systems = []
    for recall in (0.75, 0.65):
        seen = np.flatnonzero(rng.random(len(truth)) < recall)
        frame = np.concatenate([truth.frame_index[seen], np.repeat(np.arange(n_images), 100)])
        clutter = _scattered(frame[len(seen) :], rng)
        moved = truth.h[seen] * rng.normal(0, 0.05, (2, len(seen)))
        columns = {
            "x": (truth.x[seen] + moved[0], clutter.x),
            "y": (truth.y[seen] + moved[1], clutter.y),
            "w": (truth.w[seen] * np.exp(rng.normal(0, 0.08, len(seen))), clutter.w),
            "h": (truth.h[seen] * np.exp(rng.normal(0, 0.05, len(seen))), clutter.h),
            "score": (rng.beta(4, 1.5, len(seen)), 0.5 * rng.beta(1, 6, len(clutter))),
        }
        joined = {name: np.concatenate(both) for name, both in columns.items()}
        by_score = np.lexsort((-joined["score"], frame))
        rank = np.arange(len(frame)) - np.searchsorted(frame[by_score], frame[by_score])
        best = by_score[rank < MOST_IN_PICTURE]  # as detectors write their results
        systems.append(
            Boxes(
                **{name: column[best] for name, column in joined.items()},
                track=np.arange(len(best)),
                frame_index=frame[best],
            )
        )
    return BoxSet(n_images, truth, (systems[0], systems[1]))


def _scattered(frame: np.ndarray, rng: np.random.Generator) -> Boxes:
    """Draw boxes anywhere in their pictures, most of them small."""
    n = len(frame)
    h = np.exp(rng.uniform(np.log(15), np.log(300), n))
    w = h * rng.uniform(0.3, 0.6, n)
    return Boxes(
        x=rng.uniform(0, WIDTH, n) * (1 - w / WIDTH),
        y=rng.uniform(0, HEIGHT, n) * (1 - h / HEIGHT),
        w=w,
        h=h,
        score=np.ones(n),
        track=np.arange(n),
        frame_index=frame,
    )


def save_set(boxes: BoxSet, path: Path) -> None:
    """Write a set as .npz, for `load_set` in any environment."""
    columns = {"n_frames": np.array(boxes.n_frames)}
    for prefix, source in zip("gxy", (boxes.truth, *boxes.systems), strict=True):
        columns.update({f"{prefix}_{name}": getattr(source, name) for name in COLUMNS})
    np.savez(path, **columns)


def load_set(path: Path) -> BoxSet:
    """Read a file of `save_set`."""
    with np.load(path) as file:
        truth, x, y = (Boxes(*(file[f"{prefix}_{name}"] for name in COLUMNS)) for prefix in "gxy")
        return BoxSet(int(file["n_frames"]), truth, (x, y))


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("n_frames", type=int)
    parser.add_argument("path", type=Path)
    parser.add_argument("--coco", action="store_true", help="pictures shaped as those of COCO")
    options = parser.parse_args()
    make = make_coco_shaped if options.coco else make_set
    save_set(make(options.n_frames), options.path)


if __name__ == "__main__":
    main()
