"""Change a session: override facts, apply remedies, state how its inputs were read."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final, TypeVar

from nvcore.common.findings import TRUTH_NAME, Remedy, Step
from nvcore.inputs.facts import parse_size
from nvcore.inputs.session import RecordingEntry, Session, Source

if TYPE_CHECKING:
    from nvcore.dataset import Dataset
    from nvcore.settings.params import Params

_S = TypeVar("_S", bound=Source)

_OF_SOURCE: Final = {
    Remedy.CLASSES: "classes",
    Remedy.FORMAT: "format",
    Remedy.BOXES: "boxes",
    Remedy.FRAME_NAMES: "frame_names",
}
"""Fields of `Source`."""
_OF_ALL: Final = {Remedy.SIZE: "size", Remedy.RATE: "fps", Remedy.FRAMES: "frames"}
"""Arguments of `override_recordings`."""
_OF_RECORDING: Final[dict[Remedy, tuple[str, Any]]] = {
    Remedy.PICTURES: ("pictures", str),
    Remedy.FIRST_PICTURE: ("first_picture", int),
}
"""Fields of `RecordingEntry`."""


def override_recordings(
    session: Session,
    *,
    size: tuple[int, int] | None = None,
    fps: float | None = None,
    frames: str | None = None,
) -> Session:
    """Return the session with these values for all recordings. None keeps its own.

    Parameters
    ----------
    size
        (width, height), px.
    fps
        Frames per second.
    frames
        ``first:last[:step]``, or a file with one number a line.
    """
    given: dict[str, Any] = {"size": size, "fps": fps, "frames": frames}
    values = {name: value for name, value in given.items() if value is not None}
    own = [name for name in values if name != "size"] + ["width", "height"] * ("size" in values)
    dropped: dict[str, Any] = dict.fromkeys(own)
    return replace(
        session,
        recordings=tuple(replace(facts, **dropped) for facts in session.recordings),
        **values,
    )


def stated_by_recording(
    session: Session, names: Sequence[str], in_files: Sequence[str] | None = None
) -> Session:
    """Move facts about all recordings to the entry of each, so that others can be added.

    Parameters
    ----------
    names
        Names of the recordings.
    in_files
        Their names in the files. None: as the session has them.
    """
    entries = session.entries(names)
    width, height = session.size or (None, None)
    of_all = {"width": width, "height": height, "fps": session.fps, "frames": session.frames}
    stated = []
    for name, own in zip(names, in_files or names, strict=True):  # at most hundreds
        entry = entries.get(name, RecordingEntry(name))
        values: dict[str, Any] = {key: of_all[key] for key in of_all if getattr(entry, key) is None}
        if in_files is not None:
            values |= {"name": own, "title": None if own == name else name}
        stated.append(replace(entry, **values))
    return replace(session, recordings=tuple(stated), size=None, fps=None, frames=None)


def applied(session: Session, step: Step, systems: Sequence[str]) -> Session | None:
    """Return the session with a step taken, or None if only the user knows the value.

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


def stated(session: Session, dataset: Dataset) -> Session:
    """Return the session as it is written, with names of systems and ways of reading.

    Explicit options are kept. Detected options and defaults of the format become explicit.

    Parameters
    ----------
    dataset
        Dataset that was loaded from the session.
    """
    return replace(
        session,
        truth=_stated(session, session.truth, TRUTH_NAME, dataset),
        systems=tuple(
            replace(_stated(session, source, name, dataset), name=name)
            for name, source in zip(dataset.systems, session.systems, strict=True)
        ),
    )


def live_session(
    session: Session, dataset: Dataset, params: Params, *, x: str | None, y: str | None
) -> Session:
    """Return the session with the live parameters, thresholds and systems."""
    # a threshold of None counts every detection; as a parameter it would leave the system's own
    live = {x: params.threshold_x, y: params.threshold_y}
    systems = tuple(
        replace(system, threshold=live.get(name, system.threshold))
        for name, system in zip(dataset.systems, session.systems, strict=True)
    )
    settings = replace(params, threshold_x=None, threshold_y=None)
    return replace(session, systems=systems, params=settings, x=x, y=y)


def _stated(session: Session, source: _S, subject: str, dataset: Dataset) -> _S:
    read_as = dataset.read_as.get(subject)
    if read_as is None:
        return source
    taken: dict[str, Any] = {"boxes": read_as.boxes, **read_as.usual}
    files = dataset.inputs["file"][dataset.inputs["subject"] == subject]
    has_folder = any((Path(session.folder) / path).is_dir() for path in source.path)
    # in a folder the files of MOTChallenge's layout are chosen only while no format is named
    is_chosen = has_folder and files.str.contains(r"(?:gt/gt|det/det)\.txt").any()
    if not is_chosen:
        taken["format"] = read_as.format
    given = {name: value for name, value in taken.items() if getattr(source, name) is None}
    return replace(source, **given)
