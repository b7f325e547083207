"""A session that states how its files were read, so that a rerun reads them in the same way."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any, TypeVar

from nvcore.dataset import Dataset
from nvcore.findings import TRUTH_NAME
from nvcore.inputs.session import Session, Source

_S = TypeVar("_S", bound=Source)


def stated(session: Session, dataset: Dataset) -> Session:
    """The session as it is written: its systems named, the reading of each source stated.

    What is given stays; what was recognised, or is usual in the format, is given now.

    Parameters
    ----------
    dataset
        What was loaded from the session.
    """
    systems = zip(dataset.systems, session.systems, strict=True)
    return replace(
        session,
        truth=_stated(session, session.truth, TRUTH_NAME, dataset),
        systems=tuple(
            replace(_stated(session, source, name, dataset), name=name) for name, source in systems
        ),
    )


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
