"""Selected encounter and recordings of all pages, stored by name because rows can change."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Final

from nvcore.comparison.compare import Result
from ui.session import state, store
from ui.session.address import is_whole_number

CHOOSING_PAGES: Final = ("encounters", "saliency")
"""Pages with a `recordings_key`."""


def choose_encounter(result: Result, encounter: int) -> None:
    """Select a row of ``result.encounters`` on all pages. Ignore a row out of range."""
    if 0 <= encounter < len(result.encounters):
        choose_named(name_of(result, encounter))


def choose_named(name: str | None) -> None:
    """Select an encounter by name on all pages. None clears the selection."""
    if name is None:
        store.ENCOUNTER.pop()
    else:
        store.ENCOUNTER.set((state.workspace().n_opened, name))


def chosen_encounter(result: Result) -> int | None:
    """Return the row of the selected encounter, or None if the comparison has no such encounter."""
    name = _chosen_name()
    return encounter_of(result, name) if name else None


def name_of(result: Result, encounter: int) -> str:
    """Return an encounter's name in addresses: its recording and its track."""
    recording = result.dataset.recordings["name"].iloc[result.encounters.recording[encounter]]
    return f"{recording}:{result.encounters.track[encounter]}"


def encounter_of(result: Result, name: str) -> int | None:
    """Return the row of the encounter of that name, or None."""
    recording, _, track = name.rpartition(":")
    names = result.dataset.recordings["name"].tolist()
    if recording not in names or not is_whole_number(track):
        return None
    encounters = result.encounters
    is_it = (encounters.recording == names.index(recording)) & (encounters.track == int(track))
    return int(is_it.argmax()) if is_it.any() else None


def recordings_key(page: str) -> str:
    """Return the key of the widget with which a page selects recordings by name."""
    return f"{page}_recording_{state.workspace().n_opened}"


def rename_chosen(titles: Mapping[str, str]) -> None:
    """Update the selection after a renaming. `titles` maps old recording names to new ones."""
    recording, colon, track = _chosen_name().rpartition(":")
    if recording in titles:
        choose_named(f"{titles[recording]}{colon}{track}")
    for key in (*map(recordings_key, CHOOSING_PAGES), store.PROTOCOL_RECORDINGS.key):
        choice = store.widget(key)
        chosen: str | list[str] | None = choice.get()
        if isinstance(chosen, str):
            choice.set(titles.get(chosen, chosen))
        elif chosen:
            choice.set([titles.get(name, name) for name in chosen])


def _chosen_name() -> str:
    opening, name = store.ENCOUNTER.get()
    return name if opening == state.workspace().n_opened else ""
