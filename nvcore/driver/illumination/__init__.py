"""How bright it was, when it changed from bright to dark, and the time to adapt since then."""

from nvcore.driver.illumination.clock import Changes, LightSettings, changes_of
from nvcore.driver.illumination.meter import (
    Light,
    LightSource,
    picture_level,
    read_light,
)

__all__ = [
    "Changes",
    "Light",
    "LightSettings",
    "LightSource",
    "changes_of",
    "picture_level",
    "read_light",
]
