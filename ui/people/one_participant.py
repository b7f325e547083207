"""What there is of one participant of a study, saved or deleted on request."""

from __future__ import annotations

import json
from collections.abc import Callable
from typing import Any

import streamlit as st

from nvcore.errors import InputError
from nvcore.people.participants import MOST_NAME
from ui.session import store
from ui.widgets.text import plain


def draw_one_participant(
    label: str,
    key: str,
    record_of: Callable[[str], dict[str, Any] | None],
    delete: Callable[[str], object],
    *,
    hint: str,
    nobody: str,
) -> None:
    """Ask for a name or code; then offer that participant's data, and to delete them.

    Parameters
    ----------
    label
        What is asked for.
    key
        Start of the keys of what is drawn.
    record_of
        All that is kept of a participant, as values of JSON; None: there is none.
    delete
        Takes the name or code; may raise InputError.
    hint, nobody
        When it is asked for, and what is said where there is no such participant.
    """
    st.header("One participant's data")
    st.caption(hint)
    name = st.text_input(label, key=f"{key}_code", max_chars=MOST_NAME, width=420).strip()
    record = record_of(name) if name else None
    if name and record is None:
        st.warning(nobody)
    if record is None:
        return

    def remove() -> None:
        try:
            delete(name)
        except InputError as error:
            st.error(plain(str(error)))
            return
        store.widget(f"{key}_code").set("")
        st.toast("The data of this participant are deleted.")

    with st.container(horizontal=True):
        st.download_button(
            "All data of this participant (JSON)",
            data=json.dumps(record, indent=2),
            file_name="participant.json",
            mime="application/json",
            on_click="ignore",
            icon=":material/download:",
            key=f"{key}_record",
        )
        with st.popover("Delete …", icon=":material/delete:"):
            st.markdown(f"Delete all data of **{plain(name)}**? There is no way back.")
            st.button("Delete for good", key=f"{key}_delete", type="primary", on_click=remove)
