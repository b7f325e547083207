"""Notes: messages to users as keys with values, and the templates that render them.

The entry ``[given]`` of ``notes.toml`` in the package of the subject ``alerts`` renders the note
``alerts.given``. Topics of the core have their files in this package, such as ``verdict.toml``. An
entry has a Jinja2 template ``text`` and templates for other forms of the same note (``short``). If
the note has values, the entry has an ``example`` of them, in which a table with a key ``note`` is a
note itself. Line breaks of a template become spaces.

Templates use the values of the note, the words for the objects (``{{ one }}``, ``{{ many }}``, see
`nvcore.common.wording.objects`) and the filters of `_FILTERS`. A note among the values is rendered
in place, and a list of notes as "one, another and a third". Undefined names are errors. The result
is plain text, which the caller escapes for its medium.
"""

from __future__ import annotations

import tomllib
from collections.abc import Callable, Iterable, Mapping
from functools import cache
from importlib import resources
from typing import TYPE_CHECKING, Any, Final

from nvcore.common.subject import subjects
from nvcore.common.wording import (
    capitalised,
    count_text,
    duration_text,
    listed,
    number,
    p_text,
    percent,
)
from nvcore.comparison.measures.table import difference_text, inference_of, size_text
from nvcore.notes.caveats import caveats
from nvcore.settings.objects import Objects

if TYPE_CHECKING:
    from jinja2 import Environment, Template

TEXT: Final = "text"


class Note:
    """A message to the user: the key of a template and the values that fill it.

    Values of None are dropped, so that templates can test whether a value ``is defined``.

    Examples
    --------
    >>> Note("alerts.of_kind", n=2, name="needed")["n"]
    2
    """

    def __init__(self, key: str, /, **values: Any):
        self.key = key
        self.fields = {name: value for name, value in values.items() if value is not None}

    def __getitem__(self, name: str) -> Any:
        return self.fields[name]

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Note) and vars(self) == vars(other)

    def __hash__(self) -> int:
        return hash(self.key)

    def __repr__(self) -> str:
        given = "".join(f", {name}={value!r}" for name, value in self.fields.items())
        return f"Note({self.key!r}{given})"


def say(note: Note, objects: Objects, form: str = TEXT) -> str:
    """Render a note as a sentence that begins with a capital letter.

    Parameters
    ----------
    form
        Name of the template in the entry; ``text`` is used if there is no such template.

    Examples
    --------
    >>> from nvcore.settings.objects import PEDESTRIAN
    >>> say(Note("alerts.no_oracle"), PEDESTRIAN)
    'The oracle has no effect because it is not known whether the driver sees a pedestrian.'
    """
    return capitalised(phrase(note, objects, form))


def phrase(note: Note, objects: Objects, form: str = TEXT) -> str:
    """Render a note as a phrase for use within a sentence, without capitalizing it."""
    own = {"_objects": objects, "_form": form}
    return _template(note.key, form).render({**objects.words, **note.fields, **own})


def has_form(note: Note, form: str) -> bool:
    """Return whether a note's entry has a template of this form, such as ``short``."""
    return form in _entry(note.key)


def _entry(key: str) -> dict[str, Any]:
    topic, _, name = key.partition(".")
    return entries(topic)[name]


@cache
def entries(topic: str) -> dict[str, dict[str, Any]]:
    """Return the entries of a topic's TOML file by name (the part of a key after the dot)."""
    package = next((of.__module__ for of in subjects() if of.name == topic), "")
    place = resources.files(package or __name__)
    return tomllib.loads((place / f"{'notes' if package else topic}.toml").read_text("utf-8"))


@cache
def _template(key: str, form: str) -> Template:
    entry = _entry(key)
    return _environment().from_string(" ".join(entry.get(form, entry[TEXT]).split()))


@cache
def _environment() -> Environment:
    from jinja2 import Environment, StrictUndefined, pass_context  # 50 ms: import when needed

    @pass_context
    def worded(context: Mapping[str, Any], value: Any) -> Any:
        if isinstance(value, Note):
            return phrase(value, context["_objects"], context["_form"])
        if isinstance(value, tuple | list):
            return listed([str(worded(context, each)) for each in value])
        return value

    @pass_context
    def join(context: Mapping[str, Any], values: Iterable[Any], between: str) -> str:
        return between.join(str(worded(context, value)) for value in values)

    @pass_context
    def noun(context: Mapping[str, Any], key: str) -> str:
        objects: Objects = context["_objects"]
        return objects.say(inference_of(key).noun)

    # the result is plain text; callers escape it for their medium
    environment = Environment(undefined=StrictUndefined, finalize=worded)  # noqa: S701

    @pass_context
    def of_codes(context: Mapping[str, Any], codes: Iterable[str]) -> str:
        objects: Objects = context["_objects"]
        known = {**caveats().warned, **caveats().lesser}
        return "; ".join(objects.say(known[code]) for code in codes)

    own = {"join": join, "noun": noun, "caveats": of_codes}
    environment.filters |= {**_FILTERS, **own}
    return environment


def _system(letter: str) -> str:
    """Return how texts call a system: X, Y or its name."""
    return letter.upper() if letter in ("x", "y") else letter


def _seconds(duration_s: float) -> str:
    """Return a duration with more decimals below one second: "0.40 s", "2.2 s"."""
    return f"{duration_s:.2f} s" if duration_s < 1 else f"{duration_s:.1f} s"


_FILTERS: Final[dict[str, Callable[..., str]]] = {
    "system": _system,
    "count": count_text,
    "number": number,
    "percent": percent,
    "p": p_text,
    "duration": duration_text,
    "seconds": _seconds,
    "difference": difference_text,
    "size": size_text,
    "capital": capitalised,
}
"""Filters of templates, beside those of Jinja2 and ``join``, ``noun`` and ``caveats``."""
