"""Encounters page: one row per encounter, with the results of X and Y and explanations."""

from collections.abc import Sequence
from typing import Final

import pandas as pd
import streamlit as st

from nvcore.comparison.compare import Result
from nvcore.tables.result import encounters_table
from ui.session import state, store
from ui.session.chosen import choose_named, encounter_of, name_of
from ui.shell.messages import draw_notices, needs_comparison
from ui.views.encounters import address, classes, details, figures, filters, selection, table
from ui.views.encounters.order import Order
from ui.widgets.choices import look_closer
from ui.widgets.text import docs_link, plain, short_names

MEANING: Final = (
    "An {encounter} is one {one} of one recording. It counts while the {one} is near enough to "
    "matter, else it is *distant*. {severity}: seconds of {a_one} missed straight ahead and near. "
    "{miss_class}: how a system failed."
)


@st.fragment
@needs_comparison
def draw_filtered(result: Result) -> None:
    """Draw the filters and the encounters that pass. Moving a filter redraws only these."""
    encounters = encounters_table(result)
    follow_link(result, filters.class_names(encounters))
    selection.go_along(result)
    chosen, matching = filters.draw(result, encounters)
    with st.container(key="encounters_review"):
        left, right = st.columns([5, 4], gap="medium")
        with left, st.container(horizontal=True, vertical_alignment="center"):
            filters.draw_count(chosen, len(matching), len(encounters))
            table.draw_switch()
        if matching.empty:
            left.info("No encounter passes the filters: widen or clear them.")
            order = table.order()
        else:
            with left:
                order = table.draw_order()
                listed = order.sort(matching)
                encounter = selection.shown(result, listed)
                table.draw(listed, encounter)
                table.draw_map(matching)
            with right:
                details.draw(result, listed, encounter)
    if not matching.empty:
        figures.draw_classes(result, matching)
    write_address(result, matching, chosen, order)


def follow_link(result: Result, classes: Sequence[str]) -> None:
    """Apply filters, order and selection from the address or from the page that linked here."""
    link = store.PAGE_LINK.pop()  # only once: later choices on the page stay
    if link is None:
        return
    choice, wrong = address.from_address(
        link, state.recording_names(), classes, filters.possible(result)
    )
    filters.take(choice.filters)
    table.take_order(choice.order)
    if choice.has_all_columns:
        store.ALL_COLUMNS.set(True)
    name = choice.encounter
    if name is not None and encounter_of(result, name) is None:
        name, wrong = None, (*wrong, "there is no such encounter")
    choose_named(name)
    if wrong:
        st.warning(
            f"The address could not be followed in all: {plain('; '.join(wrong))}.",
            icon=":material/link_off:",
        )


def write_address(
    result: Result, matching: pd.DataFrame, chosen: filters.Filters, order: Order
) -> None:
    """Write filters, order and selection to the page's address."""
    encounter = selection.selected(result, matching)
    name = None if encounter is None else name_of(result, encounter)
    choice = address.Choice(chosen, order, store.ALL_COLUMNS.get(), name)
    state.write_address(address.to_address(choice), address.NAMES)


@needs_comparison
def draw(result: Result) -> None:
    """Draw the list of encounters, then a choice of analyses that ignore its filters."""
    if not len(result.encounters):
        state.write_address()
        st.info(
            state.say("The truth has no {many}: there is {nobody} to meet, and {nobody} to miss.")
        )
        return
    draw_notices(result)
    draw_filtered()
    x, y = map(plain, short_names(result).values())
    parts = {
        "classes": state.say("By class of {one}"),
        "misses": state.say("Do {x} and {y} miss the same {many}?", x=x, y=y),
        "fusion": "What would a fusion bring?",
    }
    match look_closer(parts, store.ENCOUNTERS_PART):
        case "classes":
            classes.draw(result)
        case "misses":
            figures.draw_exclusivity(result)
        case "fusion":
            figures.draw_fusion(result)


def explain() -> str | None:
    """Return the page's help text, or None if there is no comparison."""
    if state.result() is None:
        return None
    return state.say(
        MEANING,
        encounter=docs_link("encounter", "encounters"),
        severity=docs_link("Severity", "severity"),
        miss_class=docs_link("Miss class", "miss-classes"),
    )


st.title("Encounters", help=explain())
if state.result() is None:
    state.write_address()
draw()
