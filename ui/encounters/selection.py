"""Encounters page: which encounter is selected, and the way to the others of the list."""

from __future__ import annotations

from functools import partial

import numpy as np
import pandas as pd

from nvcore.comparison import Result
from nvcore.stages import SEVERITY, THRESHOLD
from nvcore.tables.moments import encounter_moments
from ui.session import state, store
from ui.session.chosen import choose_encounter, chosen_encounter
from ui.widgets.choices import draw_steps as draw_way


def choose(encounter: int) -> None:
    """Select an encounter by its row, in the data that are open. For callbacks."""
    result = state.result()
    if result is not None:
        choose_encounter(result, encounter)
        store.ENCOUNTER_IS_NEW.set(True)


def choose_clicked(encounter: int) -> None:
    """As `choose`, unless a button chose in the same run: the table then still has the last one."""
    if not store.HAS_STEPPED.get():
        choose(encounter)


def selected(result: Result, encounters: pd.DataFrame) -> int | None:
    """The encounter that was selected, if it is among these."""
    encounter = chosen_encounter(result)
    return encounter if encounter in encounters.index else None


def shown(result: Result, listed: pd.DataFrame) -> int:
    """The encounter that is shown: the one selected, or the first of the list."""
    encounter = selected(result, listed)
    return int(listed.index[0]) if encounter is None else encounter


def place_of(listed: pd.DataFrame, encounter: int) -> int:
    """Which of the list it is, counted from 0."""
    return int(np.flatnonzero(listed.index.to_numpy() == encounter)[0])


def moments_of(result: Result) -> pd.DataFrame:
    """`encounter_moments`, computed anew only for settings that move them."""
    settings = result.params.only_for(THRESHOLD, SEVERITY)
    return state.cached(
        "encounter_moments",
        (settings, result.x.name, result.y.name),
        lambda: encounter_moments(result),
    )


def go_along(result: Result) -> None:
    """Let the current frame be that of an encounter that was selected just now."""
    encounter = chosen_encounter(result)
    if store.ENCOUNTER_IS_NEW.pop() and encounter is not None:
        row = int(moments_of(result)["shown_row"].iloc[encounter])
        state.go_to(*state.place_of(row), writes=False)


def draw_steps(listed: pd.DataFrame, encounter: int) -> None:
    """The way through the list as it is filtered and sorted."""
    store.HAS_STEPPED.set(False)
    draw_way(
        place_of(listed, encounter), len(listed), partial(_step, listed.index), key="encounters"
    )


def _step(index: pd.Index, at: int) -> None:
    choose(int(index[at]))
    store.HAS_STEPPED.set(True)
