"""Encounters page: the selected encounter, and steps through the list."""

from __future__ import annotations

from functools import partial

import numpy as np
import pandas as pd

from nvcore.comparison.compare import Result
from nvcore.settings.stages import SEVERITY, THRESHOLD
from nvcore.tables.moments import encounter_moments
from ui.session import state, store
from ui.session.chosen import choose_encounter, chosen_encounter
from ui.widgets.choices import draw_steps as draw_way


def choose(encounter: int) -> None:
    """Select an encounter by its row in the open data. For callbacks."""
    result = state.result()
    if result is not None:
        choose_encounter(result, encounter)
        store.ENCOUNTER_IS_NEW.set(True)


def choose_clicked(encounter: int) -> None:
    """Select an encounter, unless a button did so in this run and the click is outdated."""
    if not store.HAS_STEPPED.get():
        choose(encounter)


def selected(result: Result, encounters: pd.DataFrame) -> int | None:
    """Return the selected encounter if it is among these."""
    encounter = chosen_encounter(result)
    return encounter if encounter in encounters.index else None


def shown(result: Result, listed: pd.DataFrame) -> int:
    """Return the encounter to show: the selected one, or the first of the list."""
    encounter = selected(result, listed)
    return int(listed.index[0]) if encounter is None else encounter


def place_of(listed: pd.DataFrame, encounter: int) -> int:
    """Return the position of an encounter in the list, counted from 0."""
    return int(np.flatnonzero(listed.index.to_numpy() == encounter)[0])


def moments_of(result: Result) -> pd.DataFrame:
    """Return `encounter_moments`, recomputed only for settings that affect them."""
    settings = result.params.only_for(THRESHOLD, SEVERITY)
    return state.cached(
        "encounter_moments",
        (settings, result.x.name, result.y.name),
        lambda: encounter_moments(result),
    )


def go_along(result: Result) -> None:
    """Move the current frame to an encounter that was just selected."""
    encounter = chosen_encounter(result)
    if store.ENCOUNTER_IS_NEW.pop() and encounter is not None:
        row = int(moments_of(result)["shown_row"].iloc[encounter])
        state.go_to(*state.place_of(row), writes=False)


def draw_steps(listed: pd.DataFrame, encounter: int) -> None:
    """Draw buttons to step through the filtered and sorted list."""
    store.HAS_STEPPED.set(False)
    draw_way(
        place_of(listed, encounter), len(listed), partial(_step, listed.index), key="encounters"
    )


def _step(index: pd.Index, at: int) -> None:
    choose(int(index[at]))
    store.HAS_STEPPED.set(True)
