"""The HTML report opened from disk in a real browser without network."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import pytest
from app_server import PATIENCE_MS
from inputs import drive, session_of
from places import SAMPLE
from playwright.sync_api import BrowserContext, Page, expect

from nvcore.comparison import compare
from nvcore.inputs.load import load
from nvcore.inputs.session_toml import read_session
from nvcore.report.html import write_html_report

PAPER_PX = 695
"""Width of A4 less the margins."""
LEAST_LETTERS_PX = 8 / 72 * 96
ON_PAPER = """addEventListener("beforeprint", () => {
  window.onPaper = [...document.querySelectorAll(".chart:not(details .chart)")].map((chart) => ({
    width: chart.querySelector(".main-svg")?.getBoundingClientRect().width,
    shapes: chart.querySelectorAll(".main-svg path").length,
    letters_px: Math.min(...[...chart.querySelectorAll(".main-svg text")].map(
      (text) => parseFloat(getComputedStyle(text).fontSize))),
  }));
})"""
"""Notes how the charts are when the page's own listener has made them ready for paper."""
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
    page.locator("details").evaluate_all("all => all.forEach((one) => { one.open = true; })")
    for i in range(charts.count()):
        expect(charts.nth(i).locator(".main-svg").first).to_be_visible()
    drawn = page.locator("#chart-venn").locator("path").count()
    assert drawn > 3
    labels = page.locator(".plot[role=img]").evaluate_all("all => all.map((one) => one.ariaLabel)")
    assert len(labels) == charts.count()
    assert all(label.endswith(f"; X: {HOSTILE}, Y: nir") for label in labels)
    page.locator("details").evaluate_all("all => all.forEach((one) => { one.open = false; })")


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


def test_on_paper_nothing_is_wider_than_the_page(seen):
    page, _, _ = seen
    page.emulate_media(media="print")
    page.set_viewport_size({"width": PAPER_PX, "height": 1000})
    page.evaluate("dispatchEvent(new Event('beforeprint'))")
    assert page.evaluate("document.documentElement.scrollWidth") <= PAPER_PX
    # a table of long texts that was kept whole would leave most of the page before it empty
    assert page.locator("table.short").count() > 5
    assert "short" not in page.locator("table:has(caption:text-is('Methods'))").evaluate(
        "table => [...table.classList]"
    )
    page.evaluate("dispatchEvent(new Event('afterprint'))")
    page.emulate_media(media="screen")
    page.set_viewport_size({"width": 1280, "height": 800})


@pytest.fixture(scope="module")
def printed(
    chromium: BrowserContext, tmp_path_factory: pytest.TempPathFactory
) -> tuple[bytes, list[dict]]:
    """The sample's report, printed as soon as it is loaded, and its charts as they were then."""
    path, session = tmp_path_factory.mktemp("sample") / "report.html", read_session(SAMPLE)
    write_html_report(compare(load(session)), session, (), path)
    page = chromium.browser.new_page(viewport={"width": 1280, "height": 800})
    page.goto(path.as_uri())
    page.evaluate(ON_PAPER)
    pdf = page.pdf(prefer_css_page_size=True)
    charts = page.evaluate("onPaper")
    page.close()
    return pdf, charts


def test_printed_at_once_every_chart_is_there_as_wide_as_the_page(printed):
    _, charts = printed
    assert len(charts) >= 8
    for chart in charts:
        assert chart["width"] == PAPER_PX
        assert chart["shapes"] > 3
        assert chart["letters_px"] >= LEAST_LETTERS_PX


def test_a_drive_like_the_sample_prints_on_a_dozen_pages(printed):
    pdf, _ = printed
    assert 8 <= len(re.findall(rb"/Type\s*/Page\b", pdf)) <= 13


def test_what_paper_leaves_out_is_named_there_and_unfolds_on_the_screen(seen):
    page, _, _ = seen
    fold = page.locator("#significance details")
    summary, table = fold.locator("summary"), fold.locator("table")
    assert table.is_hidden()
    page.emulate_media(media="print")
    assert summary.inner_text() == "Methods: not printed, in significance.csv"
    page.emulate_media(media="screen")
    assert summary.inner_text() == "Methods"
    summary.click()
    expect(table).to_be_visible()
    summary.click()


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
