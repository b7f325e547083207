"""Which categories of a file count as pedestrians, by their names.

For formats whose files bring their own categories or labels; `classes` is for formats with fixed
ones, and sorts the rows by the rule that either gives.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass

from nvcore.errors import FormatError
from nvcore.inputs.readers.base import ReadOptions
from nvcore.inputs.readers.meaning.classes import ClassRule

PEDESTRIANS = frozenset({"person", "persons", "pedestrian", "pedestrians", "ped", "human"})
"""Names that count unless the user says otherwise."""

LOOKALIKES = frozenset(
    {
        *("people", "person?", "personfa", "group", "persongroup", "crowd"),
        *("cyclist", "bicyclist", "bicycledriver", "motorcyclist", "motorbikedriver", "rider"),
        *("personsitting", "sittingperson", "sitting", "staticperson", "persononvehicle"),
        *("ignore", "ignored", "ignoreregion", "ignoredregions", "dontcare"),
    }
)
"""Names of what could be taken for a pedestrian: neither right nor wrong to detect."""

_MANY = 30
_JOINTS = str.maketrans("", "", " _-")


@dataclass(frozen=True)
class CategoryChoice:
    """What becomes of each category of a file.

    Attributes
    ----------
    counted, ignored, left_out
        Keys of the categories (numbers or names, as the file has them).
    conversion
        The choice in words.
    """

    counted: tuple[str, ...]
    ignored: tuple[str, ...]
    left_out: tuple[str, ...]
    conversion: str


def choose_categories(
    names: Mapping[str, str], classes: tuple[str, ...] | None, *, file: str
) -> CategoryChoice:
    """Sort the categories of a file into counted, ignored and left out.

    Parameters
    ----------
    names
        Name of each category by its key in the file; where there are only names, key = name.
    classes
        Names or keys to count; None: those called person or pedestrian.
    file
        The file, for errors.

    Raises
    ------
    FormatError
        If one of `classes` is not there, or none is given and none is called person or
        pedestrian.
    """
    listed = ", ".join(_shown(key, name) for key, name in [*names.items()][:_MANY]) or "none"
    listed += f" and {len(names) - _MANY} more" if len(names) > _MANY else ""
    if classes is None:
        counted = {key for key, name in names.items() if is_pedestrian(name)}
        if names and not counted:
            raise FormatError(
                f"no category is called person or pedestrian; found {listed}; name the classes "
                "that count as pedestrians",
                file=file,
            )
    else:
        counted = set()
        for class_name in classes:
            hits = {key for key, name in names.items() if _plain(name) == _plain(class_name)}
            hits = hits or {key for key in names if key == class_name}
            if not hits:
                raise FormatError(
                    f"there is no class {class_name!r}; the classes are {listed}", file=file
                )
            counted |= hits
    ignored = {key for key, name in names.items() if _concerns(name)} - counted
    fates = {
        "counted": tuple(key for key in names if key in counted),
        "ignored": tuple(key for key in names if key in ignored),
        "left out": tuple(key for key in names if key not in counted | ignored),
    }
    parts = [
        f"{', '.join(_shown(key, names[key]) for key in keys)} {fate}"
        for fate, keys in fates.items()
        if keys
    ]
    return CategoryChoice(
        counted=fates["counted"],
        ignored=fates["ignored"],
        left_out=fates["left out"],
        conversion="classes: " + "; ".join(parts),
    )


def free_labels(labels: Iterable[str], options: ReadOptions) -> ClassRule:
    """The rule for labels that annotators chose (CVAT, Pascal VOC, YOLO with names).

    Where the classes are named, the usual pedestrian labels that are not among them are ignore
    regions. Labels that have nothing to do with pedestrians are known and left out.

    Parameters
    ----------
    labels
        Labels in the files, used or only declared.
    options
        `classes` is used.
    """
    names = sorted(set(labels))
    pedestrians = tuple(name for name in names if is_pedestrian(name))
    lookalikes = tuple(name for name in names if is_lookalike(name))
    others = tuple(name for name in names if not _concerns(name))
    if options.classes is not None:
        return ClassRule(counted=(), ignored=pedestrians + lookalikes, left_out=others)
    return ClassRule(pedestrians or ("person", "pedestrian"), ignored=lookalikes, left_out=others)


def concerns_pedestrians(label: str, options: ReadOptions) -> bool:
    """Whether boxes of the label are counted or ignored."""
    counted = {name.casefold() for name in options.classes or ()}
    return _concerns(label) or label.casefold() in counted


def is_pedestrian(name: str) -> bool:
    """Whether the name is one of a pedestrian."""
    return _plain(name) in PEDESTRIANS


def is_lookalike(name: str) -> bool:
    """Whether the name is one of what could be taken for a pedestrian."""
    return _plain(name) in LOOKALIKES


def _concerns(name: str) -> bool:
    """Whether boxes of this name are counted or ignored, unless the user says otherwise."""
    return is_pedestrian(name) or is_lookalike(name)


def _plain(name: str) -> str:
    """A name without case and without what joins its words: ``__ignore__`` is ``ignore``."""
    return name.strip().lower().translate(_JOINTS)


def _shown(key: str, name: str) -> str:
    """A category in messages."""
    return name if key == name else f"{name} ({key})"
