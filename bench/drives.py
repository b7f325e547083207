"""Second generator of drives for `bench.claims`, written without knowledge of the first.

Pedestrians approach and grow. Misses persist, and depend on size, occlusion, and on effects of the
recording, the pedestrian, and the system in a recording. False alarms persist at places that may
attract both systems. Scores of hits and false alarms overlap.
"""

from __future__ import annotations

from typing import Final, Literal, NamedTuple

import numpy as np
import pandas as pd

from nvcore.dataset import Dataset
from nvcore.dataset.tables import dataset_from_tables

WIDTH: Final = 640
HEIGHT: Final = 480

Kind = Literal["equal", "thresholds", "half"]
"""Equal systems, equal systems at different thresholds, or Y with half of its runs of misses."""


class Boxes(NamedTuple):
    """Boxes of the truth (system -1), or detections of both systems (0 X, 1 Y).

    `box`: x, y, w, h in px, shape (4, n_boxes). `score`: logit, NaN for truth. `frame`: from 0
    within the recording.
    """

    recording: np.ndarray
    frame: np.ndarray
    box: np.ndarray
    score: np.ndarray
    system: np.ndarray


def draw_drives(kind: Kind, n: int, rng: np.random.Generator, *, effect: float = 0.0) -> Dataset:
    """Draw recordings of 40 to 80 frames with about eight pedestrians each, and X and Y.

    Parameters
    ----------
    effect
        By how much Y misses less than X, in logits of the miss rate.
    """
    n_frames = rng.integers(40, 81, n)
    frame = np.arange(n_frames.max())
    n_tracks = np.maximum(rng.poisson(8, n), 1)
    recording = np.repeat(np.arange(n), n_tracks)
    track = np.arange(len(recording)) - np.repeat(np.cumsum(n_tracks) - n_tracks, n_tracks)
    is_there, boxes = _walk(frame, n_frames[recording], recording, n, rng)
    is_missed, score = _look(boxes[3], recording, n, rng, effect)
    alarms = _alarm(n_frames, rng)
    cut = np.full(2, rng.uniform(0.26, 0.34))
    if kind == "thresholds":
        cut = rng.permutation([rng.uniform(0.17, 0.23), rng.uniform(0.38, 0.48)])
    cut = np.log(cut / (1 - cut))
    is_missed = (is_missed | (score < cut[:, None, None])) & is_there
    if kind == "half":
        of_y = is_missed[1]
        begins = of_y & ~np.pad(of_y, ((0, 0), (1, 0)))[:, :-1]
        is_missed[1] = of_y & _held(rng.random(of_y.shape) < 0.5, begins)
        score[1] = np.where(of_y, cut[1] + np.abs(score[1] - cut[1]), score[1])
    pedestrian, at = np.nonzero(is_there)
    truth = Boxes(
        *(recording[pedestrian], at, boxes[:, pedestrian, at], np.full(len(at), np.nan)),
        np.full(len(at), -1),
    )
    system, of_hit, at = np.nonzero(is_there & ~is_missed)
    hit_boxes = _moved(boxes[:, of_hit, at], rng)
    hits = Boxes(recording[of_hit], at, hit_boxes, score[system, of_hit, at], system)
    is_kept = (alarms.score >= cut[alarms.system]) & (alarms.frame < n_frames[alarms.recording])
    shown_alarms = Boxes(*(column[..., is_kept] for column in alarms))
    return _dataset(n_frames, truth, track[pedestrian], hits, shown_alarms)


def _walk(
    frame: np.ndarray, n_frames: np.ndarray, recording: np.ndarray, n: int, rng: np.random.Generator
) -> tuple[np.ndarray, np.ndarray]:
    """Return the presence of pedestrians, (n_tracks, n_frames), and their boxes, (4, ...)."""
    n_tracks = len(recording)
    length = np.minimum(rng.integers(12, 56, n_tracks), n_frames)
    start = rng.integers(0, n_frames - length + 1)[:, None]
    is_there = (frame >= start) & (frame < start + length[:, None])
    share = np.clip((frame - start) / length[:, None], 0, 1)
    first = np.exp(rng.uniform(np.log(30), np.log(85), n_tracks))[:, None]
    last = np.minimum(150, first * np.exp(rng.uniform(0.2, 1.5, n_tracks))[:, None])
    h = first * last / (last - (last - first) * share)  # 1 over a distance that falls evenly
    side = rng.uniform(-1, 1, n_tracks)[:, None] + rng.normal(0, 0.15, n_tracks)[:, None] * share
    x = np.clip(WIDTH / 2 + 280 * side * (h / last) ** 0.7 - 0.2 * h, 0, WIDTH - 0.4 * h)
    y = np.clip(200 + rng.normal(0, 6, n)[recording][:, None] + 0.7 * h, 0, HEIGHT - h)
    return is_there, np.stack([x, y, 0.4 * h, h])


def _look(
    h: np.ndarray, recording: np.ndarray, n: int, rng: np.random.Generator, effect: float
) -> tuple[np.ndarray, np.ndarray]:
    """Draw misses of both systems and the logits of their scores, (2, n_tracks, n_frames)."""
    shape = (2, *h.shape)
    is_hidden = _held(rng.random(h.shape) < 0.08, rng.random(h.shape) < 0.15)
    shared = rng.normal(0, 0.5, n)[recording] + rng.normal(0, 0.6, len(h))
    own = rng.normal(0, 0.5, (2, n))[:, recording] + rng.normal(0, 0.3, (2, len(h)))
    hard = (shared + own)[:, :, None] + 2.0 * is_hidden
    hard[1] -= effect
    size = np.log(h / 70)
    miss = 1 / (1 + np.exp(2.2 + 1.4 * size - hard))
    is_missed = _held(rng.random(shape) < miss, rng.random(shape) < 0.3)
    slow = _held(rng.normal(0, 0.6, shape), rng.random(shape) < 0.2)
    return is_missed, 1.1 + 0.8 * size - 0.35 * hard + slow + rng.normal(0, 0.45, shape)


def _alarm(n_frames: np.ndarray, rng: np.random.Generator) -> Boxes:
    """Draw false alarms, some after the last frame. Scores are logits."""
    n = len(n_frames)
    n_spots = rng.poisson(0.24 * rng.gamma(2.0, 0.5, n) * n_frames)
    recording = np.repeat(np.arange(n), n_spots)
    both = (2, len(recording))
    falls_for_it = rng.random(both) < rng.beta(1.6, 2.4, (2, n))[:, recording]
    start, length = rng.integers(0, n_frames[recording]), np.minimum(rng.geometric(0.25, both), 25)
    h = np.exp(rng.uniform(np.log(30), np.log(150), len(recording)))
    w = h * 0.4 * np.exp(rng.normal(0, 0.15, len(recording)))
    x, y = rng.uniform(0, WIDTH - w), rng.uniform(120, np.maximum(121, HEIGHT - h))
    drift = rng.normal(0, 1.5, both[1])
    tempting = rng.normal(-1.0, 0.5, both[1]) + rng.normal(0, 0.5, both)
    system, spot = np.nonzero(falls_for_it)
    lasts = length[system, spot]
    step = np.arange(lasts.sum()) - np.repeat(np.cumsum(lasts) - lasts, lasts)
    system, spot = np.repeat(system, lasts), np.repeat(spot, lasts)
    box = np.stack([x[spot] + drift[spot] * step, y[spot] + 0.3 * drift[spot] * step])
    box = _moved(np.concatenate([box, [w[spot], h[spot]]]), rng)
    score = tempting[system, spot] + rng.normal(0, 0.5, len(spot))
    return Boxes(recording[spot], start[spot] + step, box, score, system)


def _held(values: np.ndarray, is_new: np.ndarray) -> np.ndarray:
    """Return for each frame the value of the last new one."""
    frame = np.arange(is_new.shape[-1])
    latest = np.maximum.accumulate(np.where(is_new, frame, 0), axis=-1)
    return np.take_along_axis(values, latest, axis=-1)


def _moved(box: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """Return boxes that are shifted and resized by a few percent of their size."""
    x, y, w, h = box
    across, down, wider, taller = 0.03 * rng.standard_t(6, box.shape)
    new_w, new_h = w * np.exp(1.2 * wider), h * np.exp(taller)
    left, top = x + w / 2 + across * w - new_w / 2, y + h / 2 + down * h - new_h / 2
    return np.stack([left, top, new_w, new_h])


def _dataset(
    n_frames: np.ndarray, truth: Boxes, track: np.ndarray, hits: Boxes, alarms: Boxes
) -> Dataset:
    first = np.cumsum(n_frames) - n_frames
    tables = []
    for boxes in (truth, hits, alarms):
        x, y, w, h = boxes.box
        left, top = np.clip(x, 0, WIDTH - 2), np.clip(y, 0, HEIGHT - 2)
        columns = {
            "source": boxes.system + 1,
            "frame_index": first[boxes.recording] + boxes.frame,
            "x": left,
            "y": top,
            "w": np.maximum(np.minimum(x + w, WIDTH) - left, 2),
            "h": np.maximum(np.minimum(y + h, HEIGHT) - top, 2),
            "score": 1 / (1 + np.exp(-boxes.score)),
        }
        tables.append(pd.DataFrame(columns).assign(track=track if boxes is truth else -1))
    names = [f"r{number:02}" for number in range(len(n_frames))]
    recordings = pd.DataFrame({"name": names, "width": WIDTH, "height": HEIGHT, "fps": 10.0})
    boxes_of_all = pd.concat(tables, ignore_index=True)
    frames = [np.arange(length) for length in n_frames]
    return dataset_from_tables(recordings, frames, boxes_of_all, ["x", "y"], fingerprint="")
