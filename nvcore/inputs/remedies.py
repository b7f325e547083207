"""A session with a remedy applied, where that is a matter of the session alone."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any, Final

from nvcore.findings import TRUTH_NAME, Remedy, Step
from nvcore.inputs.facts import parse_size
from nvcore.inputs.overriding import override_recordings
from nvcore.inputs.session import RecordingEntry, Session

_OF_SOURCE: Final = {
    Remedy.CLASSES: "classes",
    Remedy.FORMAT: "format",
    Remedy.BOXES: "boxes",
    Remedy.FRAME_NAMES: "frame_names",
}
"""Fields of `Source`."""
_OF_ALL: Final = {Remedy.SIZE: "size", Remedy.RATE: "fps", Remedy.FRAMES: "frames"}
"""What `override_recordings` takes."""
_OF_RECORDING: Final[dict[Remedy, tuple[str, Any]]] = {
    Remedy.PICTURES: ("pictures", str),
    Remedy.FIRST_PICTURE: ("first_picture", int),
}
"""Fields of `RecordingEntry`."""


def applied(session: Session, step: Step, systems: Sequence[str]) -> Session | None:
    """The session with a step taken; None: it needs the user, who alone knows the value.

    Parameters
    ----------
    systems
        Names of the session's systems, in their order.
    """
    remedy, value = step.remedy, step.value
    if not value:
        return None
    if remedy in _OF_ALL:
        parse: Any = {Remedy.SIZE: parse_size, Remedy.RATE: float}.get(remedy, str)
        return override_recordings(session, **{_OF_ALL[remedy]: parse(value)})
    if remedy in _OF_RECORDING:
        name, parse = _OF_RECORDING[remedy]
        entries = session.entries([step.subject])
        entry = entries.get(step.subject, RecordingEntry(step.subject))
        entries[step.subject] = replace(entry, **{name: parse(value)})
        return replace(session, recordings=tuple(entries.values()))
    if remedy is Remedy.ACCEPT:
        return replace(session, accept=tuple(dict.fromkeys([*session.accept, value])))
    if remedy not in _OF_SOURCE:
        return None
    given: Any = tuple(value.split(",")) if remedy is Remedy.CLASSES else value
    changed = {_OF_SOURCE[remedy]: given}
    return replace(
        session,
        truth=replace(session.truth, **changed if step.subject in ("", TRUTH_NAME) else {}),
        systems=tuple(
            replace(system, **changed) if step.subject in ("", name) else system
            for name, system in zip(systems, session.systems, strict=True)
        ),
    )
