"""Looks: verdicts shown on data with different settings, each of them a chance to err."""

from __future__ import annotations

import hashlib
import json
import os
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import pandas as pd

from nvcore.common.errors import InputError
from nvcore.comparison.compare import Result
from nvcore.evidence.companions import Companions


def setting_of(result: Result) -> dict[str, Any]:
    """Return what a verdict rests on: data, systems, settings and primary measure."""
    dataset = result.dataset
    return {
        "data": dataset.fingerprint,
        "recordings": sorted(map(str, dataset.recordings["name"])),
        "x": result.x.name,
        "y": result.y.name,
        "operating_point": "equal-alarms" if result.as_set else dataset.settings.operating_point,
        "primary": dataset.primary.key,
        **(result.as_set or result).params.stated(),
    }


def look_key(setting: Mapping[str, Any]) -> str:
    """Return a key of 64 characters that two looks share only if they show the same."""
    text = json.dumps(setting, sort_keys=True, default=str)
    return hashlib.sha256(text.encode()).hexdigest()


def add_look(path: str | os.PathLike[str] | None, result: Result) -> int:
    """Add a look to a file of looks, if it is new, and return how many there are.

    The file has one JSON object per line, with what each verdict rested on. Without a file, this
    is the only look.

    Raises
    ------
    InputError
        If the file holds something else, or cannot be written; with the line.
    """
    if path is None:
        return 1
    path, setting, keys = Path(path), setting_of(result), set()
    try:
        lines = path.read_text(encoding="utf-8").splitlines() if path.exists() else []
        for line, text in enumerate(lines, start=1):
            known = json.loads(text)
            if not isinstance(known, dict) or "data" not in known:
                raise InputError(f"{path.name}, line {line}: no look that nvcore wrote")
            keys.add(look_key(known))
        if look_key(setting) not in keys:
            with path.open("a", encoding="utf-8") as file:
                file.write(json.dumps(setting, sort_keys=True, default=str) + "\n")
    except OSError as error:
        raise InputError(f"{path}: looks cannot be kept ({error.strerror})") from error
    except ValueError as error:
        raise InputError(f"{path.name}, line {line}: no look that nvcore wrote") from error
    return len(keys | {look_key(setting)})


def correct_for_looks(
    evidence: pd.DataFrame, companions: Companions, n: int
) -> tuple[pd.DataFrame, Companions]:
    """Multiply each corrected p by the number of looks (Bonferroni), up to 1.

    The claims of all looks are one family: at most 5 % of series of looks without a difference end
    with a claim.
    """
    if n < 2:
        return evidence, companions
    at_equal = companions.evidence
    corrected = None if at_equal is None else _multiplied(at_equal, n)
    return _multiplied(evidence, n), replace(companions, evidence=corrected)


def _multiplied(evidence: pd.DataFrame, n: int) -> pd.DataFrame:
    return evidence.assign(p_corrected=(n * evidence["p_corrected"]).clip(upper=1.0))
