"""All pages of the app, in the order in which an analyst would use them."""

from __future__ import annotations

from itertools import chain
from typing import Final

import streamlit as st

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
from ui.session import state
from ui.shell.navigate import PAGES
from ui.streamlit_inside.types import StreamlitPage
from ui.subjects import Page, contributed

_ADDED: Final = tuple(chain(*results_of_subjects("results")))
"""Stages whose results subjects show, on the pages about moments and encounters too."""
COMPARE: Final = "Compare"
EVIDENCE: Final = "Evidence"
LAB: Final = "Lab"
HELP: Final = "Help"
GROUPS: Final = (EVIDENCE, LAB)
"""Sections whose pages unfold from one entry; those of the others are entries themselves."""


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
    chain(*contributed("PAGES")),
)
SECTIONS: Final = {
    section: {page.key: page.title for page in _PAGES if page.section == section}
    for section in (COMPARE, EVIDENCE, LAB, HELP)
}
"""Sections of the navigation, with the script and the title of each page."""
START: Final = "overview"
"""The page that the app opens on."""
_OF: Final = {page.key: page for page in _PAGES}
SHOWN: Final = {page.key: page.shown for page in _PAGES if page.shown is not None}
OWN: Final = {page.key: page.own for page in _PAGES}
FOLDED: Final = tuple(page.key for page in _PAGES if page.is_folded)


def all_pages() -> dict[str, list[StreamlitPage]]:
    """Return the pages by section, as ``st.navigation`` expects them."""
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
    """Return the stages of the comparison whose results the page shows."""
    here = _OF.get(page.url_path or START)
    if here is not None and here.lacks and here.lacks():
        return ()
    return SHOWN.get(page.url_path or START, shown_results())


def own_of(page: StreamlitPage) -> tuple[Stage, ...]:
    """Return the stages whose settings come first in the page's sidebar."""
    return OWN.get(page.url_path, ())


def controls_of(page: StreamlitPage) -> tuple[str, ...]:
    """Return the settings that the page has its own buttons for."""
    here = _OF.get(page.url_path)
    return here.controls if here else ()


def idle_on(page: StreamlitPage) -> frozenset[str]:
    """Return settings that do not affect the page in its current state.

    Other settings may have no effect because the page shows no result of their stage.
    """
    here = _OF.get(page.url_path)
    return here.idle() if here and here.idle else frozenset()


def is_folded_on(page: StreamlitPage, shown: tuple[Stage, ...]) -> bool:
    """Whether the sidebar folds the settings away, as they hardly affect the page."""
    return page.url_path in FOLDED or not shown


def draw_bar(pages: dict[str, list[StreamlitPage]], current: StreamlitPage) -> None:
    """Draw the navigation in one row: pages, groups of pages that unfold, and icons.

    What the comparison has no data for stands last in a group, with what it would need.
    """
    links = _links(pages)
    here = _OF.get(current.url_path or START)
    lacking = {page.key: need for page in _PAGES if page.lacks and (need := page.lacks())}
    with st.container(horizontal=True, gap="xsmall", vertical_alignment="center", key="navigation"):
        for page in _PAGES:
            if page.section == COMPARE and not page.tab_of and page.key not in lacking:
                is_here = here is not None and page.key in (here.key, here.tab_of)
                with st.container(width="content", key="nav_current" if is_here else None):
                    st.page_link(links[page.key], width="content")
        for group in GROUPS:
            is_here = here is not None and here.section == group
            # another one on each page, so that it is closed there
            name = f"current_{here.key}" if here and is_here else group
            with st.popover(group, type="tertiary", key=f"nav_{name}"):
                _draw_group(group, links, lacking)
        with st.container(horizontal=True, width="content", gap="xsmall", key="nav_icons"):
            for page in _PAGES:
                if page.icon:
                    st.page_link(links[page.key], icon=page.icon, width="content")


def draw_questions(pages: dict[str, list[StreamlitPage]], current: StreamlitPage) -> None:
    """Draw links to pages that answer a question about this comparison, only on the first page."""
    if (current.url_path or START) != START:
        return
    links = _links(pages)
    with st.container(horizontal=True, gap="medium", key="questions"):
        for page in _PAGES:
            if page.asks and not (page.lacks and page.lacks()):
                icon = ":material/arrow_forward:"
                st.page_link(links[page.key], label=page.asks, icon=icon, width="content")


def _links(pages: dict[str, list[StreamlitPage]]) -> dict[str, StreamlitPage]:
    """Return the pages by key."""
    keys = chain(*SECTIONS.values())  # as `all_pages` has them
    return dict(zip(keys, chain(*pages.values()), strict=True))


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


def draw_tabs(pages: dict[str, list[StreamlitPage]], current: StreamlitPage) -> None:
    """Draw links to a page and its tabs, if it has any."""
    here = _OF.get(current.url_path or START)
    if here is None:
        return
    first = here.tab_of or here.key
    tabs = [page for page in _PAGES if first in (page.key, page.tab_of)]
    if len(tabs) > 1:
        links = _links(pages)
        with st.container(horizontal=True, gap="small", key="tabs"):
            for page in tabs:
                st.page_link(links[page.key], width="content")
