"""The documentation inside the app: anchors and links hold there, too."""

from __future__ import annotations

import re

import pytest
from places import ROOT
from streamlit.testing.v1 import AppTest

from pages import checked, scripted
from ui.documentation.page import PAGES, in_app_links, sections_of, split_sections

PAGE = f"import runpy\nrunpy.run_path({str(ROOT / 'pages' / 'metrics.py')!r})\n"


def opened(**address: str) -> AppTest:
    return checked(scripted(PAGE, **address).run())


def headings(page: AppTest) -> list[str]:
    return [one.value for one in (*page.header, *page.subheader)]


@pytest.mark.parametrize("name", PAGES)
def test_every_link_within_the_app_leads_to_a_heading(name: str):
    anchors = {page: {section.anchor for section in sections_of(page)} for page in PAGES}
    text = "\n".join(section.body for section in sections_of(name))
    links = re.findall(r"\]\((?:\?doc=(\w+))?#([^)]+)\)", text)
    assert links
    assert [link for link in links if link[1] not in anchors[link[0] or name]] == []


def test_every_link_of_a_page_to_the_metrics_leads_to_a_heading():
    sources = [
        path.read_text() for folder in ("ui", "pages") for path in (ROOT / folder).glob("*.py")
    ]
    anchors = {section.anchor for section in sections_of("metrics")}
    links = re.findall(r"docs_link\('[^']+', '([^']+)'\)", "\n".join(sources))
    assert links
    assert set(links) <= anchors


def test_no_link_begins_at_the_root_of_the_server():
    """The app may be served below a path."""
    for folder in ("ui", "pages"):
        for path in (ROOT / folder).glob("*.py"):
            assert "](/" not in path.read_text(), path.name


@pytest.mark.parametrize("name", PAGES)
def test_no_link_leads_to_a_file_of_the_repository(name: str):
    text = "\n".join(section.body for section in sections_of(name))
    assert re.findall(r"\]\([^)]*\.md[^)]*\)", text) == []


@pytest.mark.parametrize("name", PAGES)
def test_nothing_of_a_page_is_lost(name: str):
    lines = (ROOT / "docs" / f"{name}.md").read_text(encoding="utf-8").splitlines()
    n_headings = sum(len(section.title) > 0 for section in sections_of(name))
    n_lines = sum(len([x for x in s.body.splitlines() if x.strip()]) for s in sections_of(name))
    assert n_headings + n_lines == len([line for line in lines if line.strip()])


def test_a_link_to_another_page_opens_it_there():
    assert in_app_links("see [it](formats.md#csv)", "metrics") == "see [it](?doc=formats#csv)"


def test_a_link_named_after_its_file_gets_the_name_of_the_page():
    assert in_app_links("[formats.md](formats.md)", "metrics") == "[Formats](?doc=formats)"


def test_a_link_to_a_page_that_is_not_in_the_app_becomes_text():
    assert in_app_links("it is [argued](decisions/001.md).", "metrics") == "it is argued."


def test_a_link_over_two_lines_is_followed():
    assert in_app_links("[one\ntwo](report.md)", "metrics") == "[one\ntwo](?doc=report)"


def test_brackets_in_code_are_no_links():
    text = "`a[0](b.md)` and\n```\nx[1](c.md)\n```\n"
    assert in_app_links(text, "metrics") == text


def test_code_may_be_the_label_of_a_link():
    assert in_app_links("[`mot`](#mot)", "formats") == "[`mot`](#mot)"


def test_a_comment_in_code_is_no_heading():
    (only,) = split_sections("# Title\n```\n# not one\n```\n", "metrics")
    assert "# not one" in only.body


def test_equal_headings_get_numbered_anchors():
    found = split_sections("# The formats\n## The formats\n", "formats")
    assert [section.anchor for section in found] == ["the-formats", "the-formats-1"]


def test_the_page_opens_on_the_metrics():
    assert "Saliency" in headings(opened())


def test_the_address_chooses_the_page():
    page = opened(doc="report")
    assert "frames.csv" in headings(page)
    assert "Saliency" not in headings(page)


def test_an_unknown_page_in_the_address_shows_the_metrics():
    assert "Saliency" in headings(opened(doc="../../etc/passwd"))
