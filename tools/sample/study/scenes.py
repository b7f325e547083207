"""Pictures of the simulated study: streets at twilight with one pedestrian each.

Random values have wide ranges, so that the pedestrians differ in size, contrast, colour and
distance from the middle of the picture, where a subject looks first.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Final

import cv2
import numpy as np
import pandas as pd
from numpy.typing import NDArray

from tools.sample.places import COUNTRY, TOWN, country_things, town_things
from tools.sample.scene import Car, Person, Recording
from tools.sample.truth import sightings
from tools.sample.visible.light import Glow
from tools.sample.visible.render import Drive
from tools.sample.visible.sensor import Sensor
from tools.sample.visible.view import View, mapped_boxes
from tools.sample.visible.wardrobe import COATS, TROUSERS, Outfit, outfit

N_PICTURES: Final = 51
FOLDER: Final = "study"
BOXES_FILE: Final = "boxes.csv"
SIZE: Final = (960, 540)
FIXATION: Final = (480.0, 270.0)
"""Position of the cross at which a subject looks before the picture comes: the middle."""
PEDESTRIAN: Final = 1

_JPEG_QUALITY: Final = 75
_NOISE: Final = 0.6
_MARGIN_PX: Final = 6.0
_MAX_HIDDEN: Final = 0.02
_NEAR_M: Final = 10.5
_FAR_M: Final = 62.0
_SEED: Final = 51


@dataclass(frozen=True)
class Scene:
    """Picture of the study.

    Attributes
    ----------
    frame
        Frame of the recording to show, which determines the step of a walking person.
    """

    number: int
    recording: Recording
    glow: Glow
    wears: Outfit
    frame: int

    @property
    def image(self) -> str:
        """File name."""
        return f"study_{self.number:02d}.jpg"

    @property
    def view(self) -> View:
        """Camera with a wider view than that of the recordings."""
        return View(self.recording.camera, *SIZE, scale=1.0, dx=160.0, dy=30.0)

    def box(self) -> tuple[float, float, float, float]:
        """Box of the pedestrian: x, y, w, h in pixels."""
        edges = sightings(self.recording)[0].edges[self.frame : self.frame + 1]
        x, y, w, h = mapped_boxes(self.view, edges)[0]
        return float(x), float(y), float(w), float(h)

    def pictures(self) -> tuple[NDArray[np.uint8], NDArray[np.uint8]]:
        """Return the picture, and the same street at the same moment without the pedestrian.

        Returns
        -------
        RGB, shape (540, 960, 3) each.
        """
        drive = Drive(self.recording, self.glow, self.view, last_frame=self.frame)
        # Two sensors with the same seed have the same noise.
        shown, street = (
            Sensor(self.number, self.view, noise=_NOISE).read(drive.frame(self.frame, outfits))
            for outfits in ([self.wears], [])
        )
        return shown, street


def all_scenes() -> Iterator[Scene]:
    """Yield the scenes of the study, the same on every call."""
    for number in range(1, N_PICTURES + 1):
        generator = np.random.default_rng([_SEED, number])
        scene = _scene(number, generator)
        while not _is_fit(scene):
            scene = _scene(number, generator)
        yield scene


def boxes_table(scenes: list[Scene]) -> pd.DataFrame:
    """Return box of the pedestrian and point of fixation per picture, pixels."""
    rows = [(scene.image, PEDESTRIAN, *scene.box(), *FIXATION) for scene in scenes]
    names = ["image", "pedestrian", "x", "y", "w", "h", "fixation_x", "fixation_y"]
    return pd.DataFrame(rows, columns=names)


def jpeg(picture: NDArray[np.uint8]) -> bytes:
    """Return a picture as the bytes of a JPEG file."""
    options = [cv2.IMWRITE_JPEG_QUALITY, _JPEG_QUALITY, cv2.IMWRITE_JPEG_OPTIMIZE, 1]
    done, data = cv2.imencode(".jpg", cv2.cvtColor(picture, cv2.COLOR_RGB2BGR), options)
    assert done
    return data.tobytes()


def _scene(number: int, generator: np.random.Generator) -> Scene:
    in_town = bool(generator.random() < 0.62)
    z = float(np.exp(generator.uniform(np.log(_NEAR_M), np.log(_FAR_M))))
    person = _person(generator, z, in_town=in_town)
    cars = _cars(generator, z) if in_town else ()
    recording = Recording(
        name=f"study {number}",
        text="",
        speed=((0, 0), (15, 0)),
        people=(person,),
        road=TOWN if in_town else COUNTRY,
        cars=cars,
        things=town_things(100 + number, 160.0) if in_town else country_things(100 + number, 180.0),
        horizon=float(generator.uniform(232.0, 240.0)),
    )
    glow = Glow(
        sky_lux=float(np.exp(generator.uniform(np.log(2.0), np.log(12.0)))),
        lamp_cd=float(generator.choice([0.0, 250.0, 620.0, 620.0])) if in_town else 0.0,
        headlamp_cd=float(generator.choice([0.0, 5000.0, 15_000.0])),
        warmth=float(generator.uniform(0.0, 1.0)),
    )
    coat = str(generator.choice(list(COATS)))
    trousers = str(generator.choice(list(TROUSERS)))
    wears = outfit(f"study {number}", 0.5, coat, trousers)
    return Scene(number, recording, glow, wears, int(generator.integers(4, 40)))


def _person(generator: np.random.Generator, z: float, *, in_town: bool) -> Person:
    """Place a person on a pavement, on the shoulder, in a field or crossing the road."""
    places = (
        ((3.9, 6.2), (-9.6, -7.3), (-5.0, 1.8))
        if in_town
        else ((1.9, 4.0), (-8.0, -5.4), (-5.0, 1.6), (4.0, 14.0), (-16.0, -8.0))
    )
    low, high = places[int(generator.integers(len(places)))]
    x = float(generator.uniform(low, high))
    speed = float(generator.choice([0.0, 0.9, 1.3]))
    across = -5.2 < x < 1.9 or generator.random() < 0.25
    way = float(generator.choice([-1.0, 1.0])) * speed * 15
    end = (x + way, z) if across else (x, z + way)
    return Person(
        ((0.0, x, z), (15.0, *end)),
        height_m=float(np.clip(generator.normal(1.72, 0.09), 1.25, 1.95)),
        facing_deg=float(generator.uniform(0.0, 360.0)),
    )


def _cars(generator: np.random.Generator, z: float) -> tuple[Car, ...]:
    """Return parked cars on both sides, in some scenes only."""
    cars = []
    for x, oncoming in ((2.85, False), (-6.2, True)):
        place = float(generator.uniform(8.0, 20.0))
        while place < 110.0:
            if generator.random() < 0.45 and abs(place - z) > 4.0:
                car = Car(x, round(place, 1), oncoming=oncoming)
                is_van = generator.random() < 0.2
                cars.append(replace(car, height_m=1.9, length_m=5.0) if is_van else car)
            place += float(generator.uniform(6.5, 16.0))
    return tuple(cars)


def _is_fit(scene: Scene) -> bool:
    """True if the pedestrian is whole, in the picture, and unoccluded."""
    sighting = sightings(scene.recording)[0]
    if sighting.hidden[scene.frame] > _MAX_HIDDEN or sighting.depth_m[scene.frame] < 2.0:
        return False
    x, y, w, h = scene.box()
    return bool(
        x > _MARGIN_PX
        and y > _MARGIN_PX
        and x + w < SIZE[0] - _MARGIN_PX
        and y + h < SIZE[1] - _MARGIN_PX
        and h >= 22.0
    )
