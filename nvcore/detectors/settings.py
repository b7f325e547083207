"""A detector's settings: fields of a dataclass that know their meaning and range."""

from __future__ import annotations

import re
from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import MISSING, Field, dataclass, field, fields
from typing import Any, Final, TypeVar

from nvcore.dataset.provenance import Setting
from nvcore.detectors.base import DetectorError
from nvcore.wording import did_you_mean, listed

AnySettings = TypeVar("AnySettings")

_SEPARATOR: Final = re.compile(r"[,\s]+")
_YES: Final = {"true": True, "yes": True, "1": True, "false": False, "no": False, "0": False}


@dataclass(frozen=True)
class SettingFacts:
    """What is known of a setting beside its name, type and default.

    Attributes
    ----------
    meaning
        In a sentence or two.
    low, high
        Range of a number, both included.
    choices
        What a text may be, with what that means; empty: any text, or a number.
    multiple_of
        Which whole numbers between `low` and `high` are possible; None: all.
    """

    meaning: str
    low: float | None = None
    high: float | None = None
    choices: Mapping[str, str] | None = None
    multiple_of: int | None = None


def setting(default: Any, meaning: str, **facts: Any) -> Any:
    """A field of a settings class; see `SettingFacts`."""
    return field(default=default, metadata={"facts": SettingFacts(meaning, **facts)})


def facts_of(spec: Field[Any]) -> SettingFacts:
    """What is known of a field that `setting` made."""
    facts: SettingFacts = spec.metadata["facts"]
    return facts


def settings_from(kind: type[AnySettings], given: Mapping[str, Setting]) -> AnySettings:
    """Settings of this kind; what is not given has its default.

    Parameters
    ----------
    kind
        A dataclass with fields made by `setting`.
    given
        Values by name; texts, as the command line has them, are read as the field's type.

    Raises
    ------
    DetectorError
        If there is no such setting, or a value is outside its range.
    """
    specs = {spec.name: spec for spec in fields(kind)}  # type: ignore[arg-type]
    check_names(given, specs)
    return kind(**{name: _checked(specs[name], value) for name, value in given.items()})


def check_names(given: Iterable[str], known: Collection[str]) -> None:
    """Raise DetectorError if one of the names is not that of a setting."""
    for name in given:
        if name not in known:
            hint = did_you_mean(name, known, f"there are {listed([*known])}")
            raise DetectorError(f"there is no setting {name!r}; {hint}")


def typed_like(
    settings: object, given: Mapping[str, Setting | Sequence[Setting]]
) -> dict[str, Any]:
    """Texts read as the types that the settings of these names have; other values as they are.

    Several values stand in one text, with commas or spaces between, or in a sequence; a single one
    may stand by itself. What is no setting stays as it
    is, for whoever checks the names.

    Raises
    ------
    DetectorError
        If a text is not of the type.
    """
    values: dict[str, Any] = {}
    for name, value in given.items():
        before = getattr(settings, name, value)
        if isinstance(before, tuple) and isinstance(value, str):
            kind = type(before[0]) if before else float
            values[name] = tuple(
                _typed(name, kind, part) for part in _SEPARATOR.split(value) if part
            )
        elif isinstance(before, tuple):
            values[name] = tuple(value) if isinstance(value, Sequence) else (value,)
        elif isinstance(value, str) and before is not None:
            values[name] = _typed(name, type(before), value)
        else:
            values[name] = value
    return values


def value_text(value: Any) -> str:
    """A value in a message, as people write it: "1, 1.7, 0.1", "yes", "'luv'"."""
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, float):
        return f"{value:g}"
    if isinstance(value, tuple | list):
        return (
            ", ".join(map(str, (f"{v:g}" if isinstance(v, float) else v for v in value))) or "none"
        )
    return repr(value)


def _typed(name: str, kind: type, value: Setting) -> Any:
    """The value as a bool, int, float or str."""
    try:
        number = _YES[value.lower()] if kind is bool and isinstance(value, str) else value
        typed = kind(number)
        if kind is not str and float(typed) != float(number):  # type: ignore[arg-type]
            raise ValueError
    except (KeyError, TypeError, ValueError, OverflowError) as error:
        words = {bool: "yes or no", int: "a whole number", float: "a number", str: "a text"}
        raise DetectorError(f"{name}: expected {words[kind]}, found {value_text(value)}") from error
    return typed


def _checked(spec: Field[Any], value: Setting) -> Setting:
    assert spec.default is not MISSING
    facts = facts_of(spec)
    typed = _typed(spec.name, type(spec.default), value)
    if facts.choices and typed not in facts.choices:
        choices = listed([*facts.choices])
        raise DetectorError(f"{spec.name}: expected one of {choices}, found {value_text(value)}")
    low, high, step = facts.low, facts.high, facts.multiple_of
    is_within = (low is None or typed >= low) and (high is None or typed <= high)
    if not is_within or (step is not None and typed % step):
        limits = f"at least {low:g}" if high is None else f"{low:g} to {high:g}"
        if step is not None and low is not None and high is not None:
            first, last = -(-int(low) // step) * step, int(high) // step * step
            limits = f"one of {first}, {first + step}, {first + 2 * step} ... {last}"
        raise DetectorError(f"{spec.name}: expected {limits}, found {value_text(value)}")
    checked: Setting = typed
    return checked
