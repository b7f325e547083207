"""Kinds of annotated objects: pedestrians, speed signs, or others named by a session.

Texts about them are templates (`nvcore.common.wording.objects`), filled by `Objects.say`.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Final

from nvcore.common.wording.objects import words_for

NEUTRAL: Final = frozenset({"ignore", "ignored", "ignoreregion", "ignoredregions", "dontcare"})
"""Classes of boxes that the truth itself excludes, whatever the objects are."""

MOST_LETTERS: Final = 40
_NAME: Final = re.compile(r"[^\W\d_][^\W_]*(?:[ -][^\W_]+)*")
_UNITS: Final = frozenset({"", "kmh", "kph", "mph"})
"""Letters next to the number of a class that consists only of a number."""
_JOINTS: Final = str.maketrans("", "", " _-")


@dataclass(frozen=True)
class Objects:
    """Kind of objects that the truth annotates and the systems should detect.

    Attributes
    ----------
    singular, plural
        Names: letters and digits, with single spaces or hyphens between words.
    classes
        Names of classes in files that count by default, in lower case and without separators.
    lookalikes
        Names of classes that could be mistaken for them. Detecting these is neither right nor
        wrong.
    kinds, manners
        Words for a subset, by themselves ("child") or next to a name of the class ("walking"). Such
        classes are lookalikes, too, unless the user says that they count.
    is_numbered
        True if a number in a class name is skipped: "speed limit (50km/h)".
    is_on_road
        True if they stand on the ground and a car could hit them. Others have no time to contact,
        and their lower edges say nothing about the horizon.

    Raises
    ------
    ValueError
        If a name is not valid.
    """

    singular: str
    plural: str
    classes: frozenset[str] = field(default=frozenset(), repr=False)
    lookalikes: frozenset[str] = field(default=NEUTRAL, repr=False)
    kinds: frozenset[str] = field(default=frozenset(), repr=False)
    manners: frozenset[str] = field(default=frozenset(), repr=False)
    is_numbered: bool = field(default=False, repr=False)
    is_on_road: bool = field(default=True, repr=False)

    def __post_init__(self) -> None:
        for name in (self.singular, self.plural):
            if len(name) > MOST_LETTERS or not _NAME.fullmatch(name):
                raise ValueError(
                    f"expected a name of letters, such as cyclist, of at most {MOST_LETTERS}; "
                    f"found {name[: MOST_LETTERS + 1]!r}"
                )

    @property
    def are_pedestrians(self) -> bool:
        """Whether the objects are pedestrians, whom texts call "they" and "who"."""
        return self == PEDESTRIAN

    def counts(self, label: str) -> bool:
        """Whether boxes with this class name count."""
        name = plain_class(label)
        return (re.sub(r"[^a-z]", "", name) if self.is_numbered else name) in self.classes

    def label_of(self, name: str) -> str:
        """Return the label that tells a class from others that count, or "" if there is none.

        For numbered classes (speed signs) this is the number without its unit. For synonyms of the
        objects it is the singular, otherwise the name itself.

        Examples
        --------
        >>> SPEED_SIGN.label_of("Speed limit (50km/h)"), SPEED_SIGN.label_of("70")
        ('50', '70')
        >>> PEDESTRIAN.label_of("Person"), PEDESTRIAN.label_of("cyclist")
        ('pedestrian', 'cyclist')
        """
        letters = re.sub(r"[^a-z]", "", plain_class(name))
        if self.is_numbered and (self.counts(name) or letters in _UNITS):
            number = re.search(r"[0-9]{1,9}", name)
            return "" if number is None else number[0].lstrip("0") or "0"
        return self.singular if self.counts(name) else name.strip()

    def is_lookalike(self, label: str) -> bool:
        """Whether a class could be mistaken for one that counts, by its name."""
        return plain_class(label) in self.lookalikes or self.is_kind(label)

    def is_kind(self, label: str) -> bool:
        """Whether a class name means a subset of these objects, such as "child" for pedestrians.

        Examples
        --------
        >>> [*map(PEDESTRIAN.is_kind, ["child", "human.pedestrian.police_officer", "person"])]
        [True, True, False]
        """
        words = re.findall(r"[a-z]+", re.sub(r"(?<=[a-z])(?=[A-Z])", " ", label.strip()).lower())
        kind = "".join(word for word in words if word not in self.classes)
        is_called_so = len(kind) < len("".join(words))
        if not kind:
            return is_called_so and plain_class(label) not in self.classes | self.lookalikes
        return kind in self.kinds or (is_called_so and kind in self.manners)

    def concerns(self, label: str) -> bool:
        """Whether boxes with this class name are counted or ignored."""
        return self.counts(label) or self.is_lookalike(label)

    def say(self, text: str, /, **values: object) -> str:
        """Fill a template with the words for these objects and with values.

        Parameters
        ----------
        text
            Format template with words of `nvcore.common.wording.objects`, and fields for `values`.
            User input, such as names of recordings, must always be a value, never part of the
            template.

        Examples
        --------
        >>> PEDESTRIAN.say("{A_one} {whom} {system} misses", system="X")
        'A pedestrian whom X misses'
        >>> SPEED_SIGN.say("{A_one} {whom} {system} misses", system="{one}")
        'A speed sign that {one} misses'
        """
        return text.format_map({**self.words, **values})

    @property
    def words(self) -> Mapping[str, str]:
        """Words for these objects, for use in templates."""
        return words_for(self.singular, self.plural, are_people=self.are_pedestrians)

    def given(self) -> str | list[str] | None:
        """Return the names to write to a session file, or None for pedestrians, the default."""
        if self.are_pedestrians:
            return None
        is_known = KINDS.get(self.singular) == self
        return self.singular if is_known else [self.singular, self.plural]


def labels_in_order(labels: Iterable[str]) -> tuple[str, ...]:
    """Sort labels and drop duplicates. Numbers come first, by value.

    Examples
    --------
    >>> labels_in_order(["no limit", "100", "30", "100"])
    ('30', '100', 'no limit')
    """

    def rank(label: str) -> tuple[bool, int, str]:
        is_number = label.isascii() and label.isdecimal()
        return not is_number, len(label) if is_number else 0, label

    return tuple(sorted(set(labels), key=rank))


def plain_class(label: str) -> str:
    """Normalize a class name: lower case, no separators (``__ignore__`` becomes ``ignore``)."""
    return label.strip().lower().translate(_JOINTS)


PEDESTRIAN: Final = Objects(
    "pedestrian",
    "pedestrians",
    classes=frozenset({"person", "persons", "pedestrian", "pedestrians", "ped", "human"}),
    kinds=frozenset(
        {
            *("child", "children", "kid", "kids", "boy", "girl", "baby", "toddler", "teenager"),
            *("adult", "adults", "man", "men", "woman", "women", "male", "female", "elderly"),
            *("worker", "workers", "constructionworker", "roadworker", "policeman", "firefighter"),
            *("policeofficer", "officer", "soldier", "wheelchair", "wheelchairuser", "stroller"),
            *("personalmobility", "skater", "skateboarder", "runner", "jogger"),
        }
    ),
    manners=frozenset(
        {
            *("sitting", "standing", "walking", "running", "lying", "bending", "crouching"),
            *("static", "other", "police", "inwheelchair", "onwheelchair", "withwheelchair"),
            *("withstroller", "pushingstroller", "withbicycle", "withbike", "withdog"),
        }
    ),
    lookalikes=NEUTRAL
    | {
        *("people", "person?", "personfa", "group", "persongroup", "crowd"),
        *("cyclist", "bicyclist", "bicycledriver", "motorcyclist", "motorbikedriver", "rider"),
        *("personsitting", "sittingperson", "sitting", "staticperson", "persononvehicle"),
    },
)
SPEED_SIGN: Final = Objects(
    "speed sign",
    "speed signs",
    classes=frozenset(
        {
            *("speedsign", "speedsigns", "speedlimit", "speedlimits", "speedlimitsign"),
            *("speedlimitsigns", "speedlimitkmh", "speedlimitkph", "speedlimitmph", "maxspeed"),
            *("maximumspeed", "maximumspeedlimit", "regulatorymaximumspeedlimitg"),
        }
    ),
    lookalikes=NEUTRAL | {"sign", "signs", "trafficsign", "trafficsigns"},
    is_numbered=True,
    is_on_road=False,
)
KINDS: Final = {kind.singular: kind for kind in (PEDESTRIAN, SPEED_SIGN)}
"""Objects whose classes the readers know."""


def objects_from(names: str | Sequence[str] | Objects) -> Objects:
    """Return the kind of objects with these names.

    Parameters
    ----------
    names
        One of `KINDS`, or any other singular, followed by its plural unless that only adds an s.
        Classes with either name count.

    Raises
    ------
    ValueError
        If there is no valid name, or more than two.

    Examples
    --------
    >>> objects_from("speed signs") is SPEED_SIGN, objects_from(["child", "children"]).plural
    (True, 'children')
    """
    if isinstance(names, Objects):
        return names
    singular, *plurals = [names] if isinstance(names, str) else [*names] or [""]
    if len(plurals) > 1:
        raise ValueError(f"expected a singular and its plural, found {len(plurals) + 1} names")
    plural = plurals[0] if plurals else f"{singular}s"
    for kind in KINDS.values():
        if singular.casefold() in (kind.singular, kind.plural) and (
            not plurals or plural.casefold() == kind.plural
        ):
            return kind
    classes = frozenset({plain_class(singular), plain_class(plural)})
    return Objects(singular, plural, classes, NEUTRAL - classes)
