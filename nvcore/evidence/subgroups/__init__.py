"""Groups of encounters: near, far, centre, edge, occluded, odd poses, classes, recordings' tags."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np

from nvcore.comparison.compare import Result
from nvcore.metrics.detection.filtered_truth import has_tags, known_tags
from nvcore.metrics.encounter_classes import classes_of
from nvcore.settings.params import MIDPOINT_SHARE

NEAR_MIDPOINTS: Final = 2.0
"""Least height of the largest box of a near encounter, as a multiple of the height that counts
half. Height is inverse to distance: half the distance of the step or closer."""
CENTRE_OFFSET: Final = 0.5
"""Largest mean lateral offset of a central encounter: the picture's middle half, with the road."""
OCCLUDED_SHARE: Final = 0.5
"""Least share of occluded frames, among those with known occlusion, of an occluded encounter."""
ODD_POSE_Z: Final = 1.0
"""Least deviation of an odd pose's aspect ratio from the mean, in standard deviations."""

ALL: Final = "all"
TAG: Final = "tag"
CLASS: Final = "class"
MOST_CLASSES: Final = 12
"""Most classes of pedestrians that become groups, since p is corrected for all groups."""


@dataclass(frozen=True, eq=False)
class Subgroup:
    """Group of encounters.

    Attributes
    ----------
    factor, group
        Criterion for dividing encounters (``distance``, ``place``, ``occlusion``, ``pose``,
        ``class``, ``tag``), and the name of the group.
    is_member
        Encounters of the group that count, as a rule without distant ones; bool, shape
        (n_encounters,).
    recordings
        Recordings with the tag, or with a member; bool, shape (n_recordings,).
    """

    factor: str
    group: str
    is_member: np.ndarray
    recordings: np.ndarray

    @property
    def has_frames(self) -> bool:
        """Whether it consists of whole recordings, so that frames and false alerts belong to it."""
        return self.factor in (ALL, TAG)


def everyone(result: Result) -> Subgroup:
    """Return the group of all encounters that count and all recordings."""
    return Subgroup(ALL, ALL, result.is_near, np.ones(len(result.dataset.recordings), dtype=bool))


def find_subgroups(result: Result) -> tuple[Subgroup, ...]:
    """Find the groups of encounters, from the ground truth alone and so the same for X and Y.

    A factor is left out if the data lack it (occlusion, classes, tags) or one of its groups would
    be empty. A tag without frames is left out, too. A recording may have several tags, a pedestrian
    several classes.
    """
    encounters, dataset = result.encounters, result.dataset
    is_near = result.is_near
    height = dataset.recordings["height"].to_numpy(dtype=float)[encounters.recording]
    midpoint = result.params.midpoint
    if midpoint is None or result.params.proximity != "height":
        half = MIDPOINT_SHARE * height
    else:
        half = np.full(len(encounters), midpoint)
    is_close = encounters.peak_height >= NEAR_MIDPOINTS * half
    is_central = encounters.lateral_offset < CENTRE_OFFSET
    occluded_share, pose = encounters.occluded_share, encounters.aspect_z
    is_usual = np.abs(pose) < ODD_POSE_Z
    occlusions = {
        "visible": occluded_share < OCCLUDED_SHARE,
        "occluded": occluded_share >= OCCLUDED_SHARE,
        "unknown": np.isnan(occluded_share),
    }
    factors: tuple[tuple[str, dict[str, np.ndarray]], ...] = (
        ("distance", {"near": is_close, "far": ~is_close}),
        ("place", {"centre": is_central, "edge": ~is_central}),
        ("occlusion", occlusions),
        ("pose", {"usual": is_usual, "wide": pose <= -ODD_POSE_Z, "narrow": pose >= ODD_POSE_Z}),
    )
    subgroups = []
    for factor, groups in factors:
        parts = [
            _part(result, factor, name, is_member & is_near) for name, is_member in groups.items()
        ]
        parts = [part for part in parts if part.is_member.any()]
        if len(parts) > 1:
            subgroups += parts
    return (*subgroups, *_class_groups(result, is_near), *_tag_groups(result, is_near))


def class_groups(result: Result, is_counted: np.ndarray) -> tuple[Subgroup, ...]:
    """Return a group for each class of these encounters, including classes derived from boxes.

    Parameters
    ----------
    is_counted
        Encounters that count here; bool, shape (n_encounters,).
    """
    parts = [
        _part(result, CLASS, name, is_member & is_counted)
        for name, is_member in classes_of(result.dataset).members.items()
    ]
    return tuple(part for part in parts if part.is_member.any())


def _part(result: Result, factor: str, group: str, is_member: np.ndarray) -> Subgroup:
    n_recordings = len(result.dataset.recordings)
    members = np.bincount(result.encounters.recording[is_member], minlength=n_recordings)
    return Subgroup(factor, group, is_member, members > 0)


def _class_groups(result: Result, is_near: np.ndarray) -> list[Subgroup]:
    """Return the largest named classes and codes. Derived ones would add tests to every table."""
    if result.dataset.attributes.empty and not result.dataset.settings.codes:
        return []
    classes = classes_of(result.dataset)
    names = dict.fromkeys((*classes.named, *classes.coded))
    members = {name: classes.members[name] & is_near for name in names if name in classes.members}
    parts = [
        _part(result, CLASS, name, is_member)
        for name, is_member in members.items()
        if 0 < np.count_nonzero(is_member) < np.count_nonzero(is_near)
    ]
    largest = sorted(parts, key=lambda part: -np.count_nonzero(part.is_member))[:MOST_CLASSES]
    return [part for part in parts if part in largest]


def _tag_groups(result: Result, is_near: np.ndarray) -> list[Subgroup]:
    has_frames = np.diff(result.dataset.frame_columns.first) > 0
    parts = []
    for tag in known_tags(result.dataset):
        has_tag = has_tags(result.dataset, (tag,))
        if (has_tag & has_frames).any():
            is_member = has_tag[result.encounters.recording] & is_near
            parts.append(Subgroup(TAG, tag, is_member, has_tag))
    return parts
