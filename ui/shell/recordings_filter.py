"""Choice of recordings by tags in the sidebar, which applies to every page."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Final

import streamlit as st

from nvcore.common.errors import InputError
from nvcore.common.wording import capitalised
from nvcore.dataset import part_text
from ui.session import settings, state, store
from ui.session.address import read_place
from ui.widgets.text import plain

_KEY: Final = "tags_chosen"


def draw() -> None:
    """Draw the choice and the number of compared recordings, if any recording has a tag."""
    tags = sorted({tag for own in state.opened().whole.recordings["tags"] for tag in own})
    if not tags:
        return
    chosen = list(state.opened().session.only_tags)
    key = settings.key_of(_KEY, chosen)
    st.multiselect(
        "Only recordings tagged",
        tags,
        default=chosen,
        key=key,
        on_change=_choose,
        args=(key,),
        placeholder="all recordings",
        help="Every page then shows and compares these recordings only. Of several tags a "
        "recording needs all.",
    )
    if refused := store.TAGS_REFUSED.pop():
        st.warning(plain(refused), icon=":material/filter_alt_off:")
    if text := filter_text():
        st.caption(plain(text))


def filter_text() -> str:
    """Describe the compared recordings, such as ``3 of 8 recordings: night`` (empty: all)."""
    names, every = state.recording_names(), state.opened().whole.recordings
    tags = state.opened().session.only_tags
    return "" if len(names) == len(every) else part_text(names, every, tags)


def choose_tags(tags: Sequence[str]) -> None:
    """Compare only recordings that have all of these tags, keeping the current frame if possible.

    Raises
    ------
    InputError
        If no recording has all tags.
    """
    name, of_recording = state.recording_names()[state.recording()], state.frame_numbers
    numbers = of_recording(state.recording())
    frame = str(numbers[state.row()]) if len(numbers) else None
    state.compare_as(replace(state.opened().session, only_tags=tuple(tags)))
    names = state.recording_names()
    place, _ = read_place(name, frame if name in names else None, names, of_recording)
    state.go_to(*place)


def _choose(key: str) -> None:
    if not settings.is_chosen(_KEY, key):
        return
    try:
        choose_tags(store.widget(key).get())
    except InputError as error:
        store.TAGS_REFUSED.set(capitalised(f"{error}: the choice stays as it was"))
