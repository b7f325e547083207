"""Texts that speak of the objects are templates; each is filled for every kind of objects."""

from __future__ import annotations

import ast
import re
from collections import defaultdict
from collections.abc import Iterator
from pathlib import Path
from string import Formatter

import pytest
from places import ROOT

from nvcore.common.wording.objects import words_for
from nvcore.comparison.measures.table import MEASURES
from nvcore.settings.objects import PEDESTRIAN, SPEED_SIGN, Objects, objects_from
from nvcore.settings.params import SETTINGS

WORDS = frozenset(words_for("animal", "animals", are_people=False))
ANIMAL, CAR = objects_from("animal"), objects_from("car")
FOLDERS = ("nvcore", "ui", "pages")
OF_PEOPLE = re.compile(r"\b(pedestrians?|persons?|he|him|his|whom|feet)\b", re.IGNORECASE)


def trees() -> Iterator[tuple[Path, ast.Module]]:
    for folder in FOLDERS:
        for path in (ROOT / folder).rglob("*.py"):
            yield path.relative_to(ROOT), ast.parse(path.read_text(encoding="utf-8"))


def fields_of(text: str) -> list[str]:
    """Names of the fields of a template."""
    names = [name for _, name, _, _ in Formatter().parse(text) if name is not None]
    return [re.split(r"[.\[]", name)[0] for name in names]


def is_template(text: str) -> bool:
    try:
        return not WORDS.isdisjoint(fields_of(text))
    except ValueError:
        return False


def templates() -> dict[str, str]:
    """Every text of the source with a word of the objects, and where it stands."""
    places = {}
    for path, tree in trees():
        in_f_strings = {
            id(part) for node in ast.walk(tree) if isinstance(node, ast.JoinedStr)
            for part in ast.walk(node)
        }  # fmt: skip
        for node in ast.walk(tree):
            is_text = isinstance(node, ast.Constant) and isinstance(node.value, str)
            if is_text and id(node) not in in_f_strings and is_template(node.value):
                places[node.value] = f"{path}:{node.lineno}"
    return places


def filled(text: str, objects: Objects) -> str:
    """The template, with a dash for values that are no words of the objects."""
    words = words_for(objects.singular, objects.plural, are_people=objects.are_pedestrians)
    names = {name for name in fields_of(text) if name not in words}
    text = re.sub(rf"\{{({'|'.join(names)})[^}}]*\}}", "–", text) if names else text
    return objects.say(text)


def test_names_of_users_are_values_never_part_of_a_template():
    calls = [
        f"{path}:{node.lineno}"
        for path, tree in trees()
        for node in ast.walk(tree)
        if isinstance(node, ast.Call)
        and isinstance(node.func, ast.Name | ast.Attribute)
        and (node.func.id if isinstance(node.func, ast.Name) else node.func.attr) == "say"
        and node.args
        and any(isinstance(part, ast.FormattedValue) for part in ast.walk(node.args[0]))
        and not isinstance(node.args[0], ast.Call)
    ]
    assert calls == []


def test_each_value_of_a_template_is_given_and_no_other():
    wrong = defaultdict(list)
    for path, tree in trees():
        for node in ast.walk(tree):
            if not (isinstance(node, ast.Call) and isinstance(node.func, ast.Name | ast.Attribute)):
                continue
            name = node.func.id if isinstance(node.func, ast.Name) else node.func.attr
            text = node.args[0] if name == "say" and node.args else None
            if isinstance(text, ast.Constant) and isinstance(text.value, str):
                given = {keyword.arg for keyword in node.keywords}
                if set(fields_of(text.value)) - WORDS != given:
                    wrong[str(path)].append(text.value)
    assert wrong == {}


def test_templates_say_it_of_all_kinds_of_objects():
    places = templates()
    assert len(places) > 200
    for text, place in places.items():
        by_objects = {
            objects: filled(text, objects) for objects in (PEDESTRIAN, SPEED_SIGN, ANIMAL)
        }
        assert "{" not in by_objects[PEDESTRIAN], place
        assert not re.search(r"\b[Aa] animal", by_objects[ANIMAL]), place


@pytest.mark.parametrize(
    ("text", "of_pedestrians", "of_signs"),
    [
        ("{many} too far to count", "pedestrians too far to count", "speed signs too far to count"),
        (
            "{A_one} {whom} nothing matches is missed in {n} frames.",
            "A pedestrian whom nothing matches is missed in 3 frames.",
            "A speed sign that nothing matches is missed in 3 frames.",
        ),
        ("Who detects {what}", "Who detects whom", "Who detects what"),
        ("the {feet_are} below", "the feet are below", "the lower edge is below"),
        ("{short} 1: {them}, {their} feet", "ped 1: them, their feet", "sign 1: it, its feet"),
        ("{Nobody} is there", "Nobody is there", "Nothing is there"),
    ],
)
def test_a_template_is_filled_with_words_and_values(text, of_pedestrians, of_signs):
    assert PEDESTRIAN.say(text, n=3) == of_pedestrians
    assert SPEED_SIGN.say(text, n=3) == of_signs


def test_the_article_goes_with_the_name():
    assert ANIMAL.say("{A_one} and {a_one}") == "An animal and an animal"


@pytest.mark.parametrize("name", ["Pedestrian_v2", "{one}", "people/too far {", "them"])
def test_names_that_users_gave_stay(name: str):
    assert CAR.say("{name} misses {many}", name=name) == f"{name} misses cars"


def test_a_word_that_there_is_not_is_an_error():
    with pytest.raises(KeyError, match="ones"):
        CAR.say("{ones}")


def test_settings_and_measures_speak_of_cars():
    texts = [text for known in SETTINGS.values() for text in (known.meaning, known.label)]
    texts += [measure.meaning for measure in MEASURES]
    wordings = [CAR.say(text) for text in texts]
    assert [text for text in wordings if OF_PEOPLE.search(text)] == []
    assert CAR.say(SETTINGS["missing_distance"].meaning) == (
        "How to weigh a car without a distance in the ground truth: by height (height), or by the "
        "distance that the systems report, borrowed along the track (borrow)."
    )
