"""Ground truth of a recording: image position, distance and occlusion of every person."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from tools.sample.body import CAPSULES, WHEEL_M, joints, radii
from tools.sample.camera import HEIGHT, N_FRAMES, WIDTH, Camera, Floats, frame_times
from tools.sample.scene import Car, Person, Recording, Thing

MIN_HEIGHT_PX: Final = 8.0
MIN_INSIDE: Final = 0.5
MAX_HIDDEN: Final = 0.93
MIN_DEPTH_M: Final = 2.0
LIGHT_HIDDEN: Final = 0.1
HEAVY_HIDDEN: Final = 0.45

TRUTH_COLUMNS: Final = (
    *("recording", "frame", "x", "y", "w", "h"),
    *("track", "ignore", "distance_m", "occlusion"),
)
_GRID_X: Final = (np.arange(8) + 0.5) / 8
_GRID_Y: Final = (np.arange(16) + 0.5) / 16
_BLOCKING: Final = {"tree": 0.16, "bush": 0.9, "cabinet": 1.0, "house": 1.0}


@dataclass(frozen=True)
class Sighting:
    """One person as seen by the camera at every frame.

    Attributes
    ----------
    edges
        Left, top, right, bottom in pixels, unclipped, shape (frames, 4).
    depth_m
        Metres along the optical axis, shape (frames,).
    distance_m
        Metres over ground from the camera, shape (frames,).
    lateral_m
        Metres to the right of the camera, shape (frames,).
    hidden
        Share of the box that nearer objects cover, shape (frames,).
    inside
        Share of the box inside the picture, shape (frames,).
    annotated
        Frames that the truth lists, shape (frames,).
    """

    person: Person
    edges: Floats
    depth_m: Floats
    distance_m: Floats
    lateral_m: Floats
    hidden: Floats
    inside: Floats
    annotated: NDArray[np.bool_]


def body_edges(person: Person, world: Floats, camera: Camera) -> tuple[Floats, Floats]:
    """Return unclipped box edges of a person, and the depth, from joints relative to the car.

    Parameters
    ----------
    world
        Joints as in `tools.sample.body.joints`, minus the distance travelled by the car.
    """
    pixels, depth = camera.project(world)
    ends = np.array([[limb.a, limb.b] for limb in CAPSULES]).ravel()
    reach = radii(person).ravel()
    if person.cyclist:
        ends = np.concatenate([ends, [21, 22]])
        reach = np.concatenate([reach, [WHEEL_M, WHEEL_M]])
    ends_px, size = pixels[:, ends], camera.focal_px * reach / np.maximum(depth[:, ends], 0.1)
    low, high = ends_px - size[..., None], ends_px + size[..., None]
    edges = np.concatenate([low.min(axis=1), high.max(axis=1)], axis=1)
    return edges, depth[:, 0]


def sightings(recording: Recording) -> list[Sighting]:
    """Return every person of a recording as seen by the camera."""
    camera, way = recording.camera, recording.way()
    shift = np.stack([np.zeros_like(way), np.zeros_like(way), way], axis=1)
    bodies = [joints(person) - shift[:, None, :] for person in recording.people]
    visible = [
        body_edges(person, body, camera)
        for person, body in zip(recording.people, bodies, strict=True)
    ]
    solid = [_shrunk(edges) for edges, _ in visible]
    blockers = [(edges, depth) for edges, (_, depth) in zip(solid, visible, strict=True)]
    blockers += [_car_edges(car, camera, way) for car in recording.cars]
    blockers += [_thing_edges(t, camera, way) for t in recording.things if t.kind in _BLOCKING]
    seen_people = []
    for index, (person, body) in enumerate(zip(recording.people, bodies, strict=True)):
        edges, depth = visible[index]
        others = [blocker for place, blocker in enumerate(blockers) if place != index]
        seen_people.append(_sighting(person, body, edges, depth, others))
    return seen_people


def truth_table(recording: Recording, visible: list[Sighting]) -> pd.DataFrame:
    """Return the truth of one recording: boxes clipped to the picture, in quarters of a pixel."""
    parts = [
        _rows(recording.name, track, sighting) for track, sighting in enumerate(visible, start=1)
    ]
    table = pd.concat(parts, ignore_index=True)
    return table.sort_values(["frame", "track"], kind="stable", ignore_index=True)


def clipped(edges: Floats) -> Floats:
    """Clip edges to the picture and round them to quarters, which floats represent exactly."""
    inside = np.clip(edges, 0.0, [WIDTH, HEIGHT, WIDTH, HEIGHT])
    return np.asarray(np.round(inside * 4) / 4)


def _rows(name: str, track: int, sighting: Sighting) -> pd.DataFrame:
    frames = np.flatnonzero(sighting.annotated)
    edges = clipped(sighting.edges[frames])
    hidden = sighting.hidden[frames]
    return pd.DataFrame(
        {
            "recording": name,
            "frame": frames,
            "x": edges[:, 0],
            "y": edges[:, 1],
            "w": edges[:, 2] - edges[:, 0],
            "h": edges[:, 3] - edges[:, 1],
            "track": track,
            "ignore": int(sighting.person.cyclist),
            "distance_m": np.round(sighting.distance_m[frames], 2),
            "occlusion": (hidden >= LIGHT_HIDDEN).astype(int) + (hidden >= HEAVY_HIDDEN),
        },
        columns=list(TRUTH_COLUMNS),
    )


def _sighting(
    person: Person,
    body: Floats,
    edges: Floats,
    depth: Floats,
    blockers: list[tuple[Floats, Floats]],
) -> Sighting:
    size = edges[:, 2:] - edges[:, :2]
    cut = np.clip(edges, 0.0, [WIDTH, HEIGHT, WIDTH, HEIGHT])
    inside = np.prod(cut[:, 2:] - cut[:, :2], axis=1) / np.prod(size, axis=1)
    hidden = _hidden(edges, depth, blockers)
    near = depth > MIN_DEPTH_M
    inside = np.where(near, inside, 0.0)
    present = (inside >= MIN_INSIDE) & (size[:, 1] >= MIN_HEIGHT_PX)
    visible = present & (hidden <= MAX_HIDDEN)
    # From entry to exit: a person hidden behind a car for a while stays annotated, as occluded.
    entered = np.maximum.accumulate(visible)
    leaves_later = np.maximum.accumulate(visible[::-1])[::-1]
    annotated = present & entered & leaves_later
    return Sighting(
        person=person,
        edges=edges,
        depth_m=depth,
        distance_m=np.hypot(body[:, 0, 0], body[:, 0, 2]),
        lateral_m=body[:, 0, 0],
        hidden=hidden,
        inside=inside,
        annotated=annotated,
    )


def _hidden(edges: Floats, depth: Floats, blockers: list[tuple[Floats, Floats]]) -> Floats:
    """Return the share of a grid of points in the box that lies behind something nearer."""
    x = edges[:, :1] + _GRID_X * (edges[:, 2:3] - edges[:, :1])
    y = edges[:, 1:2] + _GRID_Y * (edges[:, 3:] - edges[:, 1:2])
    covered = np.zeros((len(edges), len(_GRID_X), len(_GRID_Y)), dtype=bool)
    for block, block_depth in blockers:
        nearer = (block_depth < depth - 0.15) & (block_depth > 0.5)
        across = (x >= block[:, :1]) & (x <= block[:, 2:3]) & nearer[:, None]
        down = (y >= block[:, 1:2]) & (y <= block[:, 3:])
        covered |= across[:, :, None] & down[:, None, :]
    return np.asarray(covered.mean(axis=(1, 2)))


def _shrunk(edges: Floats) -> Floats:
    """Return the part of a person's box that the body really fills."""
    margin = 0.2 * (edges[:, 2] - edges[:, 0])
    return np.stack([edges[:, 0] + margin, edges[:, 1], edges[:, 2] - margin, edges[:, 3]], axis=1)


def _box_edges(
    camera: Camera, left: float, right: float, top: float, near: Floats, far: Floats
) -> tuple[Floats, Floats]:
    """Return image edges of an upright block on the road, and the depth of its near face."""
    corners = np.stack(
        [
            np.stack([np.full_like(near, x), np.full_like(near, y), np.maximum(z, 0.6)], axis=-1)
            for x in (left, right)
            for y in (0.0, top)
            for z in (near, far)
        ],
        axis=1,
    )
    pixels, _ = camera.project(corners)
    return np.concatenate([pixels.min(axis=1), pixels.max(axis=1)], axis=1), near


def _car_edges(car: Car, camera: Camera, way: Floats) -> tuple[Floats, Floats]:
    middle = car.z + car.speed * frame_times() - way
    half, length = car.width_m / 2, car.length_m / 2
    edges, _ = _box_edges(
        camera, car.x - half, car.x + half, car.height_m, middle - length, middle + length
    )
    return edges, middle


def _thing_edges(thing: Thing, camera: Camera, way: Floats) -> tuple[Floats, Floats]:
    near = np.full(N_FRAMES, thing.z) - way
    width = thing.width_m if thing.kind != "tree" else _BLOCKING["tree"] * 2
    half = width / 2
    return _box_edges(
        camera, thing.x - half, thing.x + half, thing.size_m, near, near + thing.depth_m
    )
