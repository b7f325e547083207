"""Words for the annotated objects, for use in templates.

A text that speaks of them is a format template: "{A_one} {whom} nothing matches is missed."
`nvcore.settings.objects.Objects.say` fills it, once, where the text is made or leaves a table of
texts.
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import lru_cache
from typing import Final

_OF_PEOPLE_AND_THINGS: Final = {
    "them": ("them", "it"),
    "their": ("their", "its"),
    "who": ("who", "that"),
    "whom": ("whom", "that"),
    "what": ("whom", "what"),  # "what the driver sees"
    "nobody": ("nobody", "nothing"),
    "somebody": ("somebody", "something"),
    "everybody": ("everybody", "everything"),
    "anybody": ("anybody", "anything"),
    "feet": ("feet", "lower edge"),
    "feet_are": ("feet are", "lower edge is"),
}


@lru_cache(64)
def words_for(singular: str, plural: str, *, are_people: bool) -> Mapping[str, str]:
    """Return the words that templates use for these objects, in lower case and capitalized.

    ``one``, ``many``, ``a_one``; ``people``, where that reads better than ``many``; ``short``, for
    labels in figures; and pronouns.

    Examples
    --------
    >>> words = words_for("animal", "animals", are_people=False)
    >>> words["A_one"], words["many"], words["Their"]
    ('An animal', 'animals', 'Its')
    """
    article = "an" if singular[0].casefold() in "aeiou" else "a"
    words = {name: forms[not are_people] for name, forms in _OF_PEOPLE_AND_THINGS.items()}
    words |= {"one": singular, "many": plural, "a_one": f"{article} {singular}"}
    words["people"] = "people" if are_people else plural
    words["short"] = "ped" if are_people else singular.rpartition(" ")[2]
    return words | {_capital(name): _capital(word) for name, word in words.items()}


def _capital(text: str) -> str:
    return text[:1].upper() + text[1:]
