"""Random scenes of several recordings, for tests against the oracle and of invariances."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from builders import NAN, Box, Place, at, make_dataset, result_of

from nvcore.comparison.compare import Result
from nvcore.dataset import Dataset


@dataclass
class Scene:
    """Recordings, and the boxes of truth, X and Y."""

    places: list[Place]
    truth: list[Box]
    x: list[Box]
    y: list[Box]

    def dataset(self) -> Dataset:
        return make_dataset(self.truth, self.x, self.y, places=self.places)

    def by_frame(self, boxes: list[Box], recording: int) -> list[list[Box]]:
        """Boxes of every listed frame of one recording, file order kept."""
        return [
            [b for b in boxes if b.recording == recording and b.frame == frame]
            for frame in self.places[recording].frames
        ]


def draw_scene(
    seed: int, *, is_grid: bool = False, is_crowded: bool = False, has_tracks: bool = True
) -> Scene:
    """A scene with sampled frame lists, ignore regions, missing scores, tracks given twice.

    On a grid all coordinates and scores are small whole numbers, so that ties abound. A crowd has
    more boxes in a frame than the kernels' scratch memory holds at first (16).
    """
    rng = np.random.default_rng(seed)
    places = [_draw_place(rng) for _ in range(rng.integers(1, 4))]
    truth: list[Box] = []
    systems: tuple[list[Box], list[Box]] = ([], [])
    for number, place in enumerate(places):
        n_walkers = rng.integers(24, 33) if is_crowded else rng.integers(0, 4)
        walkers = [_draw_box(rng, place, is_grid) for _ in range(n_walkers)]
        for frame in place.frames:
            is_empty = rng.random() < 0.15
            for track, walker in enumerate([] if is_empty else walkers):
                if rng.random() < 0.2:
                    continue
                is_ignored = rng.random() < 0.15
                for _ in range(1 + (rng.random() < 0.05)):  # now and then a track twice
                    box = _moved(rng, walker, frame, number, is_grid)
                    given = track * 3 if has_tracks else -1
                    truth.append(box._replace(
                        track=given, ignore=is_ignored, occlusion=int(rng.integers(-1, 3)),
                        distance_m=NAN if rng.random() < 0.3 else float(rng.uniform(5, 80)),
                    ))  # fmt: skip
            for system in systems:
                for walker in walkers:
                    if rng.random() < 0.6:
                        box = _moved(rng, walker, frame, number, is_grid)
                        system.append(box._replace(score=_draw_score(rng)))
                if rng.random() < 0.3:
                    box = _draw_box(rng, place, is_grid)._replace(frame=frame, recording=number)
                    system.append(box._replace(
                        score=_draw_score(rng), distance_m=float(rng.uniform(5, 80)),
                    ))  # fmt: skip
    return Scene(places, truth, *systems)


def _draw_place(rng: np.random.Generator) -> Place:
    n = int(rng.integers(1, 9))
    listed = np.sort(rng.choice(np.arange(3, 40), n, replace=False))
    if rng.random() < 0.5:
        listed = np.arange(n) * int(rng.integers(1, 5))
    fps = float(rng.choice([7, 10, 20, 25, 30]))
    size = float(rng.choice([64, 100, 640])), float(rng.choice([50, 480]))
    context = (NAN, 0.0, 0.3, 1.0)[len(listed) % 4]
    return Place(listed.tolist(), *size, fps, horizon=0.4 * size[1], context=context)


def _draw_box(rng: np.random.Generator, place: Place, is_grid: bool) -> Box:
    w, h = rng.uniform(0.05, 0.2) * place.width, rng.uniform(0.02, 0.4) * place.height
    x, y = rng.uniform(-0.1, 1) * place.width, rng.uniform(0, 0.8) * place.height
    numbers = [x, y, max(w, 1), max(h, 1)]
    return Box(0, *(float(round(v)) for v in numbers)) if is_grid else Box(0, *numbers)


def _moved(rng: np.random.Generator, walker: Box, frame: int, recording: int, is_grid: bool) -> Box:
    dx, dy = rng.normal(0, 0.12 * walker.w), rng.normal(0, 0.08 * walker.h)
    dx, dy = (round(dx), round(dy)) if is_grid else (dx, dy)
    return walker._replace(
        frame=frame, recording=recording, x=walker.x + dx, y=walker.y + dy
    )  # fmt: skip


def _draw_score(rng: np.random.Generator) -> float:
    return NAN if rng.random() < 0.1 else float(rng.integers(0, 10)) / 10


def three_frames() -> Result:
    """Frame 0: tracks 1 (both find it) and 2 (only X). 1: nothing. 2: an ignore region."""
    truth = [at(0, 30, track=1), at(0, 60, track=2), at(2, 50, w=40, ignore=True)]
    x = [at(0, 30, score=0.9), at(0, 60, score=0.8), at(2, 50, score=0.7), at(2, 90, score=0.6)]
    y = [at(0, 30, score=0.9), at(0, 60, score=0.1)]
    return result_of(make_dataset(truth, x, y), threshold_y=0.5)
