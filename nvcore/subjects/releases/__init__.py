"""Releases: what a new version of a system changed, and how its measures went over versions."""

from __future__ import annotations

from collections.abc import Sequence
from typing import ClassVar

from nvcore.common import subject


class Releases(subject.Subject):
    """Versions of a system on the same recordings."""

    name = "releases"
    names: ClassVar = {"nvcore.subjects.releases.calls": ("what_changed",)}

    def commands(self) -> Sequence[subject.Command]:
        from nvcore.subjects.releases.commands import changed

        return (changed,)
