"""Kinds of alerts by what they were worth, with one sentence each."""

from __future__ import annotations

from enum import StrEnum
from typing import Final


class AlertKind(StrEnum):
    """What an alert was worth; the first that holds, in this order."""

    IGNORED = "ignored"
    FALSE = "false"
    NUISANCE = "nuisance"
    REDUNDANT = "redundant"
    NEEDED = "needed"
    WANTED = "wanted"


ALERT_TEXT: Final[dict[AlertKind, str]] = {
    AlertKind.IGNORED: "Alerts about what the ground truth ignores: neither right nor wrong.",
    AlertKind.FALSE: "Alerts whose boxes match {nobody}, and nothing that is ignored.",
    AlertKind.NUISANCE: "Alerts about {a_one} {who} is not urgent, and far or outside of the "
    "corridor when they begin.",
    AlertKind.REDUNDANT: "Alerts about {a_one} {whom} the driver has seen before they begin.",
    AlertKind.NEEDED: "Alerts about {a_one} {whom} the driver has not seen when they begin.",
    AlertKind.WANTED: "Alerts that are redundant or needed: whether the driver sees the {one} is "
    "not known.",
}
UNWANTED: Final = (AlertKind.FALSE, AlertKind.NUISANCE, AlertKind.REDUNDANT)
"""Alerts that the driver would rather not have had."""
RESTS_ON_DRIVER: Final = (AlertKind.REDUNDANT, AlertKind.NEEDED)
"""Kinds whose number is undefined where it is known of nobody whether the driver sees him."""
