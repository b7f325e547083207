"""Visible-light colour pictures of a recording."""

from __future__ import annotations

import zlib
from collections.abc import Iterator, Sequence

import numpy as np
from numpy.typing import NDArray

from tools.sample.body import joints
from tools.sample.camera import N_FRAMES, Floats
from tools.sample.scene import Kind, Recording, far_first
from tools.sample.visible.cars import draw_car
from tools.sample.visible.ground import Ground
from tools.sample.visible.light import Glow, lights_at
from tools.sample.visible.paint import Colours, Easel
from tools.sample.visible.people import draw_person
from tools.sample.visible.sensor import Sensor
from tools.sample.visible.sky import air, sky
from tools.sample.visible.stage import Stage
from tools.sample.visible.things import draw_thing
from tools.sample.visible.view import View
from tools.sample.visible.wardrobe import Outfit, outfit


class Drive:
    """Recording seen by the visible-light camera: luminances before exposure and noise."""

    def __init__(self, recording: Recording, glow: Glow, view: View, *, last_frame: int):
        self._recording, self._glow, self._view = recording, glow, view
        way = float(recording.way()[last_frame])
        self._ground = Ground(recording, lights_at(recording, glow, 0), view, length_m=way)
        self._backdrop, self._air = sky(recording, glow, view), air(glow)
        self._bodies = [joints(person) for person in recording.people]

    def frame(self, number: int, outfits: Sequence[Outfit]) -> Colours:
        """Return the luminances of one frame in cd/m2, shape (height, width, 3).

        Parameters
        ----------
        outfits
            Clothes of the people, in order. People without clothes in the list are left out.
        """
        picture = self._backdrop.copy()
        lights = lights_at(self._recording, self._glow, number)
        self._ground.paint(picture, lights, self._air)
        stage = Stage(Easel(picture, self._view), self._view, lights, self._air)
        bodies = [body[number] for body in self._bodies[: len(outfits)]]
        _stand(stage, self._recording, outfits, bodies, number)
        return picture


def visible_pictures(
    recording: Recording, glow: Glow, view: View | None = None, *, noise: float = 1.0
) -> Iterator[NDArray[np.uint8]]:
    """Yield RGB pictures of a recording in frame order, each of shape (height, width, 3)."""
    view = view or View(recording.camera)
    drive = Drive(recording, glow, view, last_frame=N_FRAMES - 1)
    sensor = Sensor(zlib.crc32(recording.name.encode()), view, noise=noise)
    outfits = [
        outfit(f"{recording.name} {index}", person.reflectance)
        for index, person in enumerate(recording.people)
    ]
    for frame in range(N_FRAMES):
        yield sensor.read(drive.frame(frame, outfits))


def _stand(
    stage: Stage, recording: Recording, outfits: Sequence[Outfit], bodies: list[Floats], frame: int
) -> None:
    """Paint everything that stands on the ground, far objects first."""
    way = stage.lights.way
    for kind, index, depth in far_first(recording, bodies, frame):
        if kind is Kind.THING:
            draw_thing(stage, recording.things[index], depth)
        elif kind is Kind.CAR:
            draw_car(stage, recording.cars[index], depth)
        else:
            body = bodies[index] - np.array([0.0, 0.0, way])
            draw_person(stage, recording.people[index], outfits[index], body)
