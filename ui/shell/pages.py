"""All pages of the app, in the order in which an analyst would use them."""

from __future__ import annotations

from itertools import chain
from typing import Final

import streamlit as st

from nvcore.common.subject import in_place, subjects
from nvcore.settings.stages import (
    ENCOUNTERS,
    EVENTS,
    LOW,
    MATCH,
    PROXIMITY,
    SALIENCY,
    SEVERITY,
    SIMILARITY,
)
from ui.session import state
from ui.shell.navigate import PAGES
from ui.streamlit_inside.types import StreamlitPage
from ui.subject import Page, subject_pages

_ADDED: Final = tuple(chain(*(subject.settings().shown for subject in subjects())))
"""Stages whose results the subjects add to the pages about moments and encounters."""
COMPARE: Final = "Compare"
EVIDENCE: Final = "Evidence"
LAB: Final = "Lab"
HELP: Final = "Help"
GROUPS: Final = (EVIDENCE, LAB)
"""Sections whose pages unfold from a single entry of the navigation."""


def _lacks_third_system() -> str:
    return "" if len(state.opened().dataset.systems) > 2 else "Needs a third system."


_PAGES: Final[tuple[Page, ...]] = in_place(
    (
        Page("data", "Data", COMPARE, shown=(MATCH, PROXIMITY)),
        Page("overview", "Overview", COMPARE),
        Page(
            "timeline",
            "Timeline",
            COMPARE,
            shown=(SIMILARITY, LOW, ENCOUNTERS, SEVERITY, EVENTS, *_ADDED),
        ),
        Page(
            "encounters", "Encounters", COMPARE, shown=(SIMILARITY, ENCOUNTERS, SEVERITY, *_ADDED)
        ),
        Page("saliency", "Saliency", COMPARE, shown=(SALIENCY,), tab_of="encounters"),
        Page("detection", "Detection", EVIDENCE, shown=(MATCH,)),
        Page("stability", "Stability", EVIDENCE),
        Page(
            "systems",
            "Systems",
            EVIDENCE,
            shown=(SIMILARITY, ENCOUNTERS),
            lacks=_lacks_third_system,
            asks="How do all systems compare?",
        ),
        Page("export", "Export", HELP, is_folded=True, icon=":material/download:"),
        Page("metrics", "Documentation", HELP, shown=(), icon=":material/help:"),
    ),
    chain(*(subject.pages for subject in subject_pages())),
)
START: Final = "overview"
"""The page that the app opens on."""
PAGE_OF: Final = {page.key: page for page in _PAGES}
"""The pages by key."""


def all_pages() -> dict[str, StreamlitPage]:
    """Return the pages by key, for ``st.navigation``."""
    return {
        page.key: st.Page(
            PAGES / (page.script or f"{page.key}.py"),
            title=page.title,
            url_path=page.key,
            default=page.key == START,
        )
        for page in _PAGES
    }


def page_of(current: StreamlitPage) -> Page:
    """Return the description of a page. Streamlit gives the first page an empty address."""
    return PAGE_OF[current.url_path or START]


def draw_bar(links: dict[str, StreamlitPage], here: Page) -> None:
    """Draw the navigation in one row: pages, groups of pages that unfold, and icons.

    Pages that the comparison lacks data for come last in a group, with the missing data.
    """
    lacking = {page.key: need for page in _PAGES if (need := page.lacks())}
    with st.container(horizontal=True, gap="xsmall", vertical_alignment="center", key="navigation"):
        for page in _PAGES:
            if page.section == COMPARE and not page.tab_of and page.key not in lacking:
                is_here = page.key in (here.key, here.tab_of)
                with st.container(width="content", key="nav_current" if is_here else None):
                    st.page_link(links[page.key], width="content")
        for group in GROUPS:
            # another key on each page, so that the popover is closed there
            kind = "current" if here.section == group else group
            with st.popover(group, type="tertiary", key=f"nav_{kind}_{here.key}"):
                _draw_group(group, links, lacking)
        with st.container(horizontal=True, width="content", gap="xsmall", key="nav_icons"):
            for page in _PAGES:
                if page.icon:
                    st.page_link(links[page.key], icon=page.icon, width="content")


def draw_questions(links: dict[str, StreamlitPage], here: Page) -> None:
    """Draw links to pages that answer a question about this comparison, only on the first page."""
    if here.key != START:
        return
    with st.container(horizontal=True, gap="medium", key="questions"):
        for page in _PAGES:
            if page.asks and not page.lacks():
                icon = ":material/arrow_forward:"
                st.page_link(links[page.key], label=page.asks, icon=icon, width="content")


def _draw_group(group: str, links: dict[str, StreamlitPage], lacking: dict[str, str]) -> None:
    """Draw links to a group's pages. Pages that the comparison lacks data for come last."""
    members = [page for page in _PAGES if page.section == group]
    others = [page for page in _PAGES if page.section == COMPARE and group == EVIDENCE]
    for page in members:
        if page.key not in lacking:
            st.page_link(links[page.key])
    missing = [page for page in (*members, *others) if page.key in lacking]
    if missing:
        st.caption("Not with these data")
    for page in missing:
        st.page_link(links[page.key])
        st.caption(lacking[page.key])


def draw_tabs(links: dict[str, StreamlitPage], here: Page) -> None:
    """Draw links to a page and its tabs, if it has any."""
    first = here.tab_of or here.key
    tabs = [page for page in _PAGES if first in (page.key, page.tab_of)]
    if len(tabs) > 1:
        with st.container(horizontal=True, gap="small", key="tabs"):
            for page in tabs:
                st.page_link(links[page.key], width="content")
