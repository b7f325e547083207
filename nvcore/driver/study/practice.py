"""Drawn pictures for practice: a road at dusk with a figure, like none of a study's."""

from __future__ import annotations

from typing import Final

import numpy as np

SIZE: Final = (1280, 720)
FIGURES: Final = ((300.0, 330.0, 60.0, 170.0), (890.0, 350.0, 50.0, 140.0))
"""Box of the figure in each picture: x, y, w, h, px."""


def practice_picture(index: int) -> np.ndarray:
    """A picture for practice: uint8, (720, 1280, 3), RGB; its figure is at ``FIGURES[index]``."""
    width, height = SIZE
    x, y = np.meshgrid(np.arange(width) + 0.5, np.arange(height) + 0.5)
    horizon = 0.45 * height
    light = np.where(y < horizon, 95 - 40 * y / horizon, 38 + 22 * (y - horizon) / horizon)
    half = 30 + 1.1 * (y - horizon)
    is_road = (y > horizon) & (np.abs(x - width / 2) < half)
    light = np.where(is_road, light + 14, light)
    is_line = (
        is_road & (np.abs(x - width / 2) < 0.02 * half) & (np.sqrt(np.abs(y - horizon)) % 4 < 2)
    )
    light = np.where(is_line, 150, light)
    light = np.where(_is_figure(x, y, FIGURES[index]), 120, light)
    noise = np.random.default_rng(index).normal(0, 3, light.shape)
    tint = np.array([0.95, 1.0, 1.12])
    picture: np.ndarray = np.clip((light + noise)[..., None] * tint, 0, 255).astype(np.uint8)
    return picture


def _is_figure(x: np.ndarray, y: np.ndarray, box: tuple[float, ...]) -> np.ndarray:
    """Head, trunk and legs within the box."""
    left, top, w, h = box
    across, down = (x - left - w / 2) / w, (y - top) / h
    head = (across / 0.22) ** 2 + ((down - 0.08) / 0.08) ** 2 < 1
    trunk = (across / 0.5) ** 2 + ((down - 0.38) / 0.24) ** 2 < 1
    legs = (down > 0.5) & (down < 1) & (np.abs(np.abs(across) - 0.18) < 0.14)
    figure: np.ndarray = head | trunk | legs
    return figure
