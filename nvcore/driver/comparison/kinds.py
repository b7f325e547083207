"""Regions of the Venn diagram of driver, X and Y, with a sentence on each."""

from __future__ import annotations

from enum import StrEnum
from typing import Final


class DriverRegion(StrEnum):
    """Region of the three-way Venn diagram of the encounters that the driver, X and Y see."""

    DRIVER_X_Y = "driver_x_y"
    DRIVER_X = "driver_x"
    DRIVER_Y = "driver_y"
    DRIVER = "driver"
    X_Y = "x_y"
    X = "x"
    Y = "y"
    NOBODY = "nobody"
    UNKNOWN = "unknown"
    DISTANT = "distant"


DRIVER_REGION_TEXT: Final[dict[DriverRegion, str]] = {
    DriverRegion.DRIVER_X_Y: "The driver and both systems: both warnings are redundant.",
    DriverRegion.DRIVER_X: "The driver and X, not Y: the warning of X is redundant.",
    DriverRegion.DRIVER_Y: "The driver and Y, not X: the warning of Y is redundant.",
    DriverRegion.DRIVER: "The driver, but neither X nor Y: a warning would be redundant.",
    DriverRegion.X_Y: "Not the driver, but both X and Y: either can warn.",
    DriverRegion.X: "Neither the driver nor Y, but X: only X can warn.",
    DriverRegion.Y: "Neither the driver nor X, but Y: only Y can warn.",
    DriverRegion.NOBODY: "Neither the driver nor X nor Y: the {one} is unprotected.",
    DriverRegion.UNKNOWN: "It is not known whether the driver sees the {one}.",
    DriverRegion.DISTANT: "The {one} never came near enough to count.",
}
