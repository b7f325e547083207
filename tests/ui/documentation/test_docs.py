"""The documentation inside the app: anchors and links hold there, too."""

from __future__ import annotations

import re

import pytest
from places import ROOT
from streamlit.testing.v1 import AppTest

from pages import checked, scripted
from ui.views.documentation.page import PAGES, in_app_links, sections_of, split_sections

PAGE = f"import runpy\nrunpy.run_path({str(ROOT / 'pages' / 'metrics.py')!r})\n"
ANCHORS = {page: {section.anchor for section in sections_of(page)} for page in PAGES}


def opened(**address: str) -> AppTest:
    return checked(scripted(PAGE, **address).run())


def headings(page: AppTest) -> list[str]:
    return [heading.value for heading in (*page.header, *page.subheader)]


@pytest.mark.parametrize("name", PAGES)
def test_every_link_within_the_app_leads_to_a_heading_and_none_to_a_file(name: str):
    text = "\n".join(section.body for section in sections_of(name))
    links = re.findall(r"\]\((?:\?doc=([\w-]+))?#([^)]+)\)", text)
    assert links
    assert [link for link in links if link[1] not in ANCHORS[link[0] or name]] == []
    assert re.findall(r"\]\([^)]*\.md[^)]*\)", text) == []


@pytest.mark.parametrize("name", PAGES)
def test_no_word_is_left_of_a_link_that_the_page_cannot_follow(name: str):
    text = "\n".join(section.body for section in sections_of(name))
    assert re.findall(r"\((?:why|where|how|which)\b[^)]{0,20}\)|: which\b", text) == []


def test_every_link_of_a_page_to_the_documentation_leads_to_a_heading():
    paths = [path for folder in ("ui", "pages") for path in (ROOT / folder).rglob("*.py")]
    sources = "\n".join(path.read_text(encoding="utf-8") for path in paths)
    links = re.findall(r"docs_link\(.[^'\"]+., .([\w-]+).(?:, doc=.([\w-]+).)?\)", sources)
    assert len(links) > 15
    assert [link for link in links if link[0] not in ANCHORS[link[1] or "metrics"]] == []
    assert "](/" not in sources  # the app may be served below a path


@pytest.mark.parametrize("name", PAGES)
def test_nothing_of_a_page_is_lost(name: str):
    lines = (ROOT / "docs" / f"{name}.md").read_text(encoding="utf-8").splitlines()
    n_headings = sum(len(section.title) > 0 for section in sections_of(name))
    n_lines = sum(len([x for x in s.body.splitlines() if x.strip()]) for s in sections_of(name))
    assert n_headings + n_lines == len([line for line in lines if line.strip()])


@pytest.mark.parametrize(
    ("text", "in_app"),
    [
        ("see [it](formats.md#csv)", "see [it](?doc=formats#csv)"),
        ("[formats.md](formats.md)", "[Formats](?doc=formats)"),  # the name of the page
        ("it is [argued](decisions/001.md).", "it is argued."),  # not in the app
        ("[one\ntwo](report.md)", "[one\ntwo](?doc=report)"),
        ("[`mot`](#mot)", "[`mot`](#mot)"),
        *[("`a[0](b.md)` and\n```\nx[1](c.md)\n```\n",) * 2],  # brackets in code
    ],
)
def test_links_to_other_pages_open_them_in_the_app(text: str, in_app: str):
    assert in_app_links(text, "metrics") == in_app


def test_a_picture_of_a_page_is_drawn_between_its_paragraphs():
    page = opened(doc="validation")
    parts = list(page.main)
    picture = next(i for i, part in enumerate(parts) if part.type == "image")
    assert parts[picture].proto.imgs[0].url.startswith("data:image/png;base64,")
    before, after = parts[picture - 1], parts[picture + 1]
    assert "*Ratio*" in before.value
    assert after.value.lstrip().startswith("| Boxes")
    assert not any("![" in part.value for part in page.markdown)


def test_a_comment_in_code_is_no_heading_and_equal_headings_get_numbered_anchors():
    first, second = split_sections("# Formats\n```\n# not one\n```\n## Formats\n", "metrics")
    assert "# not one" in first.body
    assert (first.anchor, second.anchor) == ("formats", "formats-1")


@pytest.mark.parametrize("asked", [{}, {"doc": "../../etc/passwd"}, {"doc": "report"}])
def test_the_address_chooses_the_page_and_the_metrics_are_the_first(asked: dict[str, str]):
    shown = headings(opened(**asked))
    assert ("frames.csv" in shown) is (asked.get("doc") == "report")
    assert ("Saliency" in shown) is (asked.get("doc") != "report")
