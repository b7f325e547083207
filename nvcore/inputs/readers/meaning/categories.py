"""Which categories of a file count, by their names.

For formats whose files bring their own categories or labels; `classes` is for formats with fixed
ones, and sorts the rows by the rule that either gives.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass

from nvcore.errors import FormatError
from nvcore.inputs.readers.base import ReadOptions
from nvcore.inputs.readers.meaning.classes import ClassRule, rule_of
from nvcore.wording.objects import plain_class

_MANY = 30


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
    names: Mapping[str, str], options: ReadOptions, *, file: str
) -> CategoryChoice:
    """Sort the categories of a file into counted, ignored and left out.

    Parameters
    ----------
    names
        Name of each category by its key in the file; where there are only names, key = name.
    options
        Its `classes` are names or keys to count; None: those called as the objects are (person,
        pedestrian). Of detections nothing is ignored: what does not count is left out.
    file
        The file, for errors.

    Raises
    ------
    FormatError
        If one of `classes` is not there, or none is given and none is called so.
    """
    classes, objects = options.classes, options.objects
    listed = ", ".join(_shown(key, name) for key, name in [*names.items()][:_MANY]) or "none"
    listed += f" and {len(names) - _MANY} more" if len(names) > _MANY else ""
    if classes is None:
        counted = {key for key, name in names.items() if objects.counts(name)}
        if names and not counted:
            called = "person or pedestrian" if objects.are_pedestrians else objects.singular
            raise FormatError(
                f"no category is called {called}; found {listed}; name the classes that count as "
                f"{objects.plural}",
                file=file,
            )
    else:
        counted = set()
        for class_name in classes:
            hits = {
                key for key, name in names.items() if plain_class(name) == plain_class(class_name)
            }
            hits = hits or {key for key in names if key == class_name}
            if not hits:
                raise FormatError(
                    f"there is no class {class_name!r}; the classes are {listed}", file=file
                )
            counted |= hits
    ignored = {key for key, name in names.items() if objects.concerns(name)} - counted
    ignored = set() if options.role == "detections" else ignored
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

    Where the classes are named, the usual labels of the objects that are not among them are ignore
    regions. Labels that have nothing to do with them are known and left out.

    Parameters
    ----------
    labels
        Labels in the files, used or only declared.
    options
        `classes` and `objects` are used.
    """
    names, objects = sorted(set(labels)), options.objects
    rule = rule_of(names, objects)
    if options.classes is not None:
        return ClassRule(counted=(), ignored=rule.counted + rule.ignored, left_out=rule.left_out)
    usual = ("person", "pedestrian") if objects.are_pedestrians else (objects.singular,)
    return ClassRule(rule.counted or usual, rule.ignored, rule.left_out)


def concerns_objects(label: str, options: ReadOptions) -> bool:
    """Whether boxes of the label are counted or ignored."""
    counted = {name.casefold() for name in options.classes or ()}
    return options.objects.concerns(label) or label.casefold() in counted


def _shown(key: str, name: str) -> str:
    """A category in messages."""
    return name if key == name else f"{name} ({key})"
