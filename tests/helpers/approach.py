"""Pedestrians that a car drives up to at constant speed: one over their height is a line."""

from __future__ import annotations

from collections.abc import Iterable

from builders import Box, Place, make_dataset, result_of

from nvcore.comparison.compare import Result

HEIGHT_PX_S = 50.0
"""Height of a box times the time to contact: 50 px are one second away."""


def approach(
    frames: Iterable[int],
    contact_s: float,
    *,
    fps: float = 10.0,
    centre: float = 50.0,
    track: int = 1,
    recording: int = 0,
    score: float = 1.0,
) -> list[Box]:
    """The boxes of a pedestrian who is reached `contact_s` after frame 0, around row 50."""
    boxes = []
    for frame in frames:
        h = HEIGHT_PX_S / (contact_s - frame / fps)
        w = min(0.4 * h, 10.0)
        corner = centre - w / 2, 50 - h / 2
        boxes.append(Box(frame, *corner, w, h, track, score, recording=recording))
    return boxes


def only(boxes: Iterable[Box], frames: Iterable[int]) -> list[Box]:
    """The boxes of these frames, as detections."""
    listed = set(frames)
    return [box for box in boxes if box.frame in listed]


PLACE = Place(range(40), horizon=40.0)
"""Four seconds at ten frames a second."""

# At 50 km/h and with contact after 5 s the last chance is frame 29, 2.1 s before contact.
ALL, LATE, NEVER = range(40), range(30, 40), range(0)


def met(*sides: tuple[range, range], **params: float) -> Result:
    """A pedestrian in each recording, matched by X and Y in these frames."""
    truth, x, y = [], [], []
    for recording, (by_x, by_y) in enumerate(sides):
        boxes = approach(range(40), 5, recording=recording)
        truth += boxes
        x += only(boxes, by_x)
        y += only(boxes, by_y)
    return result_of(make_dataset(truth, x, y, places=[PLACE] * len(sides)), **params)
