"""Detector settings: dataclass fields with a description and a range."""

from __future__ import annotations

import re
from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import MISSING, Field, dataclass, field, fields
from typing import Any, Final, TypeVar

from nvcore.common.wording import did_you_mean, listed
from nvcore.dataset.provenance import Setting
from nvcore.subjects.detectors.base import DetectorError

AnySettings = TypeVar("AnySettings")

_SEPARATOR: Final = re.compile(r"[,\s]+")
_YES: Final = {"true": True, "yes": True, "1": True, "false": False, "no": False, "0": False}


@dataclass(frozen=True)
class SettingFacts:
    """Description and valid values of a setting, in addition to its name, type and default.

    Attributes
    ----------
    meaning
        Description in a sentence or two.
    low, high
        Range of a number, both ends included.
    choices
        Possible texts with their meanings. Empty: any text, or a number.
    multiple_of
        Valid numbers between `low` and `high` are multiples of this. None: all.
    """

    meaning: str
    low: float | None = None
    high: float | None = None
    choices: Mapping[str, str] | None = None
    multiple_of: int | None = None


def setting(default: Any, meaning: str, **facts: Any) -> Any:
    """Return a dataclass field for a setting. See `SettingFacts`."""
    return field(default=default, metadata={"facts": SettingFacts(meaning, **facts)})


def facts_of(spec: Field[Any]) -> SettingFacts:
    """Return the facts of a field made by `setting`."""
    facts: SettingFacts = spec.metadata["facts"]
    return facts


def settings_from(kind: type[AnySettings], given: Mapping[str, Setting]) -> AnySettings:
    """Create settings of a class from the given values and defaults.

    Parameters
    ----------
    kind
        A dataclass with fields made by `setting`.
    given
        Values by name. Texts, as from the command line, are parsed as the field's type.

    Raises
    ------
    DetectorError
        If there is no such setting, or a value is outside its range.
    """
    specs = {spec.name: spec for spec in fields(kind)}  # type: ignore[arg-type]
    check_names(given, specs)
    return kind(**{name: _checked(specs[name], value) for name, value in given.items()})


def check_names(given: Iterable[str], known: Collection[str]) -> None:
    """Raise DetectorError if a name is not that of a setting."""
    for name in given:
        if name not in known:
            hint = did_you_mean(name, known, f"there are {listed([*known])}")
            raise DetectorError(f"there is no setting {name!r}; {hint}")


def typed_like(
    settings: object, given: Mapping[str, Setting | Sequence[Setting]]
) -> dict[str, Any]:
    """Parse texts as the types of the settings of these names. Other values stay the same.

    Several values may be a sequence or one text, separated by commas or spaces. A single value may
    stand by itself. Unknown names keep their values for the code that checks the names.

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
    """Return a value as text for a message: "1, 1.7, 0.1", "yes", "'luv'"."""
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
    """Parse the value as a bool, int, float or str."""
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
