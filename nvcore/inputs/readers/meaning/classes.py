"""Which boxes count, are ignored or left out, their labels, and files that name classes."""

from __future__ import annotations

import json
import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from pathlib import Path, PurePosixPath
from typing import Any, Final

import numpy as np
import pandas as pd

from nvcore.dataset.sources import left_out_text
from nvcore.errors import FormatError, InputError, UnnamedClassesError
from nvcore.file_kinds import unpacked_name
from nvcore.findings import Finding, Remedy, Severity, Step
from nvcore.inputs.readers.base import (
    LeftOut,
    Lines,
    Numbering,
    ReadOptions,
    SourceFile,
    object_array,
    warning,
)
from nvcore.inputs.readers.parse.text import read_text
from nvcore.objects import Objects, labels_in_order, plain_class
from nvcore.schema import NO_LABEL, names_as_categories
from nvcore.wording import count_text, listed, shortened


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


def rule_for(rule: ClassRule | None, labels: Iterable[str], options: ReadOptions) -> ClassRule:
    """Extend a format's rule by the classes that its files have beside those of the format.

    Where the classes are named, the usual names of the objects that are not among them are ignore
    regions, except for a format's own classes of pedestrians.

    Parameters
    ----------
    rule
        Where the objects are pedestrians; of others the names of the classes decide. None: the
        format has no classes, annotators chose the labels (CVAT, Pascal VOC).
    labels
        Classes in the files, used or only declared.
    options
        `classes` and `objects` are used.
    """
    objects, known = options.objects, () if rule is None else rule.known
    folded = {name.casefold() for name in known}
    others = sorted(name for name in {*map(str, labels)} if name.casefold() not in folded)
    if rule is not None and objects.are_pedestrians:
        named = rule_of(others, objects)
        return replace(
            rule, counted=rule.counted + named.counted, ignored=rule.ignored + named.ignored
        )
    by_name = rule_of([*known, *others], objects)
    if options.classes is not None:
        return replace(by_name, counted=(), ignored=by_name.counted + by_name.ignored)
    usual = ("person", "pedestrian") if objects.are_pedestrians else (objects.singular,)
    return replace(by_name, counted=by_name.counted or usual)


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
    ignored = [name for name in of_truth if name.casefold() not in counted_names]
    is_wanted = folded.isin(counted_names)[codes]
    is_ignored = folded.isin([name.casefold() for name in ignored])[codes]
    is_strange = ~folded.isin(known | counted_names)[codes]
    find = partial(lines.finding, role=options.role, example=lambda row: str(label[row]))
    findings = find(
        is_strange,
        "unknown-class",
        "Rows of classes that the format does not have were left out: "
        f"{', '.join(sorted({str(name) for name in label[is_strange]}))}.",
        options.objects.say("If one of them is {a_one}, name it as a class that counts."),
        steps=(Step(Remedy.CLASSES),),
    )
    findings += find(
        np.full(len(label), not is_wanted.any()),
        "no-counted-class",
        f"No row is of a class that counts ({', '.join(counted)}); found "
        f"{', '.join(sorted(str(name) for name in classes))}.",
        options.objects.say("Name the classes that are {many}."),
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
    keep = is_wanted | is_ignored
    n_boxes = np.bincount(codes[~keep], minlength=len(classes))
    left_out = classes_left_out(dict(zip(classes, n_boxes, strict=True)))
    fact = f"classes: {', '.join(counted)} counted"
    fact += f"; {', '.join(ignored)} ignored" if ignored else ""
    fact += f"; others left out{': ' * bool(left_out)}{left_out_text(left_out)}"
    return ClassChoice(keep, is_ignored, fact, tuple(findings), left_out)


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


_MANY: Final = 30
"""Most classes that a message lists."""


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
    classes
        As in `Reading`.
    """

    counted: tuple[str, ...]
    ignored: tuple[str, ...] = ()
    others: tuple[str, ...] = ()
    conversion: str = ""
    findings: tuple[Finding, ...] = ()
    left_out: tuple[LeftOut, ...] = ()
    classes: tuple[str, ...] = ()


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


def by_names(
    numbers: np.ndarray, names: Mapping[int, str], options: ReadOptions
) -> tuple[np.ndarray, ReadOptions]:
    """Name of each row's class, and the options with classes by name.

    Parameters
    ----------
    numbers
        Class of each row, whole, shape (n,). One without a name is called as it is written.
    names
        The format's classes by their numbers.
    """
    numbered, by_key = NumberedRows.of(numbers), {str(key): name for key, name in names.items()}
    label = object_array(by_key.get(key, key) for key in numbered.keys)[numbered.codes]
    classes = options.classes and tuple(by_key.get(name, name) for name in options.classes)
    return label, replace(options, classes=classes)


def check_any_counts(
    classes: Iterable[str],
    what: str,
    options: ReadOptions,
    file: SourceFile,
    *,
    steps: tuple[Step, ...] = (),
) -> None:
    """Refuse a benchmark's classes if the user says neither which count nor what they are.

    Parameters
    ----------
    classes, what
        Names of the classes, and what they are, for the error: "traffic signs".
    steps
        Ways out beside choosing classes.

    Raises
    ------
    InputError
        If none of the classes is called as the objects are, and none was chosen.
    """
    if options.classes is None and not any(map(options.objects.counts, classes)):
        raise InputError(
            f"these are {what}, and none is called {options.objects.singular}: say what the "
            "boxes are of, or which classes count, by number or name",
            file=file.name,
            steps=(*steps, Step(Remedy.CLASSES)),
        )


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
    names, source, given = named.names, named.source, options.classes
    if not names:
        return _by_number(counts, options, file=file, numbers=numbers)
    objects, all_listed = options.objects, _listed(names)
    absent: list[str] = []
    if given is None:
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
    else:
        hits = {name: _keys_of(name, names) for name in given}
        counted = set().union(*hits.values())
        absent = [name for name, keys in hits.items() if not keys]
        # a system need not know every class of the truth; numbers may be meant for other files
        names_absent = [name for name in absent if not name.isdecimal()]
        if absent and (not counted or (options.role == "truth" and names_absent)):
            raise FormatError(
                f"there is no class {[*names_absent, *absent][0]!r}; the classes are {all_listed}",
                file=file,
            )
    is_truth = options.role == "truth"
    unknown = {key: key for key in counts if key not in names}
    every = {**names, **unknown}
    fates: dict[str, list[str]] = {"counted": [], "ignored": [], "left out": []}
    for key, name in every.items():
        is_ignored = is_truth and key in names and objects.concerns(name)
        fates["counted" if key in counted else "ignored" if is_ignored else "left out"].append(key)
    parts = [
        f"{', '.join(_shown(key, every[key]) for key in keys)} {fate}"
        for fate, keys in fates.items()
        if keys
    ]
    warn = partial(warning, role=options.role, file=file)
    findings: list[Finding] = []
    if counts and not counts.keys() & counted:
        findings += [
            warn(
                "no-counted-class",
                sum(counts.values()),
                f"No box is of a class that counts ({_listed({k: names[k] for k in counted})}); "
                f"found {_listed({key: every[key] for key in counts})}.",
                objects.say("Name the classes that are {many}."),
                steps=(Step(Remedy.CLASSES),),
            )
        ]
    if unknown:
        findings += [
            warn(
                "unknown-class",
                sum(counts[key] for key in unknown),
                f"Boxes of a {numbers} without a name were left out: {_listed(unknown)}. The names"
                f"{f' from {source}' if source else ''} are {all_listed}.",
                "Check that the names belong to these files, and that both count from the same "
                "number.",
            )
        ]
    if absent:
        findings += [
            warn(
                "absent-class",
                len(absent),
                f"No class is called {listed(absent)}, which should count; the classes are "
                f"{all_listed}.",
                "Check the spelling; a system that does not know a class cannot detect it.",
            )
        ]
    if given is None:
        by_name = {names[key]: n for key, n in counts.items() if key not in counted | {*unknown}}
        findings += kinds_finding([names[key] for key in fates["counted"]], by_name, options, file)
    source_text = f"; class names from {source}" if source else ""
    chosen, ignored, others = map(tuple, fates.values())
    return CategoryChoice(
        chosen,
        ignored,
        others,
        conversion=f"classes: {'; '.join(parts)}{source_text}",
        findings=tuple(findings),
        left_out=classes_left_out({every[key]: counts.get(key, 0) for key in others}),
        classes=chosen if source else (),
    )


def _by_number(
    counts: Mapping[str, int], options: ReadOptions, *, file: str, numbers: str
) -> CategoryChoice:
    """The choice where no number has a name: those that were given, or the only one."""
    keys, objects = labels_in_order(counts), options.objects
    given = {key for key in options.classes or () if key.isdecimal()}
    boxes = _few([f"{key} ({count_text(counts[key], 'box', 'boxes')})" for key in keys])
    if not given:
        if len(keys) > 1:
            names = ", ".join(options.classes or ())
            raise UnnamedClassesError(
                f"several classes, and no names say which of them are {objects.plural}"
                + (f", nor which is called {names}: give its number; " if names else ": ")
                + f"found {numbers} {boxes}",
                file=file,
                steps=(Step(Remedy.CLASSES),),
            )
        fact = f"{numbers} {keys[0]} throughout: counted (no names)" if keys else ""
        return CategoryChoice(tuple(keys), conversion=fact)
    others, named = tuple(key for key in keys if key not in given), ", ".join(sorted(given))
    finding = warning(
        "no-counted-class",
        sum(counts.values()),
        f"No box is of {numbers} {named}, which counts; found {boxes}.",
        objects.say("Name the classes that are {many}."),
        role=options.role,
        file=file,
        steps=(Step(Remedy.CLASSES),),
    )
    left_out = f"; {', '.join(others)} left out" if others else ""
    return CategoryChoice(
        counted=tuple(given),
        others=others,
        conversion=f"classes: {named} counted{left_out}",
        findings=(finding,) if keys and len(others) == len(keys) else (),
        left_out=classes_left_out({key: counts[key] for key in others}),
    )


def _keys_of(given: str, names: Mapping[str, str]) -> set[str]:
    """Keys of the categories of this name, or of this number."""
    hits = {key for key, name in names.items() if plain_class(name) == plain_class(given)}
    return hits or {given} & names.keys()


def concerns_objects(label: str, options: ReadOptions) -> bool:
    """Whether boxes of the label are counted or ignored."""
    counted = {name.casefold() for name in options.classes or ()}
    return options.objects.concerns(label) or label.casefold() in counted


def _listed(names: Mapping[str, str]) -> str:
    """Categories in messages."""
    return _few([_shown(key, name) for key, name in names.items()])


def _few(texts: Sequence[str]) -> str:
    more = f" and {len(texts) - _MANY} more" if len(texts) > _MANY else ""
    return (", ".join(texts[:_MANY]) or "none") + more


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


MAX_BYTES: Final = 1 << 20
"""Size of a file of names, unpacked; the longest in use (Objects365's) has 20 KiB."""
_MAX_FILES: Final = 50
"""Most files of names that are read: one folder may hold many YAML files."""
_LISTS: Final = re.compile(
    r"_?(?:obj_|predefined_|class_)?(?:classes|labels|names)\.txt|.*\.names|.*\.labels"
)
_YAML: Final = re.compile(r".*\.ya?ml")
_LAYOUT: Final = frozenset(
    {"labels", "label", "train", "val", "valid", "validation", "test", "obj_train_data", "gt"}
    | {"obj_valid_data", "obj_test_data"}
)
"""Folders above which the names of a whole data set lie."""
_KEY: Final = re.compile(r"""(["']?)names\1\s*:(?:\s+(?P<value>.*))?""")
_BLANK: Final = r"(?>(?:\s|#[^\n]*)*)"
_ENTRY: Final = (
    r"""(?>(?:(?P<mark>["']?)(?P<number>\d{1,9})(?P=mark)\s*:\s+)?"""
    r"""(?P<name>'(?:[^'\n]|'')*'|"(?:[^"\\\n]|\\.)*"|[^\s,\[\]{}'"#&*!|>%@`:?-][^,\[\]{}#:\n]*))"""
)
"""A name, plain or quoted, behind its number in a mapping."""
_IN_BRACKETS: Final = re.compile(rf"{_ENTRY}{_BLANK}(?:,{_BLANK}|(?=[\]}}]))")
_ON_A_LINE: Final = re.compile(rf"(?P<dash>- \s*)?{_ENTRY}(?:\s*|(?<=[ '\"])\s*#.*)")


def is_class_file(name: str) -> bool:
    """Whether a file of this name lists classes, and no boxes."""
    return _LISTS.fullmatch(last_part(name)) is not None


def class_names_beside(files: Sequence[SourceFile]) -> ClassNames:
    """Names of classes from a file among those given, else beside the first other file or above.

    A list (``classes.txt``, ``obj.names``, ``labels.txt``) or the ``names`` of a YAML file. Of
    several places the nearest counts.

    Raises
    ------
    FormatError
        If such a file cannot be read, or two in one place differ.
    """
    for place in _places(files):
        first: ClassNames | None = None
        for file in place[:_MAX_FILES]:
            names = names_in(file)
            if names and first is None:
                first = ClassNames(names, PurePosixPath(file.name).name)
            elif names and first is not None and names != first.names:
                raise file.fault(
                    f"the names of classes differ from those in {first.source} beside it; leave "
                    "the right file alone"
                )
        if first is not None:
            return first
    return ClassNames()


def _places(files: Sequence[SourceFile]) -> Iterator[list[SourceFile]]:
    """Files that may hold names, those of one place together, the nearest place first."""
    yield [file for file in files if _may_name(file.name)]
    labels = [file for file in files if not _may_name(file.name)] or files
    if not labels:
        return
    folder = Path(labels[0].path).absolute().parent
    folders = [folder, folder.parent]
    if {folder.name.lower(), folder.parent.name.lower()} & _LAYOUT:
        folders.append(folder.parent.parent)
    for place in dict.fromkeys(folders):
        try:
            names = sorted(entry.name for entry in place.iterdir() if _may_name(entry.name))
        except OSError:  # a folder above that may not be looked into
            continue
        yield [SourceFile(place / name, name) for name in names if (place / name).is_file()]


def _may_name(name: str) -> bool:
    return is_class_file(name) or _YAML.fullmatch(last_part(name)) is not None


def last_part(name: str) -> str:
    """The last part of a file's name, as its unpacked file would be called, in lower case."""
    return unpacked_name(name.rpartition("/")[2].casefold())


def names_in(file: SourceFile) -> dict[str, str]:
    """The names in a file by their numbers; none where it has none but the numbers themselves."""
    if file.is_larger_than(MAX_BYTES):
        if is_class_file(file.name):
            raise file.fault(f"a list of classes has {MAX_BYTES >> 20} MiB at most")
        return {}
    text = read_text(file)
    if is_class_file(file.name):
        names = {str(i): line.strip() for i, line in enumerate(text.strip().splitlines())}
        names = {number: name for number, name in names.items() if name}
    else:
        names = names_of_yaml(text, file)
    return {} if all(number == name for number, name in names.items()) else names


def names_of_yaml(text: str, file: SourceFile) -> dict[str, str]:
    """The ``names`` of a data set's YAML file, by their numbers; none where it has no such key.

    Only what tools write is understood: a list, or a mapping from numbers, in brackets or with a
    line for each name.

    Raises
    ------
    FormatError
        With the line of anything else.
    """
    lines = text.splitlines()
    keys = [(i, match) for i, line in enumerate(lines) if (match := _KEY.fullmatch(line))]
    if not keys:
        return {}
    at, match = keys[-1]
    value = re.sub(r"^&\S+\s*", "", (match["value"] or "").strip())  # a mark to refer to

    def fault(line: int) -> FormatError:
        return file.fault(
            "expected names: [person, car], or below it a line for each name (- person, or "
            f"0: person); found {shortened(lines[line].strip(), 60)!r}",
            line + 1,
        )

    if len(keys) > 1:
        raise fault(at)
    entries: list[re.Match[str]] = []
    if value.startswith(("[", "{")):
        closing, inside = {"[": "]", "{": "}"}[value[0]], "\n".join([value[1:], *lines[at + 1 :]])
        inside, place = re.sub(_BLANK, "", inside, count=1), 0
        while not inside.startswith(closing, place):
            entry = _IN_BRACKETS.match(inside, place)
            if entry is None or (entry["number"] is None) != (closing == "]"):
                raise fault(at)
            entries.append(entry)
            place = entry.end()
    elif value and not value.startswith("#"):
        raise fault(at)
    else:
        for i, line in enumerate(lines[at + 1 :], at + 1):
            stripped = line.strip()
            if not stripped or stripped[0] == "#":
                continue
            if line[0] not in " -":  # the next key
                break
            entry = _ON_A_LINE.fullmatch(stripped)
            if entry is None or (entry["number"] is None) != (entry["dash"] is not None):
                raise fault(i)
            entries.append(entry)
    try:
        names = {
            str(i if entry["number"] is None else int(entry["number"])): _unquoted(entry["name"])
            for i, entry in enumerate(entries)
        }
    except ValueError:  # an escape that JSON does not have
        raise fault(at) from None
    if len(names) < len(entries):
        raise fault(at)
    return names


def _unquoted(name: str) -> str:
    if name[0] == '"':
        return str(json.loads(name))
    return name[1:-1].replace("''", "'") if name[0] == "'" else name.strip()
