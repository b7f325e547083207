"""Data page: fields for the names of systems, recordings and objects."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import replace
from pathlib import PurePosixPath
from typing import Final

import streamlit as st

from nvcore.common.file_kinds import unpacked_name
from nvcore.common.wording import capitalised
from nvcore.inputs.files.find import system_names
from nvcore.inputs.readers.meaning.names import NEUTRAL
from nvcore.inputs.session import RecordingEntry, Session, Source
from nvcore.settings.objects import KINDS, PEDESTRIAN, Objects, objects_from
from ui.session import state, store
from ui.widgets.text import plain


def proposed_names(
    systems: Sequence[Sequence[str]],
    truth: Sequence[str],
    recordings: Sequence[str],
    *,
    first: int = 1,
) -> list[str]:
    """Propose names of systems from their paths, or numbers if a path says nothing.

    Names of the ground truth, its recordings and their pictures are not used for systems. `first`
    is the number of the first system.

    Examples
    --------
    >>> proposed_names([["RRC/0016.txt"], ["PointRCNN/0016.txt"]], [], ["0016"])
    ['RRC', 'PointRCNN']
    >>> proposed_names([["0016.txt"], ["0016.txt"]], ["0016.txt"], ["0016"])
    ['System 1', 'System 2']
    """
    names_in_use = [*recordings, *(PurePosixPath(unpacked_name(path)).stem for path in truth)]
    numbered = [
        Source((f"System {number}/{paths[0]}",))
        for number, paths in enumerate(systems, start=first)
        if paths
    ]
    names = iter(system_names(numbered, names_in_use))
    return [next(names) if paths else "" for paths in systems]


def draw_name(label: str, proposed: str, *, key: str, changed: Callable[[], None]) -> str:
    """Draw a field for a name, which shows the proposed one until the visitor types another."""
    field, last_proposal = store.widget(key, ""), store.PROPOSED_NAMES.of(key)
    if field.get() in ("", last_proposal.get()):
        field.set(proposed)
    last_proposal.set(proposed)
    typed = st.text_input(label, key=key, on_change=changed, placeholder="told by the files")
    return (typed or "").strip() or proposed


def draw_recording(
    recordings: Sequence[str], pictures: Iterable[str], *, place: str, changed: Callable[[], None]
) -> str:
    """Draw the field for the name of the only recording. Return "" for none or several.

    If its file has a generic name such as ``gt``, the pictures propose the name.
    """
    if len(recordings) != 1:
        return ""
    proposed, labels = recordings[0], list(pictures)
    if proposed.lower() in NEUTRAL and len(labels) == 1:
        proposed = PurePosixPath(labels[0]).stem
    key = f"recording_name_{place}"
    name = draw_name("Name of the recording", proposed, key=key, changed=changed)
    if name.lower() in NEUTRAL:
        st.caption("The file's name does not tell which recording this is: type its name.")
    return name


def with_recording_name(session: Session, recordings: Sequence[str], name: str) -> Session:
    """Return the session with this name for its only recording."""
    if len(recordings) != 1 or not name or name == recordings[0]:
        return session
    entry = next(iter(session.recordings), RecordingEntry(name))
    return replace(session, recordings=(replace(entry, name=name),))


OTHER: Final = "something else"


def draw_objects(place: str, changed: Callable[[], None]) -> Objects:
    """Ask for the kind of objects. Pedestrians are used if the text is no name.

    Parameters
    ----------
    place
        Part of the page, for the keys of the widgets.
    changed
        Called when the answer changes.
    """
    left, right = st.columns([1, 3])
    names = [*KINDS, OTHER]
    now = state.opened().dataset.objects.singular
    kind = left.selectbox(
        "The boxes are of",
        names,
        index=names.index(now) if now in KINDS else 0,
        format_func=lambda name: capitalised(KINDS[name].plural if name in KINDS else name),
        key=f"objects_{place}",
        on_change=changed,
        help="Decides which classes of a file count, and what the pages call them.",
    )
    if kind in KINDS:
        return KINDS[kind]
    name = right.text_input(
        "One of them, and several",
        key=f"objects_named_{place}",
        on_change=changed,
        placeholder="cyclist, or child, children",
        help="In the singular; the plural after a comma, unless it ends in s.",
    )
    if not name.strip():
        return PEDESTRIAN
    try:
        return objects_from([part.strip() for part in name.split(",")])
    except ValueError as error:
        right.error(f"{plain(capitalised(str(error)))}. Until then: pedestrians.")
        return PEDESTRIAN
