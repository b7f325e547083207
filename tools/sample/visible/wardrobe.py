"""Colours of clothes, skin, hair, cars and walls: albedos in linear red, green, blue."""

from __future__ import annotations

import zlib
from dataclasses import dataclass
from typing import Final

import numpy as np

from tools.sample.camera import Floats
from tools.sample.visible.light import LUMA

COATS: Final[dict[str, tuple[float, float, float]]] = {
    "black": (0.022, 0.022, 0.025),
    "anthracite": (0.045, 0.046, 0.05),
    "navy": (0.022, 0.035, 0.085),
    "bottle green": (0.025, 0.062, 0.036),
    "burgundy": (0.115, 0.018, 0.028),
    "brown": (0.11, 0.062, 0.032),
    "blue": (0.045, 0.12, 0.33),
    "grey": (0.155, 0.16, 0.17),
    "red": (0.42, 0.035, 0.03),
    "olive": (0.13, 0.125, 0.055),
    "camel": (0.34, 0.225, 0.115),
    "turquoise": (0.06, 0.29, 0.31),
    "orange": (0.62, 0.21, 0.03),
    "light grey": (0.37, 0.375, 0.38),
    "yellow": (0.68, 0.53, 0.05),
    "beige": (0.50, 0.43, 0.32),
    "white": (0.72, 0.72, 0.70),
}
TROUSERS: Final[dict[str, tuple[float, float, float]]] = {
    "black": (0.02, 0.02, 0.022),
    "dark jeans": (0.028, 0.04, 0.075),
    "jeans": (0.07, 0.11, 0.20),
    "grey": (0.13, 0.13, 0.135),
    "chinos": (0.28, 0.215, 0.13),
    "pale": (0.45, 0.43, 0.40),
}
_HAIR: Final = ((0.015, 0.012, 0.010), (0.05, 0.03, 0.018), (0.16, 0.10, 0.05), (0.30, 0.29, 0.28))
_SKIN: Final = ((0.46, 0.29, 0.22), (0.36, 0.215, 0.155), (0.17, 0.095, 0.065))
CARS: Final = (
    *((0.05, 0.05, 0.055), (0.42, 0.43, 0.44), (0.62, 0.62, 0.61), (0.10, 0.012, 0.014)),
    *((0.02, 0.045, 0.14), (0.20, 0.205, 0.21), (0.028, 0.05, 0.04)),
)
WALLS: Final = (
    *((0.52, 0.48, 0.40), (0.58, 0.57, 0.54), (0.48, 0.36, 0.20), (0.27, 0.125, 0.085)),
    *((0.40, 0.42, 0.42), (0.50, 0.30, 0.22), (0.36, 0.40, 0.33)),
)


@dataclass(frozen=True)
class Outfit:
    """Clothes, hair and skin of a person as albedos, shape (3,) each."""

    coat: Floats
    trousers: Floats
    shoes: Floats
    hair: Floats
    skin: Floats


def outfit(
    name: str, reflectance: float, coat: str | None = None, trousers: str | None = None
) -> Outfit:
    """Choose the clothes of a person.

    Parameters
    ----------
    name
        Name of the person. Equal names give equal clothes.
    reflectance
        Reflectance in the near infrared. Dyes behave differently there, so it determines the
        brightness of the coat only roughly.
    coat, trousers
        Names of clothes. None: chosen by reflectance and name.
    """
    generator = np.random.default_rng([25, zlib.crc32(name.encode())])
    near_coats = _near(COATS, 0.62 * reflectance, 4)
    near_trousers = _near(TROUSERS, 0.30 * reflectance, 3)
    chosen_coat = near_coats[int(generator.integers(len(near_coats)))]
    chosen_trousers = near_trousers[int(generator.integers(len(near_trousers)))]
    hair = np.array(_HAIR[int(generator.integers(len(_HAIR)))])
    skin = np.array(_SKIN[int(generator.choice(len(_SKIN), p=(0.5, 0.3, 0.2)))])
    shoes = np.full(3, generator.choice([0.02, 0.03, 0.10, 0.45]))
    return Outfit(
        np.array(COATS[coat or chosen_coat]),
        np.array(TROUSERS[trousers or chosen_trousers]),
        shoes,
        hair,
        skin,
    )


def _near(clothes: dict[str, tuple[float, float, float]], luminance: float, n: int) -> list[str]:
    """Return the `n` clothes whose albedo is nearest in ratio."""
    away = {name: abs(np.log(np.array(c) @ LUMA / max(luminance, 0.02))) for name, c in
            clothes.items()}  # fmt: skip
    return sorted(away, key=lambda name: away[name])[:n]


def of_place(colours: tuple[tuple[float, float, float], ...], x: float, z: float) -> Floats:
    """Return the colour of an object at a place. Equal places give equal colours."""
    seed = zlib.crc32(f"{x:.2f} {z:.2f}".encode())
    return np.array(colours[seed % len(colours)])
