"""All pages of the app, in the order of work of somebody who compares two systems."""

from __future__ import annotations

from typing import Final

import streamlit as st
from streamlit.navigation.page import StreamlitPage

from ui.shell.navigate import PAGES

SECTIONS: Final = {
    "Data": {"data": "Data"},
    "Compare": {
        "overview": "Overview",
        "timeline": "Timeline",
        "encounters": "Encounters",
        "saliency": "Saliency",
    },
    "Evidence": {"detection": "Detection", "stability": "Stability", "ratings": "Ratings"},
    "Export": {"export": "Export"},
    "Help": {"metrics": "Documentation"},
}
"""Sections of the navigation, with the script and the title of each page."""
START: Final = "overview"
"""The page that the app opens on."""


def all_pages() -> dict[str, list[StreamlitPage]]:
    """The pages by section, for ``st.navigation``."""
    return {
        section: [
            st.Page(PAGES / f"{name}.py", title=title, default=name == START)
            for name, title in pages.items()
        ]
        for section, pages in SECTIONS.items()
    }


def draw_bar(pages: dict[str, list[StreamlitPage]]) -> None:
    """Draw the navigation: every page is one click away, under the name of its section."""
    with st.container(horizontal=True, gap="small", vertical_alignment="bottom", key="navigation"):
        for section, members in pages.items():
            with st.container(width="content", gap=None):
                if [page.title for page in members] != [section]:
                    st.caption(section)
                with st.container(horizontal=True, gap="xsmall", width="content"):
                    for page in members:
                        st.page_link(page, width="content")
