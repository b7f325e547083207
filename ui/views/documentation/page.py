"""Documentation page: the pages of the documentation, with links that work inside the app."""

from __future__ import annotations

import re
from dataclasses import dataclass
from itertools import chain
from pathlib import Path
from typing import Final

import streamlit as st

from nvcore.common.subject import in_place
from nvcore.pictures import picture_address
from ui.session import state
from ui.subject import Document, subject_pages
from ui.widgets.script import read_script

FOLDER: Final = state.ROOT / "docs"
_DOCUMENTS: Final[tuple[Document, ...]] = in_place(
    (
        Document("tutorial", "Tutorial"),
        Document("metrics", "Metrics"),
        Document("glossary", "Glossary"),
        Document("detection", "Detection curves"),
        Document("objects", "Objects"),
        Document("significance", "Significance"),
        Document("groups", "Groups"),
        Document("validation", "Validation"),
        Document("report", "Report files"),
        Document("formats", "Formats"),
        Document("python", "Python"),
    ),
    chain(*(subject.documents for subject in subject_pages())),
)
PAGES: Final = {document.key: document.title for document in _DOCUMENTS}
_HEADING: Final = re.compile(r"(#{1,6}) +(.*)")
_ASIDE: Final = re.compile(
    r"(?:\s*\(|[:,;] )\[(?:why|where|how|which)\b[^\]]*\]\((?!https?:)decisions/[^)\s]+\)(\))?"
)
"""Pattern of a reference to a decision, which the app has no page for. It is removed."""
_PICTURE: Final = re.compile(r"^!\[([^\]]*)\]\((images/[\w-]+\.png)\)$", re.MULTILINE)
_LINK: Final = re.compile(r"(?<!!)\[((?:[^\]\[]|\[[^\]]*\])*)\]\(([^)\s]+)\)")
_CODE: Final = re.compile(r"(`+)(?:.*?[^`])?\1(?!`)", re.DOTALL)
_FENCE: Final = "```"
_SIGHT: Final = st.components.v2.component(
    "nvcore_section", js=read_script(Path(__file__).with_name("section.js"))
)


@dataclass(frozen=True)
class DocsSection:
    """Markdown heading (level 1: the page's title) with the content up to the next heading.

    Anchors are the same as in other Markdown renderers, so that links between the pages work.
    """

    level: int
    title: str
    anchor: str
    body: str


def draw() -> None:
    """Draw the page and section that the address names."""
    st.title("Documentation")
    requested = st.query_params.get("doc")
    name = st.segmented_control(
        "Page",
        list(PAGES),
        default=requested if requested in PAGES else "metrics",
        required=True,
        format_func=PAGES.__getitem__,
        key="chosen_doc",
        label_visibility="collapsed",
    )
    if name != (requested or "metrics"):
        st.query_params["doc"] = name
    for section in sections_of(name):
        if section.level == 2:
            st.header(section.title, anchor=section.anchor)
        elif section.level > 2:
            st.subheader(section.title, anchor=section.anchor)
        _draw_body(section.body)
    _SIGHT(key="section", height=1)


def _draw_body(body: str) -> None:
    """Draw Markdown with pictures, which the app's Markdown would seek at the server's root."""
    text, *rest = _PICTURE.split(body)
    st.markdown(text)
    for words, path, following in zip(rest[::3], rest[1::3], rest[2::3], strict=True):
        # drawn with the page, as nothing could be fetched after leaving it
        st.image(picture_address((FOLDER / path).read_bytes(), "png"), caption=words)
        st.markdown(following)


@st.cache_data(show_spinner=False)
def sections_of(name: str) -> list[DocsSection]:
    """Return the sections of a page, with links adapted to the app."""
    return split_sections((FOLDER / f"{name}.md").read_text(encoding="utf-8"), name)


def split_sections(text: str, name: str) -> list[DocsSection]:
    """Split Markdown at its headings, numbering the anchors of equal titles."""
    sections: list[DocsSection] = []
    level, title = 1, ""
    lines: list[str] = []
    used: dict[str, int] = {}
    is_code = False

    def end() -> None:
        anchor = anchor_of(title)
        n_before = used.get(anchor, 0)
        used[anchor] = n_before + 1
        own = f"{anchor}-{n_before}" if n_before else anchor
        body = in_app_links("\n".join(lines).strip(), name)
        sections.append(DocsSection(level, title, own, body))

    for line in text.splitlines():
        heading = None if is_code else _HEADING.fullmatch(line)
        is_code ^= line.startswith(_FENCE)
        if heading is None:
            lines.append(line)
            continue
        if title or "".join(lines).strip():
            end()
        level, title, lines = len(heading[1]), heading[2].strip(), []
    end()
    return sections


def anchor_of(title: str) -> str:
    """Return the anchor of a heading, as made by the usual Markdown renderers.

    Examples
    --------
    >>> anchor_of("The column `miss_class`")
    'the-column-miss_class'
    >>> anchor_of("frames.csv")
    'framescsv'
    """
    return re.sub(r"[^\w\- ]", "", title.lower()).strip().replace(" ", "-")


def in_app_links(text: str, name: str) -> str:
    """Return the text with links to the app's own pages. Links to other files become plain text.

    Examples
    --------
    >>> in_app_links("It is so ([why](decisions/012.md)), see [it](formats.md#csv).", "metrics")
    'It is so, see [it](?doc=formats#csv).'
    """
    parts: list[str] = []
    end_of_last = 0
    for code in _CODE.finditer(text):  # brackets in code are no links
        parts += [text[end_of_last : code.start()], code[0]]
        end_of_last = code.end()
    parts.append(text[end_of_last:])
    part_of = {f"\0{i}\0": part for i, part in enumerate(parts) if i % 2}
    joined = "".join(f"\0{i}\0" if i % 2 else part for i, part in enumerate(parts))
    joined = _ASIDE.sub("", joined)
    linked = _LINK.sub(lambda link: _linked(link[1], link[2], name), joined)
    return re.sub("\0\\d+\0", lambda place: part_of[place[0]], linked)


def _linked(label: str, target: str, name: str) -> str:
    path, _, anchor = target.partition("#")
    if re.match(r"[a-z][a-z0-9+.-]*:", target):
        return f"[{label}]({target})"
    page = path.removesuffix(".md") if path else name
    if page not in PAGES:
        return label
    label = PAGES[page] if label == path else label
    if page == name and anchor:
        return f"[{label}](#{anchor})"
    return f"[{label}](?doc={page}{'#' if anchor else ''}{anchor})"
