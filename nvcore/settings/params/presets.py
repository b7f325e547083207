"""Named settings for common kinds of traffic."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Final

from nvcore.settings.objects import SPEED_SIGN, Objects
from nvcore.settings.params import MIDPOINT_SHARE, SPREAD_SHARE, Params


@dataclass(frozen=True)
class Preset:
    """Named choice of traffic context, height of near objects, and coverage.

    Attributes
    ----------
    name
        Name as shown.
    text
        Purpose in one sentence.
    edge_weight
        See `Params.edge_weight`; None: as stated by each recording.
    midpoint_share, spread_share
        Midpoint and spread of the height sigmoid, as shares of the picture's height.
    coverage
        See `Params.coverage`.
    objects
        Objects that it is made for; None: any.
    """

    name: str
    text: str
    edge_weight: float | None
    midpoint_share: float
    spread_share: float
    coverage: float = Params.coverage
    objects: Objects | None = None

    def values(self, height: float | None) -> dict[str, float | str | None]:
        """Return all parameters except the thresholds, for pictures of this height in px.

        Midpoint and spread are None, so that they come from each recording, if they are the default
        shares or the height is unknown.
        """
        defaults = {
            name: value
            for name, value in asdict(Params()).items()
            if not name.startswith("threshold")
        }
        is_default = (self.midpoint_share, self.spread_share) == (MIDPOINT_SHARE, SPREAD_SHARE)
        changes: dict[str, float | str | None] = {
            "edge_weight": self.edge_weight,
            "coverage": self.coverage,
        }
        if not is_default and height is not None:
            changes["midpoint"] = self.midpoint_share * height
            changes["spread"] = self.spread_share * height
        return defaults | changes


PRESETS: Final = (
    Preset(
        "Default",
        "All settings but the thresholds as by default, the traffic context as each recording "
        "says. Of these the paper fixes alpha alone, at 0.9; the others are choices of ours.",
        edge_weight=None,
        midpoint_share=MIDPOINT_SHARE,
        spread_share=SPREAD_SHARE,
    ),
    Preset(
        "Urban",
        "Low speed: {a_one} counts half at 15 % of the tallest picture's height, a "
        "miss on the far sidewalk costs little.",
        edge_weight=0.0,
        midpoint_share=0.15,
        spread_share=0.03,
    ),
    Preset(
        "Rural",
        "High speed: {a_one} counts half at 6 % of the tallest picture's height, and a miss "
        "at the road's edge costs as much as one straight ahead.",
        edge_weight=1.0,
        midpoint_share=0.06,
        spread_share=0.012,
    ),
    Preset(
        "Speed signs",
        "A sign counts as seen if it is matched in one of five frames in which it is near enough; "
        "it counts half at 1/24 of the tallest picture's height (20 px of 480), and a miss at the "
        "road's edge, where signs stand, costs as much as one straight ahead.",
        edge_weight=1.0,
        midpoint_share=1 / 24,
        spread_share=1 / 120,
        coverage=0.2,
        objects=SPEED_SIGN,
    ),
)
"""All presets, the default first."""


def presets_for(objects: Objects) -> tuple[Preset, ...]:
    """Return the presets that make sense for these objects, the default first."""
    return tuple(preset for preset in PRESETS if preset.objects in (None, objects))
