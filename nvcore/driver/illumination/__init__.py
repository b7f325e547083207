"""How bright it was, when it changed from bright to dark, and the time to adapt since then."""

from nvcore.driver.illumination.changes import Changes, changes_of
from nvcore.driver.illumination.meter import (
    Light,
    LightSource,
    picture_level,
    read_light,
)
from nvcore.driver.illumination.settings import LightSettings, light_settings

__all__ = [
    "Changes",
    "Light",
    "LightSettings",
    "LightSource",
    "changes_of",
    "light_settings",
    "picture_level",
    "read_light",
]
