"""Review page: decisions as files."""

from __future__ import annotations

from functools import partial

import pandas as pd
import streamlit as st

from nvcore.common.wording import count_text
from nvcore.subjects.review.decisions import format_decisions, parse_decisions
from ui.session import store
from ui.settings.limits import MEBI
from ui.shell.messages import errors_shown
from ui.subjects.review import kept
from ui.widgets.buttons import button, download
from ui.widgets.choices import MOST_MB


def draw(decisions: pd.DataFrame) -> None:
    """Draw buttons that save decisions, and a field that adds those of a file."""
    with st.container(horizontal=True):
        for ending in ("csv", "json"):
            download(
                ending.upper(),
                partial(format_decisions, decisions, f".{ending}"),
                f"decisions.{ending}",
                key=f"review_{ending}",
                disabled=decisions.empty,
            )
    sent = st.file_uploader(
        "Add decisions", ["csv", "json"], key="review_file", max_upload_size=MOST_MB
    )
    if sent is None or sent.size > MOST_MB * MEBI:
        return
    if sent.file_id != store.REVIEW_FILE.get() and button("Add", key="review_add"):
        with errors_shown():
            made = parse_decisions(sent.getvalue(), sent.name)
            kept.import_(made)
            store.REVIEW_FILE.set(sent.file_id)
            st.toast(f"{count_text(len(made), 'decision')} added")
            st.rerun()
