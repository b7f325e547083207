"""Which boxes count, which are ignore regions and which are left out."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
import pandas as pd

from nvcore.dataset.sources import left_out_text
from nvcore.errors import InputError
from nvcore.findings import Finding, Remedy, Severity, Step
from nvcore.inputs.readers.base import LeftOut, Lines, ReadOptions
from nvcore.objects import Objects
from nvcore.wording import listed


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
    say = options.objects.say
    known = {name.casefold() for name in rule.known}
    folded = pd.Index([str(name).casefold() for name in classes])  # the few different names
    counted_names = {name.casefold() for name in rule.counted}
    counted = rule.counted
    if options.classes is not None:
        counted = options.classes
        counted_names = {name.casefold() for name in counted}
        for name in counted:
            if name.casefold() not in known | {*folded}:
                others = sorted(str(other) for other in classes if other.casefold() not in known)
                raise InputError(
                    f"there is no class {name!r}; the classes are {', '.join(rule.known)}"
                    + (f", the files also have {', '.join(others)}" if others else ""),
                    file=lines.files[0].name if lines.files else None,
                )
    neutral = {name.casefold() for name in rule.ignored} - counted_names
    if options.role == "detections":
        neutral = set()
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
        say("If one of them is {a_one}, name it as a class that counts."),
        role=options.role,
        example=lambda row: str(label[row]),
        steps=(Step(Remedy.CLASSES),),
    )
    findings += lines.finding(
        np.full(len(label), not is_wanted.any()),
        "no-counted-class",
        f"No row is of a class that counts ({', '.join(counted)}); found "
        f"{', '.join(sorted(str(name) for name in classes))}.",
        say("Name the classes that are {many}."),
        role=options.role,
        example=lambda row: str(label[row]),
        steps=(Step(Remedy.CLASSES, ",".join(filter(options.objects.counts, map(str, classes)))),),
    )
    if options.classes is None and len(label):
        present = [name for name in classes if name.casefold() in counted_names]
        by_name = dict(zip(classes, np.bincount(codes), strict=True))
        rest = {str(name): int(n) for name, n in by_name.items() if name not in present}
        severity = Severity.NOTE if rule.is_benchmark else Severity.WARNING
        findings += kinds_finding(
            present or counted[:1], rest, options, lines.files[0].name, severity
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
