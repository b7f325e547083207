"""Who detects more, for near and far, centre and edge, occluded, odd poses, tags of recordings."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Final

import numpy as np
import pandas as pd

from nvcore.analysis import Result
from nvcore.paired_tests import holm, mcnemar
from nvcore.params import MIDPOINT_SHARE
from nvcore.schema import Category
from nvcore.venn import count_categories

NEAR_MIDPOINTS: Final = 2.0
"""Near: the largest box is this many times as high as one that counts half. Height goes with one
over the distance: at half the distance of the step or closer."""
CENTRE_OFFSET: Final = 0.5
"""Centre: on average in the middle half of the picture, where the road is."""
OCCLUDED_SHARE: Final = 0.5
"""Occluded: in at least this share of the frames with known occlusion."""
ODD_POSE_Z: Final = 1.0
"""Odd pose: the aspect ratio is this many standard deviations or more from the mean."""

ALL: Final = "all"
COLUMNS: Final = (
    "factor", "group", "n", "both", "x_only", "y_only", "neither", "x", "y", "difference", "low",
    "high", "odds_ratio", "odds_low", "odds_high", "p", "p_holm", "note",
)  # fmt: skip


@dataclass(frozen=True, eq=False)
class Subgroup:
    """Some of the encounters.

    Attributes
    ----------
    factor, group
        What encounters are divided by (``distance``, ``place``, ``occlusion``, ``pose``, ``tag``),
        and the name of the part.
    is_member
        bool, shape (n_encounters,).
    """

    factor: str
    group: str
    is_member: np.ndarray


def find_subgroups(result: Result) -> tuple[Subgroup, ...]:
    """The parts of the encounters that count; by the ground truth alone, the same for X and Y.

    A factor is left out where the data do not know it (occlusion, tags) or do not divide by it
    (a part would be empty). A recording may have several tags.
    """
    encounters, dataset = result.encounters, result.dataset
    is_near = result.category != Category.DISTANT.value
    height = dataset.recordings["height"].to_numpy(dtype=float)[encounters.recording]
    midpoint = result.params.midpoint
    if midpoint is None or result.params.proximity != "height":
        half = MIDPOINT_SHARE * height
    else:
        half = np.full(len(encounters), midpoint)
    is_close = encounters.peak_height >= NEAR_MIDPOINTS * half
    is_central = encounters.lateral_offset < CENTRE_OFFSET
    occluded, pose = encounters.occluded_share, encounters.aspect_z
    is_usual = np.abs(pose) < ODD_POSE_Z
    factors: tuple[tuple[str, dict[str, np.ndarray]], ...] = (
        ("distance", {"near": is_close, "far": ~is_close}),
        ("place", {"centre": is_central, "edge": ~is_central}),
        ("occlusion", {
            "visible": occluded < OCCLUDED_SHARE,
            "occluded": occluded >= OCCLUDED_SHARE,
            "unknown": np.isnan(occluded),
        }),
        ("pose", {
            "usual": is_usual,
            "wide": pose <= -ODD_POSE_Z,
            "narrow": pose >= ODD_POSE_Z,
        }),
    )  # fmt: skip
    found = []
    for factor, groups in factors:
        parts = [Subgroup(factor, name, is_it & is_near) for name, is_it in groups.items()]
        parts = [part for part in parts if part.is_member.any()]
        if len(parts) > 1:
            found += parts
    return (*found, *_tagged(result, is_near))


def _tagged(result: Result, is_near: np.ndarray) -> list[Subgroup]:
    tags = result.dataset.recordings["tags"].tolist()
    names = sorted({tag for of_one in tags for tag in of_one})
    parts = []
    for name in names:
        has_tag = np.array([name in of_one for of_one in tags], dtype=bool)
        parts.append(Subgroup("tag", name, has_tag[result.encounters.recording] & is_near))
    return [part for part in parts if part.is_member.any()]


def subgroup_table(result: Result) -> pd.DataFrame:
    """Difference in the share of encounters detected, for all of them and by subgroup.

    Ready for a forest plot: one row per part, the first one for all encounters.

    Returns
    -------
    Columns `COLUMNS`: factor, group; n (encounters) and how many are detected by both, only X,
    only Y, neither; x, y (shares detected, 1 is best), difference (X - Y) with its 95 % interval
    (low, high); odds_ratio with interval; exact McNemar p, and p_holm, corrected for all subgroups
    (the row of all encounters is not one); note: what is not given, and why. The parts of several
    factors overlap, and a tag's with another's.
    """
    everyone = Subgroup(ALL, ALL, result.category != Category.DISTANT.value)
    rows = [_row(result, one) for one in (everyone, *find_subgroups(result))]
    table = pd.DataFrame(rows)
    p_holm = np.full(len(table), np.nan)
    p_holm[1:] = holm(table["p"].to_numpy()[1:])
    table["p_holm"] = p_holm
    return table[list(COLUMNS)]


def _row(result: Result, part: Subgroup) -> dict[str, Any]:
    venn = count_categories(result.category[part.is_member])
    found = mcnemar(venn)
    counts = venn.counts()
    return {
        "factor": part.factor,
        "group": part.group,
        "n": venn.n_near,
        **{name: counts[name] for name in ("both", "x_only", "y_only", "neither")},
        "x": found.share_x,
        "y": found.share_y,
        "difference": found.difference,
        "low": found.low,
        "high": found.high,
        "odds_ratio": found.odds_ratio,
        "odds_low": found.odds_low,
        "odds_high": found.odds_high,
        "p": found.p,
        "note": found.reason,
    }
