"""Policies by which detections become alerts: named ones, and files of their settings.

base = "balanced"
alert_k = 0.4
alert_pause_s = 5
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any, Final

from nvcore.common.errors import InputError, ParameterError
from nvcore.common.wording import did_you_mean, listed, one_line
from nvcore.inputs.readers.base import SourceFile
from nvcore.inputs.session.toml_text import parse_toml
from nvcore.settings.params import SETTINGS

Policy = Mapping[str, Any]
"""Values by name of some or all of the settings in `POLICY_SETTINGS`."""
POLICY_SETTINGS: Final = tuple(
    name for name in SETTINGS if name.startswith("alert_") and name != "alert_oracle"
)
"""Settings of a policy. The oracle is not one of them, since no system could have it."""
MAX_BYTES: Final = 1 << 20
BASE: Final = "base"
"""Key of a file: the named policy that provides the settings missing in the file."""


POLICIES: Final[Mapping[str, tuple[str, Policy]]] = {
    "cautious": (
        "Few alerts: only near and well ahead, after half a second, then five seconds of silence.",
        {
            "alert_k": 0.75,
            "alert_corridor": 0.5,
            "alert_on_s": 0.5,
            "alert_off_s": 0.5,
            "alert_least_s": 1.0,
            "alert_pause_s": 5.0,
        },
    ),
    "balanced": (
        "The defaults: from the nearness on that counts, after two tenths of a second.",
        {},
    ),
    "eager": (
        "Early alerts: from afar and in the whole picture, at the first box, without a pause.",
        {
            "alert_k": 0.25,
            "alert_corridor": 1.0,
            "alert_on_s": 0.0,
            "alert_off_s": 0.2,
            "alert_least_s": 0.5,
            "alert_pause_s": 0.0,
        },
    ),
}
"""Named policies with a sentence each. Missing settings have their defaults. All are our choice."""


def named_policy(name: str) -> dict[str, Any]:
    """Return all values of a named policy, including None.

    Raises
    ------
    ParameterError
        If there is none of this name.
    """
    if name not in POLICIES:
        hint = did_you_mean(name, POLICIES, f"they are {listed([*POLICIES])}")
        raise ParameterError(f"there is no policy {one_line(name)!r}; {hint}")
    default = {name: SETTINGS[name].default for name in POLICY_SETTINGS}
    return {**default, **POLICIES[name][1]}


def policy_from(text: str | Path) -> dict[str, Any]:
    """Return the policy with this name, or else that of the file at this path.

    Raises
    ------
    InputError, ParameterError
        See `named_policy` and `read_policy`.
    """
    path = Path(text)
    if str(text) in POLICIES or not (path.suffix or path.exists()):
        return named_policy(str(text))
    return read_policy(SourceFile(path, str(text)))


def read_policy(file: SourceFile) -> dict[str, Any]:
    """Read a policy from a TOML file.

    Settings that neither the file nor its base has get their defaults.

    Raises
    ------
    InputError
        If it is not TOML, has a key that is not a setting of a policy, or a value outside its range
        (with the line).
    """
    if file.is_larger_than(MAX_BYTES):
        raise InputError("is too large for a policy", file=file.name)
    with file.open() as stream:
        content = stream.read()
    values = parse_toml(content, file=file.name)
    name = BASE
    try:
        policy = named_policy(str(values.pop(BASE, "balanced")))
        for name, value in values.items():
            if name not in POLICY_SETTINGS:
                known = (BASE, *POLICY_SETTINGS)
                hint = did_you_mean(name, known, f"its keys are {', '.join(known)}")
                raise ParameterError(f"a policy has no {one_line(name)!r}; {hint}")
            SETTINGS[name].check(name, value)
            policy[name] = value
    except ParameterError as error:
        # tomllib does not keep the line of a key
        key = re.compile(rf"""\s*\[?\s*["']?{re.escape(name)}["']?\s*[].=]""")
        at = (n for n, line in enumerate(content.decode().splitlines(), 1) if key.match(line))
        raise InputError(str(error), file=file.name, line=next(at, None)) from error
    return policy
