"""The HTML report opened from disk in a real browser without network."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import pytest
from app_server import PATIENCE_MS
from inputs import drive, session_of
from playwright.sync_api import BrowserContext, Page, expect

from nvcore.comparison import compare
from nvcore.inputs.load import load
from nvcore.report.html import write_html_report

HOSTILE = "</script><img src=x onerror=document.title=1>{{ 7*7 }}$x^2$"


@pytest.fixture(scope="module")
def report(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A report whose recording and system have names with markup."""
    folder = drive(tmp_path_factory.mktemp("report"))
    for name in ("truth", "fir", "nir"):
        path = folder / f"{name}.csv"
        path.write_text(path.read_text().replace("urban", HOSTILE))
    session = session_of(folder)
    dataset = replace(load(session), systems=(HOSTILE, "nir"))
    write_html_report(compare(dataset), session, (), folder / "report.html")
    return folder / "report.html"


@pytest.fixture(scope="module")
def seen(chromium: BrowserContext, report: Path) -> Iterator[tuple[Page, list[str], list[str]]]:
    """The page once its charts are drawn, what it asked for, and what it complained of."""
    context = chromium.browser.new_context(viewport={"width": 1280, "height": 800}, offline=True)
    page = context.new_page()
    requests: list[str] = []
    complaints: list[str] = []
    page.on("request", lambda one: requests.append(one.url))
    page.on("console", lambda one: complaints.append(one.text))
    page.on("pageerror", lambda error: complaints.append(str(error)))
    page.goto(report.as_uri())
    page.locator("html[data-charts]").wait_for(timeout=PATIENCE_MS)
    yield page, requests, complaints
    context.close()


def test_it_asks_for_nothing_and_complains_of_nothing(seen, report):
    page, requests, complaints = seen
    asked = [url for url in requests if not url.startswith("data:")]
    assert asked == [report.as_uri()]
    assert complaints == []
    assert page.evaluate("document.documentElement.dataset.charts") == "drawn"


def test_every_chart_is_drawn(seen):
    page, _, _ = seen
    charts = page.locator(".chart")
    assert charts.count() == 11
    for i in range(charts.count()):
        expect(charts.nth(i).locator(".main-svg").first).to_be_visible()
    drawn = page.locator("#chart-venn").locator("path").count()
    assert drawn > 3


def test_names_with_markup_are_shown_as_text(seen):
    page, _, _ = seen
    assert HOSTILE in page.locator("h1").inner_text()
    assert page.locator("#similarity td", has_text=HOSTILE).count() == 3  # once in each table
    assert page.locator("img[src='x']").count() == 0
    assert page.title() == f"{HOSTILE} (X) and nir (Y) compared"


def test_nothing_is_wider_than_the_window(seen):
    page, _, _ = seen
    assert page.evaluate("document.documentElement.scrollWidth") <= 1280


def test_evidence_frames_are_pictures(seen):
    page, _, _ = seen
    widths = page.locator(".photos img").evaluate_all("all => all.map((one) => one.naturalWidth)")
    assert widths
    assert set(widths) == {880}


def test_it_prints_to_pdf_with_its_charts(seen):
    page, _, _ = seen
    page.emulate_media(media="print")
    for image in page.locator(".printed").all():
        expect(image).to_be_visible()
    assert page.locator(".plot").first.is_hidden()
    # on paper nothing may stick out at the side: A4 less the margins is 695 px wide
    page.set_viewport_size({"width": 695, "height": 1000})
    assert page.evaluate("document.documentElement.scrollWidth") <= 695
    meaning = page.locator("#parameters td:last-child").first.bounding_box()
    assert meaning["width"] > 0.4 * 695
    # a table of long texts that was kept whole would leave most of the page before it empty
    assert page.locator("table.short").count() > 5
    assert "short" not in page.locator("table:has(caption:text-is('How they were made'))").evaluate(
        "table => [...table.classList]"
    )
    pdf = page.pdf(prefer_css_page_size=True)
    assert pdf.startswith(b"%PDF")
    assert len(pdf) > 50_000
    page.emulate_media(media="screen")
    page.set_viewport_size({"width": 1280, "height": 800})


def test_a_browser_that_cannot_unpack_the_charts_says_so_and_shows_the_tables(chromium, report):
    context = chromium.browser.new_context(offline=True)
    context.add_init_script("delete window.DecompressionStream")
    page = context.new_page()
    page.goto(report.as_uri())
    page.locator("html[data-charts=failed]").wait_for(timeout=PATIENCE_MS)
    expect(page.locator("#trouble")).to_be_visible()
    expect(page.get_by_role("cell", name="mean similarity", exact=True).first).to_be_visible()
    context.close()


def test_without_scripts_a_note_says_why_there_are_no_charts(chromium, report):
    context = chromium.browser.new_context(offline=True, java_script_enabled=False)
    page = context.new_page()
    page.goto(report.as_uri())
    assert "need JavaScript" in page.locator("noscript").inner_text()
    context.close()
