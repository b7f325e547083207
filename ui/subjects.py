"""What the subjects add to the dashboard."""

from __future__ import annotations

from functools import cache
from importlib import import_module
from typing import Any

from nvcore.subjects import resolve, subjects


@cache
def contributed(kind: str) -> tuple[Any, ...]:
    """What each subject adds to a list of the dashboard, of those that add to it.

    Parameters
    ----------
    kind
        Name of a reference ``"module:name"`` in `nvcore.subjects.Subject.ui`: ``"ASIDE"``
        (`ui.jobs.runs.Aside`), ``"ROUTES"`` (`ui.session.requests.Place`) or ``"STUDIES"``
        (`ui.people.studies.Studies`).
    """
    rooms = [subject.ui for _, subject in subjects().values() if subject.ui]
    return tuple(
        resolve(room, reference)
        for room in rooms
        if (reference := getattr(import_module(room), kind, ""))
    )
