"""Choose boxes that count or are ignored, label them, and read files that name classes."""

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

from nvcore.common.errors import FormatError, InputError, UnnamedClassesError
from nvcore.common.file_kinds import unpacked_name
from nvcore.common.findings import Finding, Remedy, Severity, Step
from nvcore.common.wording import count_text, listed, shortened
from nvcore.dataset.schema import NO_LABEL, names_as_categories
from nvcore.dataset.sources import left_out_text
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
from nvcore.settings.objects import Objects, labels_in_order, plain_class


@dataclass(frozen=True)
class ClassRule:
    """Treatment of a format's classes, by names without regard to case.

    Attributes
    ----------
    counted
        Classes that count, unless `ReadOptions.classes` says otherwise.
    ignored
        Classes whose boxes are ignore regions in the truth.
    left_out
        Known classes that are neither.
    is_benchmark
        Whether a benchmark defines this treatment, so that its users know it.
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
    """Treatment of each row: kept or not, ignored or counted.

    Attributes
    ----------
    keep
        Bool, shape (n,): the row stays in the table.
    ignore
        Bool, shape (n,): the row is an ignore region. Other kept rows count.
    fact
        Description of the rule, for the conversion text.
    findings
        Findings about rows of unknown classes, or if no row counts.
    left_out
        Classes whose rows are not kept, also named in `fact`.
    """

    keep: np.ndarray
    ignore: np.ndarray
    fact: str
    findings: tuple[Finding, ...]
    left_out: tuple[LeftOut, ...]


def rule_of(classes: Iterable[str], objects: Objects) -> ClassRule:
    """Infer the treatment of classes from their names alone."""
    names = tuple(classes)
    counted = tuple(name for name in names if objects.counts(name))
    ignored = tuple(
        name for name in names if objects.is_lookalike(name) and not objects.counts(name)
    )
    left_out = tuple(name for name in names if not objects.concerns(name))
    return ClassRule(counted, ignored, left_out)


def rule_for(rule: ClassRule | None, labels: Iterable[str], options: ReadOptions) -> ClassRule:
    """Extend a format's rule by other classes in its files.

    If `options.classes` names the classes that count, other usual names of the objects become
    ignore regions, except a format's own classes of pedestrians.

    Parameters
    ----------
    rule
        The format's rule, which applies to pedestrians. For other objects, names of classes
        decide. None: annotators chose the labels (CVAT, Pascal VOC).
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
        Lines of the rows, for errors and findings.

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
    """Report classes that are a kind of the objects but do not count.

    Parameters
    ----------
    counted
        Classes that count by default.
    others
        Number of boxes of each other class.
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
    """List unused classes with their numbers of boxes, the most frequent first."""
    by_count = sorted(counts.items(), key=lambda item: (-item[1], item[0]))
    return tuple(LeftOut("class", str(name), int(n)) for name, n in by_count if n)


_MANY: Final = 30
"""Most classes that a message lists."""


@dataclass(frozen=True)
class CategoryChoice:
    """Treatment of each category of a file.

    Attributes
    ----------
    counted, ignored, others
        Keys of the categories (numbers or names, as in the file). `others` are left out.
    conversion
        Description of the choice.
    findings
        Findings about the choice.
    left_out
        The `others` that have boxes, by name.
    classes
        See `Reading`.
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
        Name of each class by its number as text, or by itself. Empty: there are no names.
    source
        Another file that the names are from: "data.yaml".
    """

    names: Mapping[str, str] = field(default_factory=dict)
    source: str = ""


def names_of_numbers(
    numbers: Iterable[str], own: ClassNames, options: ReadOptions, numbering: Numbering
) -> ClassNames:
    """Return the files' names of numbered classes, else those of the other side.

    Parameters
    ----------
    numbers
        Class numbers in the files. The other side's names apply only if they cover all of them.
    numbering
        Kind of the files' class numbers.
    """
    theirs = options.names_for(numbering)
    if own.names or not {*numbers} <= theirs.keys():
        return own
    return ClassNames(theirs, "the systems" if options.role == "truth" else "the ground truth")


@dataclass(frozen=True)
class NumberedRows:
    """Class number of each row.

    Attributes
    ----------
    keys
        Distinct numbers as text, object, shape (n_classes,).
    codes
        Index of each row's class in `keys`, int, shape (n,).
    """

    keys: np.ndarray
    codes: np.ndarray

    @classmethod
    def of(cls, numbers: np.ndarray) -> NumberedRows:
        """Encode the class number of each row (whole, shape (n,))."""
        different, codes = np.unique(numbers, return_inverse=True)
        return cls(np.array([*map(str, different.tolist())], dtype=object), codes)

    @property
    def counts(self) -> dict[str, int]:
        """Number of rows by class number."""
        return dict(zip(self.keys, np.bincount(self.codes).tolist(), strict=True))

    def among(self, keys: tuple[str, ...]) -> np.ndarray:
        """Mark rows whose number is one of these. Bool, shape (n,)."""
        is_among: np.ndarray = np.isin(self.keys, keys)[self.codes]
        return is_among


def by_names(
    numbers: np.ndarray, names: Mapping[int, str], options: ReadOptions
) -> tuple[np.ndarray, ReadOptions]:
    """Convert class numbers of rows and options to names.

    Parameters
    ----------
    numbers
        Class of each row, whole, shape (n,). A number without a name is its own name.
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
        Names of the classes, and a term for them in the error: "traffic signs".
    steps
        Suggested fixes other than choosing classes.

    Raises
    ------
    InputError
        If no class has a name of the objects, and none was chosen.
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
        Number of boxes of each category, by its key in the file.
    named
        Name of each category by its key. If there are only names, they are the keys. Empty: the
        keys are numbers without names.
    options
        `classes` are names or keys to count. None: names of the objects (person, pedestrian).
        Detections of other classes are left out, not ignored.
    file
        The file, for errors.
    numbers
        Term for the number of a class in the files.

    Raises
    ------
    FormatError
        If one of `classes` does not exist, or none is given and no class has a known name.
    UnnamedClassesError
        If there are several numbers without names, and no choice.
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
        # a system may lack classes of the truth, and numbers may be meant for other files
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
    """Choose categories without names: the given numbers, or the only one."""
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
    """Return the keys of the categories with this name or number."""
    hits = {key for key, name in names.items() if plain_class(name) == plain_class(given)}
    return hits or {given} & names.keys()


def concerns_objects(label: str, options: ReadOptions) -> bool:
    """Whether boxes of the label are counted or ignored."""
    counted = {name.casefold() for name in options.classes or ()}
    return options.objects.concerns(label) or label.casefold() in counted


def _listed(names: Mapping[str, str]) -> str:
    """List categories for a message."""
    return _few([_shown(key, name) for key, name in names.items()])


def _few(texts: Sequence[str]) -> str:
    more = f" and {len(texts) - _MANY} more" if len(texts) > _MANY else ""
    return (", ".join(texts[:_MANY]) or "none") + more


def _shown(key: str, name: str) -> str:
    """Name a category for a message."""
    return name if key == name else f"{name} ({key})"


def labels_of(counted: Iterable[str], objects: Objects) -> dict[str, str]:
    """Return the label of each class that counts, by name, without classes that have none.

    Examples
    --------
    >>> from nvcore.settings.objects import SPEED_SIGN
    >>> labels_of(["speed limit 30", "50", "speed limit"], SPEED_SIGN)
    {'speed limit 30': '30', '50': '50'}
    """
    labels = {str(name): objects.label_of(str(name)) for name in counted}
    return {name: label for name, label in labels.items() if label}


def codes_of(kind: Any, label_of: Mapping[str, str]) -> np.ndarray:
    """Encode each row's label as an index of the distinct values of `label_of`, int32, (n,).

    Parameters
    ----------
    kind
        Class of each row, as text or categories. Classes not in `label_of` become NO_LABEL.
    """
    place = {label: number for number, label in enumerate(dict.fromkeys(label_of.values()))}
    names = names_as_categories(kind, len(kind))
    of_name = [place.get(label_of.get(str(name), ""), NO_LABEL) for name in names.categories]
    codes: np.ndarray = np.array([*of_name, NO_LABEL], np.int32)[names.codes]
    return codes


def labelled(
    kind: np.ndarray, is_counted: np.ndarray, objects: Objects
) -> tuple[np.ndarray, tuple[str, ...]]:
    """Return the label of each row as in `Reading`, and the list of labels.

    Parameters
    ----------
    kind
        Class of each row, object, shape (n,).
    is_counted
        Whether the row's class counts, bool, shape (n,).
    objects
        Objects whose terms the labels use.

    Returns
    -------
    codes, labels
        Indices of labels, int32, (n,), NO_LABEL if the class does not count or has none.
    """
    label_of = labels_of(pd.unique(kind[is_counted]), objects)
    return codes_of(kind, label_of), tuple(dict.fromkeys(label_of.values()))


def merged(parts: Iterable[tuple[str, ...]]) -> tuple[tuple[str, ...], list[np.ndarray]]:
    """Merge the labels of several readings into one list, with each reading's indices in it.

    Returns
    -------
    labels, places
        Indices for each reading, int32, (its labels + 1,). The last is NO_LABEL.
    """
    parts = list(parts)
    labels = labels_in_order(label for part in parts for label in part)
    place = {label: number for number, label in enumerate(labels)}
    return labels, [np.array([*map(place.get, part), NO_LABEL], np.int32) for part in parts]


MAX_BYTES: Final = 1 << 20
"""Largest decompressed file of names. The largest in use (Objects365's) has 20 KiB."""
_MAX_FILES: Final = 50
"""Largest number of files of names to read, since a folder may have many YAML files."""
_LISTS: Final = re.compile(
    r"_?(?:obj_|predefined_|class_)?(?:classes|labels|names)\.txt|.*\.names|.*\.labels"
)
_YAML: Final = re.compile(r".*\.ya?ml")
_LAYOUT: Final = frozenset(
    {"labels", "label", "train", "val", "valid", "validation", "test", "obj_train_data", "gt"}
    | {"obj_valid_data", "obj_test_data"}
)
"""Folders whose parents may hold the names of a whole data set."""
_KEY: Final = re.compile(r"""(["']?)names\1\s*:(?:\s+(?P<value>.*))?""")
_BLANK: Final = r"(?>(?:\s|#[^\n]*)*)"
_ENTRY: Final = (
    r"""(?>(?:(?P<mark>["']?)(?P<number>\d{1,9})(?P=mark)\s*:\s+)?"""
    r"""(?P<name>'(?:[^'\n]|'')*'|"(?:[^"\\\n]|\\.)*"|[^\s,\[\]{}'"#&*!|>%@`:?-][^,\[\]{}#:\n]*))"""
)
"""A plain or quoted name after its number in a mapping."""
_IN_BRACKETS: Final = re.compile(rf"{_ENTRY}{_BLANK}(?:,{_BLANK}|(?=[\]}}]))")
_ON_A_LINE: Final = re.compile(rf"(?P<dash>- \s*)?{_ENTRY}(?:\s*|(?<=[ '\"])\s*#.*)")


def is_class_file(name: str) -> bool:
    """Whether a file of this name lists classes instead of boxes."""
    return _LISTS.fullmatch(last_part(name)) is not None


def class_names_beside(files: Sequence[SourceFile]) -> ClassNames:
    """Read names of classes from a file among those given, else beside or above the first other.

    The file is a list (``classes.txt``, ``obj.names``, ``labels.txt``) or YAML with ``names``. The
    nearest folder takes precedence.

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
    """Yield the files of each folder that may hold names, the nearest folder first."""
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
        except OSError:  # an unreadable folder above
            continue
        yield [SourceFile(place / name, name) for name in names if (place / name).is_file()]


def _may_name(name: str) -> bool:
    return is_class_file(name) or _YAML.fullmatch(last_part(name)) is not None


def last_part(name: str) -> str:
    """Return the last part of a file's name in lower case, without an ending of compression."""
    return unpacked_name(name.rpartition("/")[2].casefold())


def names_in(file: SourceFile) -> dict[str, str]:
    """Read the names in a file by number, or none if all names are just the numbers."""
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
    """Parse the ``names`` of a data set's YAML file, by number, or none without such a key.

    Supported are the forms that tools write: a list, or a mapping from numbers, in brackets or
    with a line for each name.

    Raises
    ------
    FormatError
        If the names have another form, with the line.
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
