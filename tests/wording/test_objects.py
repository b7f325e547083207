"""What the boxes are of, and our texts in the words for it."""

from __future__ import annotations

import pytest

from nvcore.objects import PEDESTRIAN, SPEED_SIGN, Objects, objects_from

CYCLIST = objects_from("cyclist")


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("3 pedestrians", "3 speed signs"),
        ("Pedestrian boxes", "Speed sign boxes"),
        ("half the pedestrian's width", "half the speed sign's width"),
        ("a pedestrian whom nothing matches", "a speed sign that nothing matches"),
        ("distant pedestrians, who do not count", "distant speed signs, which do not count"),
        ("Detections that match nobody.", "Detections that match nothing."),
        ("Nobody is annotated", "Nothing is annotated"),
        ("a real pedestrian whom nobody annotated", "a real speed sign that nobody annotated"),
        ("boxes that people drew in the pictures", "boxes that people drew in the pictures"),
        ("frames rather than persons", "frames rather than speed signs"),
        ("matches him by his box; he is there", "matches it by its box; it is there"),
        ("ped 12, ped. 3", "sign 12, sign 3"),
        ("The heap is historic; impeded", "The heap is historic; impeded"),
    ],
)
def test_a_text_of_ours_is_said_of_speed_signs(text: str, expected: str):
    assert SPEED_SIGN.words(text) == expected


def test_of_pedestrians_every_text_stays_as_it_is():
    text = "A pedestrian whom nobody matches, ped. 3, his feet"
    assert PEDESTRIAN.words(text) is text


def test_the_article_goes_with_the_name():
    assert (
        objects_from("animal").words("A pedestrian and a pedestrian") == "An animal and an animal"
    )


@pytest.mark.parametrize(
    "name", ["Pedestrian_v2", "pedestrian detector A", "ped-net", "people/too far", "he", "his car"]
)
@pytest.mark.parametrize("escape", [str, lambda name: name.replace("_", r"\_").replace("-", r"\-")])
def test_names_that_users_gave_stay(name: str, escape):  # type: ignore[no-untyped-def]
    text = f"{escape(name)} misses 3 pedestrians in {escape(name)}."
    expected = f"{escape(name)} misses 3 speed signs in {escape(name)}."
    assert SPEED_SIGN.words(text, names=[name]) == expected


def test_a_name_that_begins_with_a_word_of_ours_does_not_keep_the_word_elsewhere():
    text = "pedestrian 1 of pedestrian_1; the pedestrian"
    assert SPEED_SIGN.words(text, names=["pedestrian_1", "pedestrian_27"]) == (
        "speed sign 1 of pedestrian_1; the speed sign"
    )


def test_a_name_that_was_cut_stays_as_well():
    name = "pedestrian detector of the second supplier"
    assert SPEED_SIGN.words("X: pedestrian detector of… misses a pedestrian", names=[name]) == (
        "X: pedestrian detector of… misses a speed sign"
    )


def test_classes_in_files_are_told_by_their_names():
    assert PEDESTRIAN.counts("Person")
    assert PEDESTRIAN.is_lookalike("__ignore__")
    assert SPEED_SIGN.counts("Speed limit (50km/h)")
    assert not SPEED_SIGN.counts("End of speed limit (80km/h)")
    assert SPEED_SIGN.is_lookalike("traffic sign")
    assert objects_from(["child", "children"]).counts("Children")
    assert not CYCLIST.is_lookalike("cyclist")
    assert CYCLIST.is_lookalike("DontCare")


def test_known_objects_are_found_by_either_of_their_names():
    assert objects_from("Speed signs") is SPEED_SIGN
    assert objects_from(["pedestrian", "pedestrians"]) is PEDESTRIAN
    assert objects_from(SPEED_SIGN) is SPEED_SIGN
    assert (CYCLIST.singular, CYCLIST.plural) == ("cyclist", "cyclists")


@pytest.mark.parametrize(
    "names", ["", "*cyclist*", "3", "a  b", "x" * 41, ["a", "b", "c"], [], ["car", ""]]
)
def test_what_is_no_name_is_refused(names: str | list[str]):
    with pytest.raises(ValueError, match="expected a"):
        objects_from(names)


def test_a_session_names_them_only_where_they_are_others():
    assert PEDESTRIAN.given() is None
    assert SPEED_SIGN.given() == "speed sign"
    assert objects_from(["child", "children"]).given() == ["child", "children"]
    assert objects_from(objects_from(["child", "children"]).given() or ()) == Objects(
        "child", "children", frozenset({"child", "children"})
    )
