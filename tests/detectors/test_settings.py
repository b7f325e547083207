"""Settings from texts, as the command line has them."""

from __future__ import annotations

from dataclasses import dataclass

import pytest

from nvcore.subjects.detectors.base import DetectorError
from nvcore.subjects.detectors.settings import facts_of, setting, settings_from, typed_like


@dataclass(frozen=True)
class Example:
    size: int = setting(8, "Size.", low=1)
    share: float = setting(0.5, "Share.", low=0, high=1)
    is_on: bool = setting(False, "Whether.")
    way: str = setting("up", "Way.", choices={"up": "upwards", "down": "downwards"})


@dataclass(frozen=True)
class Model:
    scales: tuple[float, ...] = (1.0, 1.1)
    region: tuple[float, ...] = ()
    stride: int = 6
    blur: bool = True
    patience: int | None = None


def test_texts_are_read_as_the_type_of_the_setting():
    given = {"size": "9", "share": "1", "is_on": "Yes", "way": "down"}
    assert settings_from(Example, given) == Example(9, 1.0, True, "down")
    assert settings_from(Example, {}) == Example()


@pytest.mark.parametrize(
    ("name", "value", "words"),
    [
        ("size", "0", "size: expected at least 1, found '0'"),
        ("size", 1.5, "size: expected a whole number, found 1.5"),
        ("size", "1e999", "size: expected a whole number"),
        ("share", None, "share: expected a number, found None"),
        ("share", "inf", "share: expected 0 to 1"),
        ("is_on", "2", "is_on: expected yes or no, found '2'"),
        ("way", "left", "way: expected one of up and down, found 'left'"),
        ("siz", 1, "there is no setting 'siz'; did you mean 'size'"),
    ],
)
def test_what_it_cannot_be_is_refused(name: str, value: object, words: str):
    with pytest.raises(DetectorError, match=words):
        settings_from(Example, {name: value})  # type: ignore[dict-item]


def test_every_field_knows_its_meaning():
    spec = Example.__dataclass_fields__["share"]
    assert (facts_of(spec).meaning, facts_of(spec).high) == ("Share.", 1)


def test_texts_are_read_like_the_settings_of_a_model():
    given = {"scales": "1, 1.5 2", "region": "0 0 1 1 0.5 1", "stride": "4", "blur": "no", "a": "b"}
    assert typed_like(Model(), given) == {
        "scales": (1.0, 1.5, 2.0),
        "region": (0.0, 0.0, 1.0, 1.0, 0.5, 1.0),
        "stride": 4,
        "blur": False,
        "a": "b",
    }
    with pytest.raises(DetectorError, match="scales: expected a number, found 'x'"):
        typed_like(Model(), {"scales": "1 x"})
