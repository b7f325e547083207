"""Which categories of a file count, by their names.

For formats whose files bring their own categories or labels, or number them; `classes` is for
formats with fixed ones, and sorts the rows by the rule that either gives.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field

import numpy as np

from nvcore.errors import FormatError, UnnamedClassesError
from nvcore.findings import Finding, Remedy, Step
from nvcore.inputs.readers.base import LeftOut, Numbering, ReadOptions, warning
from nvcore.inputs.readers.meaning.classes import (
    ClassRule,
    classes_left_out,
    kinds_finding,
    rule_of,
)
from nvcore.objects import labels_in_order, plain_class
from nvcore.wording import count_text, listed

_MANY = 30


@dataclass(frozen=True)
class CategoryChoice:
    """What becomes of each category of a file.

    Attributes
    ----------
    counted, ignored, others
        Keys of the categories (numbers or names, as the file has them); `others` are left out.
    conversion
        The choice in words.
    findings
        What the user should know of it.
    left_out
        The `others` that have boxes, by their names.
    source
        Where the names are from, where that is another file.
    """

    counted: tuple[str, ...]
    ignored: tuple[str, ...] = ()
    others: tuple[str, ...] = ()
    conversion: str = ""
    findings: tuple[Finding, ...] = ()
    left_out: tuple[LeftOut, ...] = ()
    source: str = ""

    @property
    def classes(self) -> tuple[str, ...]:
        """As in `Reading`."""
        return self.counted if self.source else ()


@dataclass(frozen=True)
class ClassNames:
    """Names of classes.

    Attributes
    ----------
    names
        Name of each class by its number as text, or by itself; empty: there are no names.
    source
        Where they are from, where that is another file: "data.yaml".
    """

    names: Mapping[str, str] = field(default_factory=dict)
    source: str = ""


def names_of_numbers(
    numbers: Iterable[str], own: ClassNames, options: ReadOptions, numbering: Numbering
) -> ClassNames:
    """Names of the classes that files number: their own, else those of the other side.

    Parameters
    ----------
    numbers
        Those in the files. The other side's names are of another list where one has none.
    numbering
        How the files number their classes.
    """
    theirs = options.names_for(numbering)
    if own.names or not {*numbers} <= theirs.keys():
        return own
    return ClassNames(theirs, "the systems" if options.role == "truth" else "the ground truth")


@dataclass(frozen=True)
class NumberedRows:
    """Rows of which each has the number of its class.

    Attributes
    ----------
    keys
        The different numbers as text, object, shape (n_classes,).
    codes
        Place of each row's class among them; int, shape (n,).
    """

    keys: np.ndarray
    codes: np.ndarray

    @classmethod
    def of(cls, numbers: np.ndarray) -> NumberedRows:
        """From the number of each row, whole, shape (n,)."""
        different, codes = np.unique(numbers, return_inverse=True)
        return cls(np.array([*map(str, different.tolist())], dtype=object), codes)

    @property
    def counts(self) -> dict[str, int]:
        """How many rows have each number."""
        return dict(zip(self.keys, np.bincount(self.codes).tolist(), strict=True))

    def among(self, keys: tuple[str, ...]) -> np.ndarray:
        """Whether each row's number is one of these; bool, shape (n,)."""
        is_among: np.ndarray = np.isin(self.keys, keys)[self.codes]
        return is_among


def choose_categories(
    counts: Mapping[str, int],
    named: ClassNames,
    options: ReadOptions,
    *,
    file: str,
    numbers: str = "class",
) -> CategoryChoice:
    """Sort the categories of a file into counted, ignored and left out.

    Parameters
    ----------
    counts
        How many boxes each category has, by its key in the file.
    named
        Name of each category by its key; where there are only names, key = name. Empty: the keys
        are numbers without names.
    options
        Its `classes` are names or keys to count; None: those called as the objects are (person,
        pedestrian). Of detections nothing is ignored: what does not count is left out.
    file
        The file, for errors.
    numbers
        What the files call the number of a class.

    Raises
    ------
    FormatError
        If one of `classes` is not there, or none is given and none is called so.
    UnnamedClassesError
        If there are no names, and several numbers of which nobody said which count.
    """
    names, source = named.names, named.source
    if not names:
        return _by_number(counts, options, file=file, numbers=numbers)
    objects = options.objects
    all_listed = _listed(names)
    if options.classes is None:
        counted = {key for key, name in names.items() if objects.counts(name)}
        if not counted:
            called = "person or pedestrian" if objects.are_pedestrians else objects.singular
            kinds = ",".join(name for name in names.values() if objects.is_kind(name))
            raise FormatError(
                f"no category is called {called}; found {all_listed}; name the classes that count "
                f"as {objects.plural}",
                file=file,
                steps=(Step(Remedy.CLASSES, kinds),),
            )
        absent: list[str] = []
    else:
        hits = {given: _keys_of(given, names) for given in options.classes}
        counted = set().union(*hits.values())
        absent = [given for given, keys in hits.items() if not keys]
        # a system need not know every class of the truth; numbers may be meant for other files
        names_absent = [given for given in absent if not given.isdecimal()]
        if absent and (not counted or (options.role == "truth" and names_absent)):
            raise FormatError(
                f"there is no class {[*names_absent, *absent][0]!r}; the classes are {all_listed}",
                file=file,
            )
    ignored = {key for key, name in names.items() if objects.concerns(name)} - counted
    ignored = set() if options.role == "detections" else ignored
    unknown = [key for key in counts if key not in names]
    others = [key for key in names if key not in counted | ignored] + unknown
    fates = {
        "counted": tuple(key for key in names if key in counted),
        "ignored": tuple(key for key in names if key in ignored),
        "left out": tuple(others),
    }
    parts = [
        f"{', '.join(_shown(key, names.get(key, key)) for key in keys)} {fate}"
        for fate, keys in fates.items()
        if keys
    ]
    findings: list[Finding] = []
    if counts and not counts.keys() & counted:
        findings.append(
            warning(
                "no-counted-class",
                sum(counts.values()),
                f"No box is of a class that counts ({_listed({k: names[k] for k in counted})}); "
                f"found {_listed({key: names.get(key, key) for key in counts})}.",
                objects.say("Name the classes that are {many}."),
                role=options.role,
                file=file,
                steps=(Step(Remedy.CLASSES),),
            )
        )
    if unknown:
        findings.append(
            warning(
                "unknown-class",
                sum(counts[key] for key in unknown),
                f"Boxes of a {numbers} without a name were left out: "
                f"{_listed({key: key for key in unknown})}. The names"
                f"{f' from {source}' if source else ''} are {all_listed}.",
                "Check that the names belong to these files, and that both count from the same "
                "number.",
                role=options.role,
                file=file,
            )
        )
    if absent:
        findings.append(
            warning(
                "absent-class",
                len(absent),
                f"No class is called {listed(absent)}, which should count; the classes are "
                f"{all_listed}.",
                "Check the spelling; a system that does not know a class cannot detect it.",
                role=options.role,
                file=file,
            )
        )
    if options.classes is None:
        by_name = {names[key]: n for key, n in counts.items() if key not in counted | {*unknown}}
        findings += kinds_finding([names[key] for key in fates["counted"]], by_name, options, file)
    conversion = "classes: " + "; ".join(parts)
    return CategoryChoice(
        counted=fates["counted"],
        ignored=fates["ignored"],
        others=fates["left out"],
        conversion=conversion + (f"; class names from {source}" if source else ""),
        findings=tuple(findings),
        left_out=classes_left_out({names.get(key, key): counts.get(key, 0) for key in others}),
        source=source,
    )


def _by_number(
    counts: Mapping[str, int], options: ReadOptions, *, file: str, numbers: str
) -> CategoryChoice:
    """The choice where no number has a name: those that were given, or the only one."""
    keys = labels_in_order(counts)
    given = {key for key in options.classes or () if key.isdecimal()}
    boxes = ", ".join(f"{key} ({count_text(counts[key], 'box', 'boxes')})" for key in keys[:_MANY])
    boxes += f" and {len(keys) - _MANY} more" if len(keys) > _MANY else ""
    if not given:
        if len(keys) > 1:
            names = ", ".join(options.classes or ())
            raise UnnamedClassesError(
                f"several classes, and no names say which of them are {options.objects.plural}"
                + (f", nor which is called {names}: give its number; " if names else ": ")
                + f"found {numbers} {boxes}",
                file=file,
                steps=(Step(Remedy.CLASSES),),
            )
        fact = f"{numbers} {keys[0]} throughout: counted (no names)" if keys else ""
        return CategoryChoice(tuple(keys), conversion=fact)
    others = tuple(key for key in keys if key not in given)
    findings = []
    if keys and len(others) == len(keys):
        findings = [
            warning(
                "no-counted-class",
                sum(counts.values()),
                f"No box is of {numbers} {', '.join(sorted(given))}, which counts; found {boxes}.",
                options.objects.say("Name the classes that are {many}."),
                role=options.role,
                file=file,
                steps=(Step(Remedy.CLASSES),),
            )
        ]
    parts = [f"{', '.join(sorted(given))} counted"]
    parts += [f"{', '.join(others)} left out"] if others else []
    return CategoryChoice(
        counted=tuple(given),
        others=others,
        conversion="classes: " + "; ".join(parts),
        findings=tuple(findings),
        left_out=classes_left_out({key: counts[key] for key in others}),
    )


def _keys_of(given: str, names: Mapping[str, str]) -> set[str]:
    """Keys of the categories of this name, or of this number."""
    hits = {key for key, name in names.items() if plain_class(name) == plain_class(given)}
    return hits or {given} & names.keys()


def free_labels(labels: Iterable[str], options: ReadOptions) -> ClassRule:
    """The rule for labels that annotators chose (CVAT, Pascal VOC).

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


def _listed(names: Mapping[str, str]) -> str:
    """Categories in messages."""
    shown = ", ".join(_shown(key, name) for key, name in [*names.items()][:_MANY]) or "none"
    return shown + (f" and {len(names) - _MANY} more" if len(names) > _MANY else "")


def _shown(key: str, name: str) -> str:
    """A category in messages."""
    return name if key == name else f"{name} ({key})"
