"""Brightness over time, changes from bright to dark, and the time since to adapt."""

from nvcore.subjects.driver.illumination.clock import LightSettings
from nvcore.subjects.driver.illumination.meter import Light, LightSource, picture_level, read_light

__all__ = ["Light", "LightSettings", "LightSource", "picture_level", "read_light"]
