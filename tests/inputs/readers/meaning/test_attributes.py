"""What annotators say of a pedestrian, as classes of encounters."""

from __future__ import annotations

import pytest

from nvcore.inputs.readers.meaning.values import class_of, joined_classes


@pytest.mark.parametrize(
    ("name", "value", "expected"),
    [
        ("with_dog", "true", "with_dog"),
        ("with_dog", "False", ""),
        ("age", " child ", "child"),
        ("age", "unknown", ""),
        ("age", "__undefined__", ""),
        ("attributes", "child;with dog", "child;with dog"),
        ("shirt", "17", ""),
        ("height_m", "1.7e0", ""),
        ("Occluded", "true", ""),
        ("track_id", "a7", ""),
    ],
)
def test_a_switch_is_called_as_itself_a_choice_as_what_was_chosen_a_number_nothing(
    name: str, value: str, expected: str
) -> None:
    assert class_of(name, value) == expected


def test_several_classes_of_a_box_are_one_text_with_each_once() -> None:
    assert joined_classes(["child", "", "dark", "child"]) == "child;dark"
