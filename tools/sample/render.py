"""Far-infrared pictures of a recording."""

from __future__ import annotations

import zlib
from collections.abc import Iterator
from typing import Final

import cv2
import numpy as np
from numpy.typing import NDArray

from tools.sample.backdrop import Ground, sky
from tools.sample.body import joints
from tools.sample.camera import HEIGHT, N_FRAMES, WIDTH, Floats
from tools.sample.canvas import Canvas, Picture
from tools.sample.objects import draw_thing
from tools.sample.people import draw_person
from tools.sample.scene import Kind, Recording, far_first
from tools.sample.vehicles import draw_car

_NOISE_FRAMES: Final = 7


def pictures(recording: Recording) -> Iterator[NDArray[np.uint8]]:
    """Yield grey pictures of a recording in frame order, each of shape (HEIGHT, WIDTH)."""
    ground, backdrop = Ground(recording), sky(recording)
    bodies = [joints(person) for person in recording.people]
    sensor = Sensor(zlib.crc32(recording.name.encode()))
    for frame in range(N_FRAMES):
        picture = backdrop.copy()
        ground.paint(picture, frame)
        _stand(picture, recording, bodies, frame)
        yield sensor.read(picture)


def _stand(picture: Picture, recording: Recording, bodies: list[Floats], frame: int) -> None:
    """Paint everything that stands on the ground, far objects first."""
    canvas, camera, climate = Canvas(picture), recording.camera, recording.climate
    way = float(recording.way()[frame])
    now = [body[frame] for body in bodies]
    for kind, index, depth in far_first(recording, now, frame):
        if kind is Kind.THING:
            draw_thing(canvas, recording.things[index], depth, camera, climate)
        elif kind is Kind.CAR:
            draw_car(canvas, recording.cars[index], depth, camera, climate)
        else:
            body = now[index] - np.array([0.0, 0.0, way])
            haze = float(np.exp(-max(depth, 0.0) / 330))
            draw_person(canvas, recording.people[index], body, camera, climate, haze)


class Sensor:
    """Lens and detector: blur, vignetting, edge overshoot, fixed pattern and noise."""

    def __init__(self, seed: int):
        generator = np.random.default_rng([17, seed])
        y, x = np.mgrid[0:HEIGHT, 0:WIDTH]
        off = np.hypot((x - WIDTH / 2) / (WIDTH / 2), (y - HEIGHT / 2) / (WIDTH / 2))
        self._gain = (1.0 - 0.17 * off**2.2).astype(np.float32)
        columns = generator.normal(0, 0.55, (1, WIDTH))
        self._pattern = (generator.normal(0, 0.7, (HEIGHT, WIDTH)) + columns).astype(np.float32)
        self._noise = generator.normal(0, 1.25, (_NOISE_FRAMES, HEIGHT, WIDTH)).astype(np.float32)
        self._order = generator

    def read(self, scene: Picture) -> NDArray[np.uint8]:
        """Return an 8-bit picture from a scene with grey levels of 0 to 255."""
        sharp = cv2.GaussianBlur(scene, (0, 0), 0.75)
        # Image processing in the camera: slight local contrast, which rings at hot edges.
        wide = cv2.GaussianBlur(
            cv2.resize(sharp, None, fx=0.25, fy=0.25, interpolation=cv2.INTER_AREA), (0, 0), 2.2
        )
        wide = cv2.resize(wide, (WIDTH, HEIGHT), interpolation=cv2.INTER_LINEAR)
        picture = (1.1 * sharp + 0.17 * (sharp - wide)) * self._gain
        shift = self._order.integers(0, (HEIGHT, WIDTH))
        index = int(self._order.integers(_NOISE_FRAMES))
        picture += np.roll(self._noise[index], (int(shift[0]), int(shift[1])), axis=(0, 1))
        picture += self._pattern
        return np.asarray(np.clip(np.round(picture), 0, 255), dtype=np.uint8)
