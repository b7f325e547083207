"""Saying facts: one room, one text for an idea; a template for each type and kind of fact."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from string import Formatter
from types import MappingProxyType
from typing import Any

from nvcore import notes
from nvcore.measures.table import inference_of
from nvcore.notes import Note
from nvcore.notes.caveats import caveats
from nvcore.objects import Objects
from nvcore.sentences.facts import Fact
from nvcore.sentences.texts import Texts
from nvcore.subjects import contributed
from nvcore.wording import capitalised, count_text, duration_text, listed, number, percent


def say(fact: Fact, objects: Objects) -> str:
    """A fact as a sentence, with a capital.

    Examples
    --------
    >>> from nvcore.objects import PEDESTRIAN
    >>> say(Note("verdict.chip_few", n=1, noun="recording", n_needed=6), PEDESTRIAN)
    'Not tested: 1 recording, 6 needed'
    """
    return capitalised(phrase(fact, objects))


def phrase(fact: Fact, objects: Objects, of_medium: Texts = MappingProxyType({})) -> str:
    """A fact as part of a sentence.

    Parameters
    ----------
    of_medium
        Templates of a medium that says some facts in another way.
    """
    if isinstance(fact, Note):
        return notes.phrase(fact, objects)
    return _Sentence(objects, of_medium).of(fact)


@cache
def all_texts() -> Texts:
    """Templates of the core and of subjects, by type of fact."""
    texts: dict[type[Fact], str | Mapping[str, str]] = {}
    for added in contributed("texts"):
        texts.update(added)
    return texts


@dataclass(frozen=True)
class _Count:
    """A number that says itself with the noun that is its format specification.

    A plural that is not the noun and an s follows a slash: "match/matches".
    """

    n: int

    def __format__(self, noun: str) -> str:
        singular, _, plural = noun.partition("/")
        return count_text(self.n, singular, plural or None)


def _system(letter: str) -> str:
    """A system as texts call it: X and Y, or by its name."""
    return letter.upper() if letter in ("x", "y") else letter


class _Sentence(Formatter):
    """Templates with facts in facts, and rows of them.

    Conversions: ``!u`` a system, X or Y, ``!n`` a count with the noun after the colon, ``!m`` the
    noun of a measure, ``!c`` what findings mean, ``!d`` a duration, ``!p`` a share in percent. What
    follows the colon of a fact follows it in the text, unless there is none (None), what follows
    that of a row of facts stands between them; by itself a row is "one, another and a third".
    """

    def __init__(self, objects: Objects, of_medium: Texts) -> None:
        self.objects = objects
        self.of_medium = of_medium

    def of(self, fact: Fact) -> str:
        """The text of a fact."""
        text = self.of_medium.get(type(fact)) or all_texts()[type(fact)]
        if not isinstance(text, str):
            text = text[fact.kind]  # type: ignore[attr-defined]  # all with several texts have one
        return self.vformat(text, (), {**self.objects.words, **vars(fact), "fact": fact})

    def convert_field(self, value: Any, conversion: str | None) -> Any:
        match conversion:
            case "u":
                return _system(value) if isinstance(value, str) else tuple(map(_system, value))
            case "n":
                return _Count(value)
            case "m":
                return self.objects.say(inference_of(value).noun)
            case "d":
                return duration_text(value)
            case "p":
                return percent(value)
            case "c":
                known = {**caveats().warned, **caveats().lesser}
                return "; ".join(self.objects.say(known[code]) for code in value)
        return super().convert_field(value, conversion)

    def format_field(self, value: Any, format_spec: str) -> str:
        if value is None:
            return ""
        if isinstance(value, Note):
            return notes.phrase(value, self.objects) + format_spec
        if isinstance(value, Fact):
            return self.of(value) + format_spec
        if isinstance(value, tuple):
            parts = [self.format_field(each, "") for each in value]
            return format_spec.join(parts) if format_spec else listed(parts)
        if format_spec.endswith("%"):
            return number(value, format_spec)
        return str(super().format_field(value, format_spec))


notes.WORD_FACT.append(phrase)
