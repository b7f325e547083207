"""Which boxes count, which are ignore regions, which are left out, and their labels."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
import pandas as pd

from nvcore.dataset.sources import left_out_text
from nvcore.errors import FormatError, InputError, UnnamedClassesError
from nvcore.findings import Finding, Remedy, Severity, Step
from nvcore.inputs.readers.base import LeftOut, Lines, Numbering, ReadOptions, warning
from nvcore.objects import Objects, labels_in_order, plain_class
from nvcore.schema import NO_LABEL, names_as_categories
from nvcore.wording import count_text, listed


@dataclass(frozen=True)
class ClassRule:
    """What a format does with its classes; names are compared without regard to case.

    Attributes
    ----------
    counted
        Classes that count, unless `ReadOptions.classes` says otherwise.
    ignored
        Classes whose boxes are ignore regions in the truth.
    left_out
        Classes that are known and are neither.
    is_benchmark
        Whether a benchmark defines it so, which its users know.
    """

    counted: tuple[str, ...]
    ignored: tuple[str, ...]
    left_out: tuple[str, ...] = ()
    is_benchmark: bool = False

    @property
    def known(self) -> tuple[str, ...]:
        """All classes of the format."""
        return self.counted + self.ignored + self.left_out


@dataclass(frozen=True)
class ClassChoice:
    """What becomes of each row.

    Attributes
    ----------
    keep
        Bool, shape (n,): the row stays in the table.
    ignore
        Bool, shape (n,): the row is an ignore region; a row that is neither counts.
    fact
        The rule in words, for the conversion text.
    findings
        Rows of classes that the format does not have; rows of which none counts.
    left_out
        The classes whose rows do not stay; named in `fact`.
    """

    keep: np.ndarray
    ignore: np.ndarray
    fact: str
    findings: tuple[Finding, ...]
    left_out: tuple[LeftOut, ...]


def rule_of(classes: Iterable[str], objects: Objects) -> ClassRule:
    """What to do with classes of these names, by what they are called alone."""
    names = tuple(classes)
    counted = tuple(name for name in names if objects.counts(name))
    ignored = tuple(
        name for name in names if objects.is_lookalike(name) and not objects.counts(name)
    )
    left_out = tuple(name for name in names if not objects.concerns(name))
    return ClassRule(counted, ignored, left_out)


def rule_for(rule: ClassRule, label: np.ndarray, options: ReadOptions) -> ClassRule:
    """Extend a format's rule by the classes that its files have beside those of the format.

    Parameters
    ----------
    rule
        Where the objects are pedestrians; of others the names of the classes decide.
    label
        Class of each row, object, shape (n,).
    options
        `classes` and `objects` are used.
    """
    known = {name.casefold() for name in rule.known}
    others = sorted(name for name in {*map(str, label)} if name.casefold() not in known)
    if options.objects.are_pedestrians:
        named = rule_of(others, options.objects)
        return replace(
            rule, counted=rule.counted + named.counted, ignored=rule.ignored + named.ignored
        )
    by_name = rule_of([*rule.known, *others], options.objects)
    if options.classes is not None:
        return replace(by_name, counted=(), ignored=by_name.counted + by_name.ignored)
    return by_name if by_name.counted else replace(by_name, counted=(options.objects.singular,))


def choose_classes(
    label: np.ndarray, rule: ClassRule, options: ReadOptions, lines: Lines
) -> ClassChoice:
    """Sort rows by their class into counted, ignored (in truth only) and left out.

    Parameters
    ----------
    label
        Class of each row, object, shape (n,).
    rule
        The format's classes.
    options
        `classes`, `objects` and `role` are used.
    lines
        Where the rows stand, for errors and findings.

    Raises
    ------
    InputError
        If neither the format nor the files have a class of `ReadOptions.classes`.
    """
    codes, classes = pd.factorize(label)
    known = {name.casefold() for name in rule.known}
    folded = pd.Index([str(name).casefold() for name in classes])  # the few different names
    for name in options.classes or ():
        if name.casefold() not in known | {*folded}:
            others = sorted(str(other) for other in classes if other.casefold() not in known)
            raise InputError(
                f"there is no class {name!r}; the classes are {', '.join(rule.known)}"
                + (f", the files also have {', '.join(others)}" if others else ""),
                file=lines.files[0].name if lines.files else None,
            )
    counted = rule.counted if options.classes is None else options.classes
    counted_names = {name.casefold() for name in counted}
    of_truth = rule.ignored if options.role == "truth" else ()
    neutral = {name.casefold() for name in of_truth} - counted_names
    is_wanted, is_neutral = folded.isin(counted_names)[codes], folded.isin(neutral)[codes]
    fact = f"classes: {', '.join(counted)} counted"
    ignored = [name for name in rule.ignored if name.casefold() in neutral]
    if ignored:
        fact += f"; {', '.join(ignored)} ignored"
    is_strange = ~folded.isin(known | counted_names)[codes]
    findings = lines.finding(
        is_strange,
        "unknown-class",
        "Rows of classes that the format does not have were left out: "
        f"{', '.join(sorted({str(name) for name in label[is_strange]}))}.",
        options.objects.say("If one of them is {a_one}, name it as a class that counts."),
        role=options.role,
        example=lambda row: str(label[row]),
        steps=(Step(Remedy.CLASSES),),
    )
    findings += lines.finding(
        np.full(len(label), not is_wanted.any()),
        "no-counted-class",
        f"No row is of a class that counts ({', '.join(counted)}); found "
        f"{', '.join(sorted(str(name) for name in classes))}.",
        options.objects.say("Name the classes that are {many}."),
        role=options.role,
        example=lambda row: str(label[row]),
        steps=(Step(Remedy.CLASSES, ",".join(filter(options.objects.counts, map(str, classes)))),),
    )
    if options.classes is None and len(label):
        present = [name for name in classes if name.casefold() in counted_names]
        by_name = zip(classes, np.bincount(codes), strict=True)
        findings += kinds_finding(
            present or counted[:1],
            {str(name): int(n) for name, n in by_name if name not in present},
            options,
            lines.files[0].name,
            Severity.NOTE if rule.is_benchmark else Severity.WARNING,
        )
    keep = is_wanted | is_neutral
    n_boxes = np.bincount(codes[~keep], minlength=len(classes))
    left_out = classes_left_out(dict(zip(classes, n_boxes, strict=True)))
    return ClassChoice(
        keep=keep,
        ignore=is_neutral,
        fact=f"{fact}; others left out{': ' * bool(left_out)}{left_out_text(left_out)}",
        findings=tuple(findings),
        left_out=left_out,
    )


def kinds_finding(
    counted: Sequence[str],
    others: Mapping[str, int],
    options: ReadOptions,
    file: str,
    severity: Severity = Severity.WARNING,
) -> list[Finding]:
    """What to know of classes that are some kind of the objects and do not count.

    Parameters
    ----------
    counted
        The classes that count, without the user having said so.
    others
        The other classes, with their numbers of boxes.
    file, severity
        See `Finding`.
    """
    kinds = {name: n for name, n in others.items() if n and options.objects.is_kind(name)}
    if not kinds:
        return []
    boxes = listed([f"{name} ({n})" for name, n in kinds.items()])
    fate = "ignored: detecting or missing them changes nothing"
    return [
        Finding(
            severity,
            "other-kinds",
            options.role,
            sum(kinds.values()),
            f"Boxes of {boxes} are {fate if options.role == 'truth' else 'left out'}. "
            f"Only {listed(counted)} count{'s' if len(counted) == 1 else ''}.",
            options.objects.say(
                "If {many} of these kinds are to be detected, let them count, too."
            ),
            file=file,
            steps=(Step(Remedy.CLASSES, ",".join([*counted, *kinds])),),
        )
    ]


def classes_left_out(counts: Mapping[str, int]) -> tuple[LeftOut, ...]:
    """Classes of which nothing is used, the most boxes first, from how many boxes each has."""
    by_count = sorted(counts.items(), key=lambda item: (-item[1], item[0]))
    return tuple(LeftOut("class", str(name), int(n)) for name, n in by_count if n)


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
    source_text = f"; class names from {source}" if source else ""
    return CategoryChoice(
        counted=fates["counted"],
        ignored=fates["ignored"],
        others=fates["left out"],
        conversion=f"classes: {'; '.join(parts)}{source_text}",
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
    finding = warning(
        "no-counted-class",
        sum(counts.values()),
        f"No box is of {numbers} {', '.join(sorted(given))}, which counts; found {boxes}.",
        options.objects.say("Name the classes that are {many}."),
        role=options.role,
        file=file,
        steps=(Step(Remedy.CLASSES),),
    )
    left_out = f"; {', '.join(others)} left out" if others else ""
    return CategoryChoice(
        counted=tuple(given),
        others=others,
        conversion=f"classes: {', '.join(sorted(given))} counted{left_out}",
        findings=(finding,) if keys and len(others) == len(keys) else (),
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


def labels_of(counted: Iterable[str], objects: Objects) -> dict[str, str]:
    """The label of each class that counts, by its name; without those that say none.

    Examples
    --------
    >>> from nvcore.objects import SPEED_SIGN
    >>> labels_of(["speed limit 30", "50", "speed limit"], SPEED_SIGN)
    {'speed limit 30': '30', '50': '50'}
    """
    labels = {str(name): objects.label_of(str(name)) for name in counted}
    return {name: label for name, label in labels.items() if label}


def codes_of(kind: Any, label_of: Mapping[str, str]) -> np.ndarray:
    """Place of each row's label among the different values of `label_of`; int32, (n,).

    Parameters
    ----------
    kind
        Class of each row, as text or categories; NO_LABEL where it is not in `label_of`.
    """
    place = {label: number for number, label in enumerate(dict.fromkeys(label_of.values()))}
    names = names_as_categories(kind, len(kind))
    of_name = [place.get(label_of.get(str(name), ""), NO_LABEL) for name in names.categories]
    codes: np.ndarray = np.array([*of_name, NO_LABEL], np.int32)[names.codes]
    return codes


def labelled(
    kind: np.ndarray, is_counted: np.ndarray, objects: Objects
) -> tuple[np.ndarray, tuple[str, ...]]:
    """Label of each row as `Reading` has it, and what the labels are.

    Parameters
    ----------
    kind
        Class of each row, object, shape (n,).
    is_counted
        Whether the row's class counts, bool, shape (n,).
    objects
        In whose words.

    Returns
    -------
    codes, labels
        Places among the labels, int32, (n,); NO_LABEL where the class counts not or says none.
    """
    label_of = labels_of(pd.unique(kind[is_counted]), objects)
    return codes_of(kind, label_of), tuple(dict.fromkeys(label_of.values()))


def merged(parts: Iterable[tuple[str, ...]]) -> tuple[tuple[str, ...], list[np.ndarray]]:
    """The labels of several readings in one list, and the places in it of each reading's.

    Returns
    -------
    labels, places
        Of each reading int32, (its labels + 1,): the last, NO_LABEL, is of boxes without one.
    """
    parts = list(parts)
    labels = labels_in_order(label for part in parts for label in part)
    place = {label: number for number, label in enumerate(labels)}
    return labels, [np.array([*map(place.get, part), NO_LABEL], np.int32) for part in parts]
