"""Looks: verdicts shown on data with different settings, each of them a chance to err."""

from __future__ import annotations

import hashlib
import json
import os
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any, Final, NamedTuple

import pandas as pd
from filelock import FileLock

from nvcore.common.errors import InputError
from nvcore.common.output.files import write_whole
from nvcore.comparison.compare import Result
from nvcore.dataset import Dataset
from nvcore.evidence.companions import Companions
from nvcore.settings.primary import Primary
from nvcore.settings.protocols import PROTOCOLS, Protocol


class Look(NamedTuple):
    """A verdict that is shown.

    Attributes
    ----------
    number
        How many different settings were shown up to the first time that this one was.
    factor
        Multiplier of each p: ``number * (number + 1)``, or 1 for the first look at a question that
        was fixed beforehand.
    """

    number: int = 1
    factor: int = 1


ONLY_LOOK: Final = Look()
"""Look at data of which no looks are counted."""


def setting_of(result: Result, protocol: Protocol = PROTOCOLS["all"]) -> dict[str, Any]:
    """Return what a verdict rests on: data, systems, settings, protocol and primary measure."""
    dataset = result.dataset
    return {
        "data": dataset.fingerprint,
        "recordings": sorted(map(str, dataset.recordings["name"])),
        "x": result.x.name,
        "y": result.y.name,
        "operating_point": "equal-alarms" if result.as_set else dataset.settings.operating_point,
        "primary": dataset.primary.key,
        "protocol": protocol.given(),
        **(result.as_set or result).params.stated(),
    }


def look_key(setting: Mapping[str, Any]) -> str:
    """Return a key of 64 characters that two looks share only if they show the same."""
    text = json.dumps(setting, sort_keys=True, default=str)
    return hashlib.sha256(text.encode()).hexdigest()


def look_of(number: int, dataset: Dataset) -> Look:
    """Return the look of this number at some data.

    The shares of 5 % that looks may err in, ``1 / (k (k + 1))`` of it at look k, sum up to 5 %
    however many follow. A primary measure named in the session file is tested by itself, so its
    first look has all of it.
    """
    is_fixed = dataset.primary != Primary() and not dataset.primary.is_changed
    return Look(number, 1 if number == 1 and is_fixed else number * (number + 1))


def add_look(
    path: str | os.PathLike[str] | None, result: Result, protocol: Protocol = PROTOCOLS["all"]
) -> Look:
    """Add a look to a file of looks, if it is new, and return its number and factor.

    The file has one JSON object per line, with what each verdict rested on. Without a file, this
    is the only look.

    Raises
    ------
    InputError
        If the file holds something else, or cannot be written; with the line.
    """
    if path is None:
        return ONLY_LOOK
    path, setting, line = Path(path), setting_of(result, protocol), 1
    text, keys = json.dumps(setting, sort_keys=True, default=str), []
    try:
        with FileLock(path.with_name(f".{path.name}.lock")):
            before = path.read_text(encoding="utf-8").splitlines() if path.exists() else []
            for line, stated in enumerate(before, start=1):  # noqa: B007  # for the message
                known = json.loads(stated)
                if not isinstance(known, dict) or "data" not in known:
                    raise ValueError
                keys.append(look_key(known))
            if look_key(setting) not in keys:
                write_whole(path, "".join(f"{look}\n" for look in (*before, text)).encode())
                keys.append(look_key(setting))
    except OSError as error:
        raise InputError(f"{path}: looks cannot be kept ({error.strerror})") from error
    except ValueError as error:
        raise InputError(f"{path.name}, line {line}: no look that nvcore wrote") from error
    return look_of(1 + keys.index(look_key(setting)), result.dataset)


def correct_for_looks(
    evidence: pd.DataFrame, companions: Companions, look: Look
) -> tuple[pd.DataFrame, Companions]:
    """Multiply each corrected p by the factor of a look, up to 1."""
    at_equal = companions.evidence
    corrected = None if at_equal is None else multiplied(at_equal, look)
    return multiplied(evidence, look), replace(companions, evidence=corrected)


def multiplied(evidence: pd.DataFrame, look: Look) -> pd.DataFrame:
    """Return a table of evidence with each corrected p multiplied by the factor of a look."""
    return evidence.assign(p_corrected=(look.factor * evidence["p_corrected"]).clip(upper=1.0))
