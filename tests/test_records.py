"""Tables of TOML and JSON as dataclasses: types, paths of errors, and what is refused."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Literal

import pytest

from nvcore.common.records import convert, decode, parse_json, values_of


@dataclass(frozen=True)
class Light:
    kind: Literal["sun", "lamp"]
    lux: float = 1.0

    def __post_init__(self) -> None:
        if self.lux < 0:
            raise ValueError("lux: expected 0 or more")


PLACE = {"lights": tuple[Light, ...], "of": Mapping[str, int], "size": tuple[int, int] | None}


@pytest.mark.parametrize(
    ("declared", "value", "expected"),
    [
        (float, 3, 3.0),
        (bool, True, True),
        (str | None, None, None),
        (bool | int | str | None, "a", "a"),
        (tuple[str, ...] | str, ["a"], ("a",)),
        (tuple[str, ...] | str, "a", "a"),
        (tuple[Light, ...], [{"kind": "sun", "more": 1}], (Light("sun"),)),
        (Mapping[str, int], {"a": 1}, {"a": 1}),
        (object, [1, "a"], [1, "a"]),
    ],
)
def test_values_are_converted_to_the_declared_type(declared: Any, value: object, expected: object):
    converted = convert(declared, value, "here")
    assert (type(converted), converted) == (type(expected), expected)


@pytest.mark.parametrize(
    ("content", "message"),
    [
        ([], "the record: expected a table, found []"),
        ({"lights": {}}, "lights: expected a list of tables, found {}"),
        ({"lights": [{"kind": "sun"}, 3]}, "lights 2: expected a table, found 3"),
        ({"lights": [{"lux": 1}]}, "lights 1: expected a kind"),
        ({"lights": [{"kind": "moon"}]}, "lights 1: kind: expected one of sun, lamp, found 'moon'"),
        ({"lights": [{"kind": []}]}, "lights 1: kind: expected one of sun, lamp, found []"),
        (
            {"lights": [{"kind": "sun", "lux": True}]},
            "lights 1: lux: expected a number, found True",
        ),
        ({"lights": [{"kind": "sun", "lux": -1}]}, "lights 1: lux: expected 0 or more"),
        ({"of": {"a": 1.0}}, "of: a: expected a whole number, found 1.0"),
        ({"of": 1}, "of: expected a table of whole numbers, found 1"),
        ({"size": [1, 2, 3]}, "size: expected two whole numbers, found [1, 2, 3]"),
        ({"seize": [1, 2]}, "the record has no key 'seize'; did you mean 'size'? Its keys are"),
    ],
)
def test_errors_name_the_path_and_what_was_expected_and_found(content: object, message: str):
    with pytest.raises(ValueError, match=f"^{re.escape(message)}"):
        values_of(PLACE, content, "")


def test_other_keys_can_be_ignored():
    content = {"lights": [], "other": 1}
    assert values_of(PLACE, content, "", known_only=False) == {"lights": ()}


def test_a_number_of_hundreds_of_digits_is_no_float():
    with pytest.raises(ValueError, match="lux: expected a number, found 1000"):
        convert(float, 10**400, "lux")


def test_fields_with_a_default_can_be_asked_for():
    assert decode(Light, {"kind": "sun"}, "light") == Light("sun")
    with pytest.raises(ValueError, match="light: expected a lux"):
        decode(Light, {"kind": "sun"}, "light", complete=True)


def test_a_long_key_is_shortened_in_the_error():
    with pytest.raises(ValueError, match="the record has no key") as caught:
        values_of(PLACE, {"k" * 10**6: 1}, "")
    assert len(str(caught.value)) < 300


@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "utf-16"])
def test_json_of_windows_editors_is_read(encoding: str):
    assert parse_json('{"name": "Überland"}'.encode(encoding)) == {"name": "Überland"}


def test_more_tables_than_allowed_are_not_looked_at():
    content = {"lights": [{}] * 100_001}
    with pytest.raises(ValueError, match="lights: expected at most 100,000 entries"):
        values_of(PLACE, content, "")


@pytest.mark.parametrize("text", ["NaN", "[-Infinity]", "1e999"])
def test_json_holds_finite_numbers_only(text: str):
    with pytest.raises(ValueError, match="JSON numbers must be finite"):
        parse_json(text.encode())
