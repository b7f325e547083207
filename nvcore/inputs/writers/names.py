"""Names of files after recordings."""

from __future__ import annotations

import re


def safe_names(names: list[str]) -> list[str]:
    """File names of recordings: no folders, no hidden files, no two the same."""
    names_in_use: set[str] = set()
    safe = []
    for name in names:
        plain = re.sub(r"[^A-Za-z0-9._-]+", "_", name).lstrip(".") or "recording"
        candidate, number = plain, 2
        while candidate.lower() in names_in_use:
            candidate, number = f"{plain}_{number}", number + 1
        names_in_use.add(candidate.lower())
        safe.append(candidate)
    return safe
