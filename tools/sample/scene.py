"""Parts of a recording: the road, people, vehicles and roadside objects.

Positions are metres in the world of a recording: x to the right of the car's lane centre, z along
the road from where the car starts.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from enum import Enum, auto
from typing import Final

from tools.sample.camera import FPS, Camera, Floats, travelled

_FARTHEST_M: Final = 260.0
"""Maximum distance of painted objects."""

Keys = tuple[tuple[float, float], ...]
"""Pairs of time in seconds and value, linear in between."""


@dataclass(frozen=True)
class Person:
    """Pedestrian or cyclist.

    Attributes
    ----------
    path
        Way points: time in seconds, x and z in metres.
    height_m
        Body height, standing.
    warmth
        Warmth of the clothed body in the far infrared, 0 (as cold as the night) to 1 (as skin).
    reflectance
        Share of near-infrared light that the clothes reflect, 0 to 1.
    facing_deg
        Direction in which a standing person looks: 0 along the road, 180 towards the car, 90 right.
    crouch, bend
        Amount from 0 to 1 over time.
    cyclist
        True for a person on a bicycle, who is annotated as an ignore region.
    """

    path: tuple[tuple[float, float, float], ...]
    height_m: float = 1.75
    warmth: float = 0.75
    reflectance: float = 0.5
    facing_deg: float = 180.0
    crouch: Keys = ((0.0, 0.0),)
    bend: Keys = ((0.0, 0.0),)
    cyclist: bool = False


@dataclass(frozen=True)
class Car:
    """Parked or moving vehicle. `z` is its middle.

    `heat` is the warmth of its engine from 0 to 1. `lights` is True if its headlamps dazzle the
    near-infrared camera.
    """

    x: float
    z: float
    speed: float = 0.0
    oncoming: bool = False
    heat: float = 0.0
    lights: bool = False
    height_m: float = 1.46
    length_m: float = 4.3
    width_m: float = 1.8
    tempt: float | None = None


@dataclass(frozen=True)
class Thing:
    """Roadside object.

    `kind` is one of tree, bush, lamp, pole, sign, post, cabinet, house, and in visible light also
    plate, a sign without a mast. `size_m` is its height, `width_m` and `depth_m` its extent if the
    kind does not determine it. `heat` runs from 0 to 1. `tempt` is how readily a system takes it
    for a pedestrian (log-odds at the best size), None for never. Hot objects tempt the far-infrared
    system, signs and posts the near-infrared one. `shows` is the text of a sign in visible light: a
    number, or ``"end"`` for a crossed-out sign.
    """

    kind: str
    x: float
    z: float
    size_m: float = 3.0
    width_m: float = 0.5
    depth_m: float = 0.5
    heat: float = 0.0
    tempt: float | None = None
    shows: str = ""


@dataclass(frozen=True)
class Road:
    """Cross-section of the road: edges in metres from the lane centre, positive to the right.

    The carriageway reaches from `left` to `right`. Next come parking strips and pavements (both 0
    in the country), then grass. `zebras` are the positions of pedestrian crossings.
    """

    left: float = -5.1
    right: float = 1.7
    parking_left: float = 0.0
    parking_right: float = 0.0
    pavement: float = 0.0
    zebras: tuple[float, ...] = ()


@dataclass(frozen=True)
class Climate:
    """Appearance of the night in the far infrared: grey levels of 0 to 255 before noise.

    `contrast` is the share of the usual difference between people and surroundings. It is lower on
    a warm summer night.
    """

    road: float = 82.0
    grass: float = 62.0
    sky: float = 20.0
    haze: float = 68.0
    things: float = 82.0
    skin: float = 236.0
    contrast: float = 1.0


@dataclass(frozen=True)
class Recording:
    """Recording: the drive, the place with its traffic context, and everybody in it."""

    name: str
    text: str
    speed: Keys
    people: tuple[Person, ...]
    road: Road = field(default_factory=Road)
    climate: Climate = field(default_factory=Climate)
    cars: tuple[Car, ...] = ()
    things: tuple[Thing, ...] = ()
    horizon: float = 236.0
    context: float = 0.0
    tags: tuple[str, ...] = ()

    @property
    def camera(self) -> Camera:
        """Return the camera of this recording."""
        return Camera(horizon=self.horizon)

    def way(self) -> Floats:
        """Return the position of the car along the road at every frame, metres."""
        return travelled(self.speed)


class Kind(Enum):
    """Kind of object that stands on the ground."""

    THING = auto()
    CAR = auto()
    PERSON = auto()


def far_first(
    recording: Recording, bodies: Sequence[Floats], frame: int
) -> Iterator[tuple[Kind, int, float]]:
    """Yield the objects on the ground in painting order: kind, index, metres ahead.

    Parameters
    ----------
    bodies
        Joints of the people to paint, in the world, each of shape (joints, 3).
    """
    way = float(recording.way()[frame])
    # Houses stand behind everything that they overlap in the image, so they come first.
    depths = [
        *(
            (thing.kind == "house", thing.z - way, Kind.THING, index)
            for index, thing in enumerate(recording.things)
        ),
        *(
            (False, car.z + car.speed * frame / FPS - way, Kind.CAR, index)
            for index, car in enumerate(recording.cars)
        ),
        *(
            (False, float(body[0, 2]) - way, Kind.PERSON, index)
            for index, body in enumerate(bodies)
        ),
    ]
    for _, depth, kind, index in sorted(depths, key=lambda entry: (not entry[0], -entry[1])):
        if depth <= _FARTHEST_M:
            yield kind, index, depth
