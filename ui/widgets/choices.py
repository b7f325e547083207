"""Controls and tables shared by several pages."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any, Final, Literal, TypeVar

import pandas as pd
import streamlit as st

from nvcore.common.errors import InputError
from nvcore.common.output.csv_text import to_csv_bytes
from ui.session import store
from ui.session.store import Entry
from ui.settings.limits import MEBI

Option = TypeVar("Option")
MOST_MB: Final = 5
"""Maximum size of a small file."""


def choose_side_by_side(
    label: str, options: Mapping[Option, str] | Sequence[Option], key: str, **more: Any
) -> Option:
    """Draw options side by side and return the selected one.

    The choice is kept while other pages are shown. A mapping gives the label of each option.
    """
    words = options.__getitem__ if isinstance(options, Mapping) else str
    option: Option = st.segmented_control(
        label,
        list(options),
        required=True,
        key=key,
        persist_state="session",
        **{"format_func": words, **more},
    )
    return option


def look_closer(parts: Mapping[str, str], chosen: Entry[str | None], **more: Any) -> str | None:
    """Draw the titles of a page's optional sections, and return the selected one (None at first).

    Sections that are not selected cost nothing.
    """
    if chosen.get() not in (None, *parts):
        chosen.set(None)
    part: str | None = st.segmented_control(
        "Look closer",
        list(parts),
        format_func=parts.__getitem__,
        key=chosen.key,
        persist_state="session",
        **more,
    )
    return part


def choose_first(label: str, n: int, most: int, key: str, **more: Any) -> int:
    """Draw the choice of the first row that a figure shows, and return it. 0 if all rows fit."""
    pages = range(0, n, most)
    if len(pages) < 2:
        return 0
    chosen = store.widget(key)
    if chosen.get() not in pages:
        chosen.set(0)
    first: int = st.selectbox(
        label,
        pages,
        format_func=lambda start: f"{start + 1} to {min(start + most, n)}",
        key=key,
        **more,
    )
    return first


def ask_for_file(label: str, key: str, help: str | None = None) -> tuple[bytes, str] | None:  # noqa: A002
    """Draw a field for a small CSV file, and return its content and name, or None without one.

    Raises
    ------
    InputError
        If the file is too large.
    """
    sent = st.file_uploader(label, type=["csv", "txt"], key=key, max_upload_size=MOST_MB, help=help)
    if sent is None:
        return None
    if sent.size > MOST_MB * MEBI:  # the browser rejects it, unless it was manipulated
        raise InputError(f"the file is larger than {MOST_MB} MB", file=sent.name)
    return sent.getvalue(), sent.name


def download_csv(label: str, make: Callable[[], pd.DataFrame], file_name: str, key: str) -> None:
    """Draw a button that downloads a table as CSV. The table is made on the click."""
    st.download_button(
        label,
        data=lambda: to_csv_bytes(make()),
        file_name=file_name,
        mime="text/csv",
        on_click="ignore",
        icon=":material/download:",
        key=key,
    )


def draw_steps(
    at: int,
    n: int,
    step: Callable[[int], None],
    *,
    key: str,
    width: Literal["stretch", "content"] = "stretch",
) -> None:
    """Draw an entry's number, with buttons (keys p and n) to the previous and next entries.

    Parameters
    ----------
    at
        Number of the entry, counted from 0.
    n
        Number of entries.
    step
        Called with the number of the entry to go to, before the page is drawn again.
    key
        Prefix of the widgets' keys.
    width
        Width of the line: all of it ("stretch") or only the content.
    """
    with st.container(
        horizontal=True, horizontal_alignment="distribute", vertical_alignment="center", width=width
    ):
        _step("Previous", "p", at - 1, n, step, key=key, icon=":material/chevron_left:")
        st.markdown(f"**{at + 1:,}** of {n:,}", width="content")
        _step("Next", "n", at + 1, n, step, key=key, icon=":material/chevron_right:")


def _step(
    label: str, shortcut: str, at: int, n: int, step: Callable[[int], None], *, key: str, icon: str
) -> None:
    st.button(
        label,
        key=f"{key}_{label.lower()}",
        shortcut=shortcut,
        icon=icon,
        icon_position="right" if label == "Next" else "left",
        disabled=not 0 <= at < n,
        on_click=step,
        args=(at,),
    )
