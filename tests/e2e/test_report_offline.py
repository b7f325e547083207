"""The HTML report opened from disk in a real browser without network."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path

import pytest
from app_server import PATIENCE_MS
from inputs import drive, session_of
from places import SAMPLE
from playwright.sync_api import expect

from nvcore.comparison.compare import compare
from nvcore.inputs.load import load
from nvcore.inputs.session.toml import read_session
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


def test_it_is_whole_without_network_on_a_screen_and_on_paper(chromium, report):
    context = chromium.browser.new_context(viewport={"width": 1280, "height": 800}, offline=True)
    page = context.new_page()
    requests: list[str] = []
    complaints: list[str] = []
    page.on("request", lambda one: requests.append(one.url))
    page.on("console", lambda one: complaints.append(one.text))
    page.on("pageerror", lambda error: complaints.append(str(error)))
    page.goto(report.as_uri())
    page.locator("html[data-charts]").wait_for(timeout=PATIENCE_MS)
    assert page.evaluate("document.documentElement.dataset.charts") == "drawn"
    assert page.evaluate("document.documentElement.scrollWidth") <= 1280

    # names with markup are shown as text
    assert HOSTILE in page.locator("h1").inner_text()
    assert page.locator("#similarity td", has_text=HOSTILE).count() == 3  # once in each table
    assert page.locator("img[src='x']").count() == 0
    assert page.title() == f"{HOSTILE} (X) and nir (Y) compared"

    # evidence frames are pictures
    widths = page.locator(".photos img").evaluate_all("all => all.map((one) => one.naturalWidth)")
    assert widths
    assert set(widths) == {880}

    # on paper nothing is wider than the page, and what it leaves out is named there
    fold = page.locator("#significance details")
    summary, table = fold.locator("summary"), fold.locator("table")
    assert table.is_hidden()
    page.emulate_media(media="print")
    assert summary.inner_text() == "Methods: not printed, in significance.csv"
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
    assert summary.inner_text() == "Methods"
    summary.click()
    expect(table).to_be_visible()

    # every chart is drawn, and says who X and Y are
    charts = page.locator(".chart")
    assert charts.count() == 11
    page.locator("details").evaluate_all("all => all.forEach((one) => { one.open = true; })")
    for i in range(charts.count()):
        expect(charts.nth(i).locator(".main-svg").first).to_be_visible()
    assert page.locator("#chart-venn").locator("path").count() > 3
    labels = page.locator(".plot[role=img]").evaluate_all("all => all.map((one) => one.ariaLabel)")
    assert len(labels) == charts.count()
    assert all(label.endswith(f"; X: {HOSTILE}, Y: nir") for label in labels)

    # all that without asking for anything or a complaint
    assert [url for url in requests if not url.startswith("data:")] == [report.as_uri()]
    assert complaints == []
    context.close()


def test_printed_at_once_every_chart_is_there_as_wide_as_the_page(chromium, tmp_path: Path):
    path, session = tmp_path / "report.html", read_session(SAMPLE)
    write_html_report(compare(load(session)), session, (), path)
    page = chromium.browser.new_page(viewport={"width": 1280, "height": 800})
    page.goto(path.as_uri())
    page.evaluate(ON_PAPER)
    pdf = page.pdf(prefer_css_page_size=True)
    charts = page.evaluate("onPaper")
    page.close()
    assert len(charts) >= 8
    for chart in charts:
        assert chart["width"] == PAPER_PX
        assert chart["shapes"] > 3
        assert chart["letters_px"] >= LEAST_LETTERS_PX
    # a drive like the sample takes a dozen pages
    assert 8 <= len(re.findall(rb"/Type\s*/Page\b", pdf)) <= 13


def test_a_browser_that_cannot_draw_the_charts_says_so_and_shows_the_tables(chromium, report):
    context = chromium.browser.new_context(offline=True)
    context.add_init_script("delete window.DecompressionStream")
    page = context.new_page()
    page.goto(report.as_uri())
    page.locator("html[data-charts=failed]").wait_for(timeout=PATIENCE_MS)
    expect(page.locator("#trouble")).to_be_visible()
    expect(page.get_by_role("cell", name="mean similarity", exact=True).first).to_be_visible()
    context.close()

    context = chromium.browser.new_context(offline=True, java_script_enabled=False)
    page = context.new_page()
    page.goto(report.as_uri())
    assert "need JavaScript" in page.locator("noscript").inner_text()
    context.close()
