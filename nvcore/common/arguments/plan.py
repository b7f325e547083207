"""Arguments of a study plan."""

from __future__ import annotations

from dataclasses import KW_ONLY
from typing import Final, Literal, get_args

import click

from nvcore.common.arguments import argument, arguments

Side = Literal["x", "y"]
STUDY: Final = "Study"


@arguments
class PlanArguments:
    """See `nvcore.api.comparison.Comparison.plan`."""

    measure: str | None = argument(
        STUDY,
        "What to compare by, if not by the primary measure: severity_s_per_encounter, "
        "encounters_detected, mean_similarity, share_low, lost_s_per_min, saliency, in_time, "
        "mean_impact_kmh, useful_alerts, false_alert_episodes_per_hour, log_average_miss_rate, "
        "or, with alerts, alerts_unwanted_per_hour or alerted_in_time.",
        default=None,
        metavar="KEY",
    )
    _: KW_ONLY
    difference: float | None = argument(
        STUDY,
        "The smallest difference that would matter, in the unit of the measure; 3% is 0.03, 3 "
        "percentage points of a share. Default: as in these recordings.",
        default=None,
        metavar="D",
    )
    margin: float | None = argument(
        STUDY,
        "Ask another question: is the candidate worse by less than this? Likewise.",
        default=None,
        metavar="M",
    )
    candidate: Side = argument(
        STUDY,
        "The system that {margin} is for, such as the one that costs less.",
        default="y",
        type=click.Choice(get_args(Side)),
    )
    power: float = argument(
        STUDY, "Share of studies that should show it, 0.5 to 0.99.", default=0.8
    )
    n_tests: int = argument(
        STUDY,
        "Measures that the study will test, for which its p is corrected.",
        flag="--tests",
        default=1,
        type=click.IntRange(min=1),
    )
