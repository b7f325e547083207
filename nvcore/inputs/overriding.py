"""Facts of recordings that flags and keywords give, in place of those of the session."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from nvcore.inputs.session import Session


def override_recordings(
    session: Session,
    *,
    size: tuple[int, int] | None = None,
    fps: float | None = None,
    frames: str | None = None,
) -> Session:
    """The session with these values for all recordings; None keeps what the session says.

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
    recordings = tuple(replace(facts, **dropped) for facts in session.recordings)
    return replace(session, recordings=recordings, **values)
