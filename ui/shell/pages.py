"""All pages of the app, in the order of work of somebody who compares two systems."""

from __future__ import annotations

from typing import Final

import streamlit as st
from streamlit.navigation.page import StreamlitPage

from nvcore.driver.comparison.settings import DRIVER
from nvcore.params.metadata import (
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
from nvcore.time_left.settings import CONFIRMED, CONTACT, TIME_LEFT, URGENCY
from ui.shell.navigate import PAGES

SECTIONS: Final = {
    "Data": {"data": "Data"},
    "Compare": {
        "overview": "Overview",
        "timeline": "Timeline",
        "encounters": "Encounters",
        "time_left": "Time left",
        "driver": "Driver",
        "saliency": "Saliency",
    },
    "Evidence": {
        "systems": "Systems",
        "detection": "Detection",
        "stability": "Stability",
        "ratings": "Ratings",
        "study": "Study",
    },
    "Detect": {"detectors": "Detectors"},
    "Export": {"export": "Export"},
    "Help": {"metrics": "Documentation"},
}
"""Sections of the navigation, with the script and the title of each page."""
START: Final = "overview"
"""The page that the app opens on."""
SHOWN: Final[dict[str, tuple[Stage, ...]]] = {
    "data": (MATCH, PROXIMITY),
    "timeline": (SIMILARITY, LOW, ENCOUNTERS, SEVERITY, EVENTS, TIME_LEFT),
    "encounters": (SIMILARITY, ENCOUNTERS, SEVERITY, TIME_LEFT, DRIVER),
    "time_left": (TIME_LEFT,),
    "driver": (ENCOUNTERS, SEVERITY, TIME_LEFT, DRIVER),
    "saliency": (SALIENCY,),
    "systems": (SIMILARITY, ENCOUNTERS),
    "detection": (MATCH,),
    "ratings": (SALIENCY,),
    "study": (),
    "detectors": (),
    "metrics": (),
}
"""What each page shows of the comparison; one that is not named shows all results. Settings that
move nothing of it are quiet in the sidebar."""

OWN: Final[dict[str, tuple[Stage, ...]]] = {
    "time_left": (URGENCY, CONTACT, CONFIRMED),
    "driver": (DRIVER,),
}
"""Stages that a page is about: on it their settings stand first, unfolded."""
FOLDED: Final = ("ratings", "export")
"""Pages on which the settings are folded away, besides those that show nothing that they move."""


def all_pages() -> dict[str, list[StreamlitPage]]:
    """The pages by section, for ``st.navigation``."""
    return {
        section: [
            st.Page(PAGES / f"{name}.py", title=title, default=name == START)
            for name, title in pages.items()
        ]
        for section, pages in SECTIONS.items()
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
