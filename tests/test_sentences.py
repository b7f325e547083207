"""Facts and their templates fit one another."""

from __future__ import annotations

import re
from dataclasses import fields
from string import Formatter
from typing import Literal, get_args, get_origin, get_type_hints

import pytest

from nvcore.notes import Fact, Note
from nvcore.objects import PEDESTRIAN, SPEED_SIGN
from nvcore.sentences import all_texts, say


def kinds_of(fact: type[Fact]) -> set[str]:
    """Kinds of a fact, as far as its type lists them."""
    hint = get_type_hints(fact).get("kind")
    return set(get_args(hint)) if get_origin(hint) is Literal else set()


@pytest.mark.parametrize("fact", all_texts(), ids=lambda fact: fact.__name__)
def test_a_template_names_nothing_but_fields_and_words_for_the_objects(fact: type[Fact]):
    text = all_texts()[fact]
    own = {field.name for field in fields(fact)}
    assert own.isdisjoint(PEDESTRIAN.words)
    known = own | {"fact", *PEDESTRIAN.words}
    texts = [text] if isinstance(text, str) else text.values()
    names = {name for each in texts for _, name, _, _ in Formatter().parse(each) if name}
    assert {re.split(r"[.\[]", name)[0] for name in names} <= known
    if kinds := kinds_of(fact):
        assert set(text) == kinds


def test_what_users_named_is_never_a_template_and_never_rewritten():
    fact = Note(
        "verdict.worst_failure",
        system="x", track="7", recording="{{ one }} of --fps 25 who {one}", seconds=0.5,
    )  # fmt: skip
    assert say(fact, SPEED_SIGN) == (
        "The worst single failure is X's: speed sign 7 in {{ one }} of --fps 25 who {one}, 0.5 s."
    )
