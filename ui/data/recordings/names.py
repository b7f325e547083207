"""Data page: systems and recordings are called otherwise, without reading anything again."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import pandas as pd
import streamlit as st

from nvcore.dataset import Dataset
from nvcore.errors import NvcoreError
from nvcore.inputs.session import Session
from ui.session import state, store
from ui.session.chosen import rename_chosen
from ui.session.opening import with_recordings
from ui.shell.messages import shown_error
from ui.widgets.buttons import submit_button
from ui.widgets.text import plain


def draw_done() -> None:
    """That names were changed just now."""
    if store.NAMES_CHANGED.pop():
        st.success("The names and tags are used from now on.", icon=":material/check_circle:")


def draw_systems() -> None:
    """A field for the name of each system, and the button that uses them."""
    names, changes = state.opened().whole.systems, store.N_NAME_CHANGES.get()
    with st.form(f"system_names_{changes}_{state.workspace().n_opened}", border=False):
        typed = [
            st.text_input(
                f"Name of {plain(name)}", name, max_chars=200, key=f"system_name_{changes}_{i}"
            )
            for i, name in enumerate(names)
        ]
        is_wanted = submit_button("Use these names", icon=":material/check:", key="use_names")
    if not is_wanted:
        return
    new = {old: text.strip() or old for old, text in zip(names, typed, strict=True)}
    try:
        use_names(new, {})
    except NvcoreError as error:
        st.error(shown_error(error), icon=":material/error:")


def use_names(systems: Mapping[str, str], changes: Mapping[str, Mapping[str, Any]]) -> None:
    """Call systems and recordings otherwise, without reading anything again; starts a new run.

    Parameters
    ----------
    systems
        New names of systems, by the old ones.
    changes
        New titles and tags of recordings, by their names.

    Raises
    ------
    InputError
        If two would have the same name.
    """
    opened = state.opened()
    titles = {name: change["title"] for name, change in changes.items() if "title" in change}
    own = opened.whole.recordings
    tags = [
        changes.get(name, {}).get("tags", tags)
        for name, tags in zip(own["name"], own["tags"], strict=True)
    ]
    whole = opened.whole.with_settings(opened.session).renamed(systems, titles)
    session = whole.settings
    assert isinstance(session, Session)
    if tags != own["tags"].tolist():
        column = pd.Series(tags, dtype=object).array
        whole = replace(whole, recordings=whole.recordings.assign(tags=column))
    others = {
        titles.get(name, name): {key: value for key, value in change.items() if key != "title"}
        for name, change in changes.items()
    }
    state.compare_as(_tagged(session, whole, others), whole)
    rename_chosen(titles)
    store.N_NAME_CHANGES.set(store.N_NAME_CHANGES.get() + 1)
    store.NAMES_CHANGED.set(True)
    st.rerun()


def _tagged(session: Session, whole: Dataset, changes: Mapping[str, Mapping[str, Any]]) -> Session:
    """The session with these tags; its choice loses those that no recording has any more.

    Of the recordings that the session compares, if it names some.
    """
    names, tags = whole.recordings["name"].tolist(), whole.recordings["tags"]
    is_left = any(
        {*session.only_tags} <= {*of_one}
        for name, of_one in zip(names, tags, strict=True)
        if not session.only or name in session.only
    )
    return replace(
        with_recordings(session.of_all, names, changes),
        only_tags=session.only_tags if is_left else (),
        only=session.only,
    )
