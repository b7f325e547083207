"""Links between the pages of the documentation lead somewhere."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from places import ROOT

PAGES = [*sorted(ROOT.glob("*.md")), *sorted((ROOT / "docs").rglob("*.md"))]
DECISIONS = sorted((ROOT / "docs" / "decisions").glob("[0-9]*.md"))
PARTS = {"Context", "Choice", "Why", "Instead of", "Ours", "Consequence", "Amended"}
LINK = re.compile(r"\[[^\]]*\]\(([^)\s]+)\)")


def prose(page: Path) -> str:
    """The page without its code, in which brackets are no links."""
    text = re.sub(r"^```.*?^```", "", page.read_text(encoding="utf-8"), flags=re.DOTALL | re.M)
    return re.sub(r"`[^`\n]*`", "", text)


def relative_links(page: Path) -> list[str]:
    links = LINK.findall(prose(page))
    return [link for link in links if not re.match(r"[a-z][a-z0-9+.-]*:", link)]


def anchors(page: Path) -> set[str]:
    """Anchors of a page's headings, made as the usual renderers of Markdown make them."""
    text = re.sub(r"^```.*?^```", "", page.read_text(encoding="utf-8"), flags=re.DOTALL | re.M)
    titles = re.findall(r"^#+ (.+)$", text, re.MULTILINE)
    return {re.sub(r"[^\w\- ]", "", title.lower()).strip().replace(" ", "-") for title in titles}


def shown(page: Path) -> str:
    return page.relative_to(ROOT).as_posix()


@pytest.mark.parametrize("page", PAGES, ids=shown)
def test_every_relative_link_leads_to_a_file_or_heading(page):
    missing = []
    for link in relative_links(page):
        path, _, anchor = link.partition("#")
        target = (page.parent / path).resolve() if path else page
        is_there = target.exists() and target.is_relative_to(ROOT)
        if is_there and anchor:
            is_there = target.suffix == ".md" and anchor in anchors(target)
        if not is_there:
            missing.append(link)
    assert not missing


def test_the_pages_are_linked_from_the_readme():
    links = relative_links(ROOT / "README.md")
    linked = {(ROOT / link.partition("#")[0]).resolve() for link in links}
    assert {ROOT / "CONTRIBUTING.md", *(ROOT / "docs").glob("*.md")} <= linked


def test_decisions_are_numbered_without_a_gap():
    numbers = [int(page.name[:3]) for page in DECISIONS]
    assert numbers == list(range(1, len(numbers) + 1))


def test_the_list_of_decisions_has_the_title_of_each_in_order():
    text = (ROOT / "docs" / "decisions" / "README.md").read_text(encoding="utf-8")
    titles = [page.read_text(encoding="utf-8").partition("\n")[0] for page in DECISIONS]
    rows = [
        f"- [{title[2:5]}]({page.name}) {title[6:]}"
        for title, page in zip(titles, DECISIONS, strict=True)
    ]
    assert [line for line in text.splitlines() if line.startswith("- ")] == rows


@pytest.mark.parametrize("page", DECISIONS, ids=shown)
def test_decisions_have_one_form(page):
    text = page.read_text(encoding="utf-8")
    parts = re.findall(r"^\*\*([^*]+)\.\*\*", text, re.MULTILINE)
    assert re.match(rf"# {page.name[:3]} \S.*\n\n\*\*(Context|Choice)\.\*\* ", text)
    assert parts.count("Choice") == 1
    assert set(parts) <= PARTS
    assert len(parts) == len(set(parts))
