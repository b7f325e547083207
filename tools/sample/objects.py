"""Drawing of roadside objects: houses, trees, lamps, poles, signs, posts, cabinets."""

from __future__ import annotations

import zlib
from functools import lru_cache
from itertools import pairwise
from typing import Final

import cv2
import numpy as np

from tools.sample.backdrop import noise
from tools.sample.camera import Camera, Floats
from tools.sample.canvas import NEAR_M, Canvas, Picture, Shape, project_polygon
from tools.sample.scene import Climate, Thing

_SPRITE: Final = (256, 200)
_STOREY_M: Final = 2.8
HAZE_M: Final = 240.0


def hazed(grey: float, depth_m: float, climate: Climate) -> float:
    """Return the grey level of an object seen through `depth_m` metres of air."""
    return climate.haze + (grey - climate.haze) * float(np.exp(-max(depth_m, 0.0) / HAZE_M))


def upright(x0: float, x1: float, y0: float, y1: float, z: float) -> Floats:
    """Return a rectangle that faces the camera, shape (4, 3)."""
    return np.array([[x0, y0, z], [x1, y0, z], [x1, y1, z], [x0, y1, z]])


def sidewall(x: float, y0: float, y1: float, z0: float, z1: float) -> Floats:
    """Return a rectangle along the road, shape (4, 3)."""
    return np.array([[x, y0, z0], [x, y0, z1], [x, y1, z1], [x, y1, z0]])


class Sketch:
    """Collector of polygons in space, in painting order, that are projected in one go."""

    def __init__(self, camera: Camera, climate: Climate):
        self._camera, self._climate = camera, climate
        self._corners: list[Floats] = []
        self._greys: list[float] = []

    def add(self, corners: Floats, grey: float) -> None:
        """Add a polygon of metres relative to the car, shape (corners, 3)."""
        self._corners.append(corners)
        self._greys.append(grey)

    @property
    def shapes(self) -> list[Shape]:
        """Return the shapes in the image, hazed by their distance."""
        if not self._corners:
            return []
        counts = [len(corners) for corners in self._corners]
        starts = np.concatenate([[0], np.cumsum(counts)[:-1]])
        everything = np.concatenate(self._corners)
        pixels, _ = self._camera.project(everything)
        nearest = np.minimum.reduceat(everything[:, 2], starts)
        depth = np.add.reduceat(np.maximum(everything[:, 2], 0.0), starts) / counts
        clear = np.exp(-depth / HAZE_M)
        greys = self._climate.haze + (np.array(self._greys) - self._climate.haze) * clear
        shapes: list[Shape] = []
        for index, (start, count) in enumerate(zip(starts, counts, strict=True)):
            outline: Floats | None = pixels[start : start + count]
            if nearest[index] < NEAR_M:
                outline = project_polygon(self._camera, self._corners[index])
            if outline is not None:
                shapes.append((outline, float(greys[index])))
        return shapes


def draw_thing(
    canvas: Canvas, thing: Thing, ahead_m: float, camera: Camera, climate: Climate
) -> None:
    """Paint one object whose near side is `ahead_m` metres ahead."""
    if thing.kind in ("tree", "bush"):
        _plant(canvas, thing, ahead_m, camera, climate)
        return
    sketch = Sketch(camera, climate)
    draw = {
        "house": _house,
        "lamp": _lamp,
        "pole": _pole,
        "sign": _sign,
        "post": _post,
        "cabinet": _cabinet,
    }[thing.kind]
    draw(sketch, thing, ahead_m, climate.things)
    canvas.paint(sketch.shapes, soften=0.4, texture=1.6 if thing.kind == "house" else 0.8)
    if thing.kind == "lamp" and ahead_m > 1:
        head = np.array([thing.x - np.sign(thing.x) * 1.1, thing.size_m, ahead_m])
        pixel, depth = camera.project(head)
        radius = 0.34 * camera.focal_px / max(float(depth), 1.0)
        canvas.glow(pixel[0], pixel[1], radius, 45 * thing.heat)
    if thing.kind == "cabinet" and ahead_m > 1 and thing.heat > 0:
        pixel, depth = camera.project(np.array([thing.x, thing.size_m * 0.6, ahead_m]))
        radius = 0.7 * camera.focal_px / max(float(depth), 1.0)
        canvas.glow(pixel[0], pixel[1], radius, 26 * thing.heat)


def _house(sketch: Sketch, thing: Thing, z: float, things: float) -> None:
    generator = np.random.default_rng([11, zlib.crc32(f"{thing.x:.2f} {thing.z:.2f}".encode())])
    side = np.sign(thing.x)
    wall_x = thing.x - side * thing.width_m / 2
    outer = thing.x + side * thing.width_m / 2
    far, top = z + thing.depth_m, thing.size_m
    if far < 2:
        return
    base = things + generator.uniform(-8, 15)
    ridge = np.array(
        [[wall_x, top, z], [wall_x, top, far], [thing.x, top + 2.6, far], [thing.x, top + 2.6, z]]
    )
    sketch.add(ridge, base - 24)
    gable = np.array(
        [[wall_x, 0, z], [wall_x, top, z], [thing.x, top + 2.6, z], [outer, top, z], [outer, 0, z]]
    )
    sketch.add(gable, base - 5)
    bands = np.linspace(0, top, 8)
    for low, high in pairwise(bands):
        # Walls are warmer near the ground and under the eaves.
        warm = 7 * np.exp(-low / 1.2) + 4 * (high > top - 0.9)
        sketch.add(sidewall(wall_x, low, high, z, far), base + warm + generator.uniform(-1, 1))
    _gable_windows(sketch, generator, thing, z, base)
    if z > 150:
        return
    n_across = max(int(thing.depth_m / 2.7), 1)
    gap = thing.depth_m / n_across
    door = int(generator.integers(n_across))
    for storey in range(int(top / _STOREY_M)):
        for place in range(n_across):
            middle = z + (place + 0.5) * gap
            if storey == 0 and place == door:
                sketch.add(sidewall(wall_x, 0.0, 2.2, middle - 0.55, middle + 0.55), base + 22)
                continue
            _window(sketch, generator, wall_x, storey * _STOREY_M + 0.95, middle, base)


def _gable_windows(
    sketch: Sketch, generator: np.random.Generator, thing: Thing, z: float, base: float
) -> None:
    for storey in range(int(thing.size_m / _STOREY_M)):
        for share in (-0.2, 0.2):
            low, x = storey * _STOREY_M + 0.95, thing.x + share * thing.width_m
            warm = float(generator.choice([2.0, 4.0, 34.0]))
            sketch.add(upright(x - 0.56, x + 0.56, low - 0.06, low + 1.4, z), base + 0.5 * warm)
            sketch.add(upright(x - 0.48, x + 0.48, low, low + 1.32, z), base - 8 + warm)


def _window(
    sketch: Sketch, generator: np.random.Generator, x: float, low: float, middle: float, base: float
) -> None:
    """Draw a heated room's window: warm frame, warm lintel, and a warm patch at the radiator."""
    heated = generator.random() < 0.45
    warm = float(generator.uniform(20, 64)) if heated else -9.0
    if heated:
        sketch.add(
            sidewall(x, low - 0.75, low - 0.05, middle - 0.62, middle + 0.62), base + 0.22 * warm
        )
    sketch.add(sidewall(x, low - 0.08, low + 1.42, middle - 0.60, middle + 0.60), base + 0.5 * warm)
    sketch.add(sidewall(x, low, low + 1.32, middle - 0.50, middle - 0.04), base + warm - 8)
    sketch.add(sidewall(x, low, low + 1.32, middle + 0.04, middle + 0.50), base + warm - 10)
    sketch.add(sidewall(x, low + 1.32, low + 1.46, middle - 0.60, middle + 0.60), base + 0.9 * warm)


def _mast(sketch: Sketch, x: float, width: float, top: float, z: float, grey: float) -> None:
    sketch.add(upright(x - width / 2, x + width / 2, 0.0, top, z), grey)
    sketch.add(upright(x - width / 2, x - width / 6, 0.0, top, z), grey - 6)


def _lamp(sketch: Sketch, thing: Thing, z: float, things: float) -> None:
    side = np.sign(thing.x)
    _mast(sketch, thing.x, 0.15, thing.size_m, z, things - 4)
    end = thing.x - side * 1.3
    y = thing.size_m
    arm = np.array(
        [[thing.x, y - 0.14, z], [thing.x, y, z], [end, y + 0.12, z], [end, y + 0.02, z]]
    )
    sketch.add(arm, things - 4)
    head = np.array(
        [
            [end - 0.02, y - 0.02, z],
            [end + side * 0.62, y - 0.02, z],
            [end + side * 0.5, y + 0.2, z],
            [end + side * 0.1, y + 0.2, z],
        ]
    )
    sketch.add(head, things + 150 * thing.heat)


def _pole(sketch: Sketch, thing: Thing, z: float, things: float) -> None:
    _mast(sketch, thing.x, thing.width_m, thing.size_m, z, things + 6)
    y = thing.size_m - 0.5
    sketch.add(upright(thing.x - 0.9, thing.x + 0.9, y, y + 0.12, z), things)
    for place in (-0.8, 0.0, 0.8):
        sketch.add(
            upright(thing.x + place - 0.05, thing.x + place + 0.05, y + 0.12, y + 0.34, z),
            things - 8,
        )


def _sign(sketch: Sketch, thing: Thing, z: float, things: float) -> None:
    """Draw a sign, which is dark in the far infrared because bare metal mirrors the cold sky."""
    _mast(sketch, thing.x, 0.07, thing.size_m - 0.1, z, things - 8)
    half, top = thing.width_m / 2, thing.size_m
    sketch.add(upright(thing.x - half, thing.x + half, top - thing.width_m, top, z), things - 30)
    inner = half * 0.78
    sketch.add(
        upright(thing.x - inner, thing.x + inner, top - half - inner, top - half + inner, z),
        things - 22,
    )


def _post(sketch: Sketch, thing: Thing, z: float, things: float) -> None:
    half = thing.width_m / 2
    sketch.add(upright(thing.x - half, thing.x + half, 0.0, thing.size_m, z), things + 7)
    sketch.add(upright(thing.x - half, thing.x + half, 0.72, 0.9, z), things - 10)


def _cabinet(sketch: Sketch, thing: Thing, z: float, things: float) -> None:
    half, top = thing.width_m / 2, thing.size_m
    side = np.sign(thing.x)
    hot = 120 * thing.heat
    sketch.add(sidewall(thing.x - side * half, 0, top, z, z + thing.depth_m), things + 0.5 * hot)
    sketch.add(upright(thing.x - half, thing.x + half, 0, top, z), things + 0.42 * hot)
    sketch.add(
        upright(thing.x - half * 0.8, thing.x + half * 0.75, top * 0.3, top * 0.94, z),
        things + 0.8 * hot,
    )
    for step in range(4):
        low = top * (0.62 + 0.07 * step)
        sketch.add(
            upright(thing.x - half * 0.55, thing.x + half * 0.5, low, low + top * 0.03, z),
            things + hot,
        )


def _plant(canvas: Canvas, thing: Thing, z: float, camera: Camera, climate: Climate) -> None:
    if z < 2.0:
        return
    seed = zlib.crc32(f"{thing.x:.2f} {thing.z:.2f}".encode())
    levels = foliage(seed % 7, thing.kind == "bush")
    foot, depth = camera.project(np.array([thing.x, 0.0, z]))
    scale = camera.focal_px / float(depth)
    height = thing.size_m * scale * 1.02
    wide = (thing.width_m if thing.kind == "bush" else thing.size_m * 0.72) * scale
    # A sprite far larger than its place is read from a halved copy to avoid sparkling.
    shrink = max(_SPRITE[0] / max(height, 1.0), _SPRITE[1] / max(wide, 1.0))
    image, cover = levels[int(np.clip(np.floor(np.log2(max(shrink, 1.0))), 0, len(levels) - 1))]
    tone = hazed(climate.things - 1 + seed % 9, z, climate)
    canvas.sprite(
        image, cover, (foot[0] - wide / 2, foot[1] - height, foot[0] + wide / 2, foot[1]), tone
    )


@lru_cache(maxsize=16)
def foliage(seed: int, low: bool) -> tuple[tuple[Picture, Picture], ...]:
    """Return a tree or bush as image and cover, in full size and halved five times."""
    generator = np.random.default_rng([13, seed, int(low)])
    rows, columns = _SPRITE
    y, x = np.mgrid[0:rows, 0:columns].astype(np.float32)
    field = np.zeros(_SPRITE, dtype=np.float32)
    shade = np.zeros(_SPRITE, dtype=np.float32)
    for _ in range(46):
        if low:
            spot_x, spot_y = generator.uniform(28, columns - 28), generator.uniform(60, rows - 30)
            radius = generator.uniform(20, 38)
        else:
            angle, far = generator.uniform(0, 2 * np.pi), generator.uniform(0, 1) ** 0.6
            spot_x = columns / 2 + 66 * far * np.cos(angle)
            spot_y = 92 + 68 * far * np.sin(angle)
            radius = generator.uniform(14, 30)
        blob = np.exp(-((((x - spot_x) ** 2 + (y - spot_y) ** 2) / radius**2) ** 1.5))
        field = np.maximum(field, blob)
        shade += blob * generator.uniform(-1, 1)
    # Leaves fray the edge of the crown but do not float beside it.
    frayed = 0.34 * noise(generator, _SPRITE, (5, 5)) + 0.26 * noise(generator, _SPRITE, (2.4, 2.4))
    field += frayed * np.clip(3.2 * field - 0.35, 0, 1)
    cover = np.clip((field - 0.38) * 4.5, 0, 1)
    image = 1 + 0.075 * shade + 0.06 * noise(generator, _SPRITE, (3, 3)) - 0.12 * (1 - y / rows)
    if low:
        cover *= np.clip((rows - y) / 20, 0, 1)
    else:
        half = 3.2 + 4.0 * np.clip((y - 120) / 130, 0, 1) ** 2
        trunk = np.clip(half - np.abs(x - columns / 2 - 4 * np.sin(y / 40 + seed)) + 0.5, 0, 1) * (
            y > 100
        )
        image = np.where((trunk > 0.5) & (cover < 0.5), 1.12, image)
        cover = np.maximum(cover, trunk)
    image = cv2.GaussianBlur((image * cover).astype(np.float32), (0, 0), 1.3)
    cover = cv2.GaussianBlur(cover.astype(np.float32), (0, 0), 1.3)
    levels = [(image, cover)]
    for _ in range(5):
        image, cover = (
            cv2.resize(part, (part.shape[1] // 2, part.shape[0] // 2), interpolation=cv2.INTER_AREA)
            for part in (image, cover)
        )
        levels.append((image, cover))
    return tuple(levels)
