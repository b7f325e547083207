"""All pages of the app, in the order of work of somebody who compares two systems."""

from __future__ import annotations

from itertools import chain
from typing import Final

import streamlit as st
from streamlit.navigation.page import StreamlitPage

from nvcore.stages import (
    ENCOUNTERS,
    EVENTS,
    LOW,
    MATCH,
    PROXIMITY,
    SALIENCY,
    SEVERITY,
    SIMILARITY,
    Stage,
    shown_results,
)
from nvcore.subjects import contributed as results_of_subjects
from nvcore.subjects import in_place
from ui.shell.navigate import PAGES
from ui.subjects import Page, contributed

_ADDED: Final = tuple(chain(*results_of_subjects("results")))
"""Stages whose results subjects show, on the pages about moments and encounters too."""
_PAGES: Final[tuple[Page, ...]] = in_place(
    (
        Page("data", "Data", "Data", shown=(MATCH, PROXIMITY)),
        Page("overview", "Overview", "Compare"),
        Page(
            "timeline",
            "Timeline",
            "Compare",
            shown=(SIMILARITY, LOW, ENCOUNTERS, SEVERITY, EVENTS, *_ADDED),
        ),
        Page(
            "encounters",
            "Encounters",
            "Compare",
            shown=(SIMILARITY, ENCOUNTERS, SEVERITY, *_ADDED),
        ),
        Page("saliency", "Saliency", "Compare", shown=(SALIENCY,)),
        Page("systems", "Systems", "Evidence", shown=(SIMILARITY, ENCOUNTERS)),
        Page("detection", "Detection", "Evidence", shown=(MATCH,)),
        Page("stability", "Stability", "Evidence"),
        Page("export", "Export", "Export", is_folded=True),
        Page("metrics", "Documentation", "Help", shown=()),
    ),
    chain(*contributed("PAGES")),
)
SECTIONS: Final = {
    section: {page.key: page.title for page in _PAGES if page.section == section}
    for section in dict.fromkeys(page.section for page in _PAGES)
}
"""Sections of the navigation, with the script and the title of each page."""
START: Final = "overview"
"""The page that the app opens on."""
SHOWN: Final = {page.key: page.shown for page in _PAGES if page.shown is not None}
OWN: Final = {page.key: page.own for page in _PAGES}
FOLDED: Final = tuple(page.key for page in _PAGES if page.is_folded)


def all_pages() -> dict[str, list[StreamlitPage]]:
    """The pages by section, for ``st.navigation``."""
    return {
        section: [
            st.Page(
                PAGES / (page.script or f"{page.key}.py"),
                title=page.title,
                default=page.key == START,
            )
            for page in _PAGES
            if page.section == section
        ]
        for section in SECTIONS
    }


def shown_on(page: StreamlitPage) -> tuple[Stage, ...]:
    """The stages of the comparison whose results the page shows."""
    return SHOWN.get(page.url_path or START, shown_results())


def own_of(page: StreamlitPage) -> tuple[Stage, ...]:
    """The stages whose settings stand first on the page."""
    return OWN.get(page.url_path, ())


def is_folded_on(page: StreamlitPage) -> bool:
    """Whether the sidebar's settings are folded away until they are asked for."""
    return page.url_path in FOLDED or not shown_on(page)


def draw_bar(pages: dict[str, list[StreamlitPage]]) -> None:
    """Draw the navigation: every page is one click away, under the name of its section."""
    with st.container(horizontal=True, gap="xsmall", vertical_alignment="bottom", key="navigation"):
        for section, members in pages.items():
            with st.container(width="content", gap=None):
                if [page.title for page in members] != [section]:
                    st.caption(section)
                with st.container(horizontal=True, gap="xsmall", width="content"):
                    for page in members:
                        st.page_link(page, width="content")
