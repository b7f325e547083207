"""What the boxes are of: which classes of files count, and by which names they are known."""

from __future__ import annotations

import pytest

from nvcore.settings.objects import PEDESTRIAN, SPEED_SIGN, Objects, objects_from

CYCLIST = objects_from("cyclist")


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
