"""Every page of the sample in a real browser: what it leads to, its look, its accessibility."""

from __future__ import annotations

import subprocess
import sys
import zipfile
from collections.abc import Iterator

import pytest
from app_server import ROOT
from app_visit import Visit
from axe_playwright_python.sync_playwright import Axe
from playwright.sync_api import expect

TITLES = (
    *("Data", "Overview", "Timeline", "Encounters", "Saliency", "Detection", "Stability"),
    *("Ratings", "Export", "Metrics"),
)
THEMES = ("light", "dark")

# Place in the plot's area of the marker of the Venn diagram that lies deepest in a region.
FIND_REGION = """(plot, category) => {
  const trace = plot._fullData[0], layout = plot._fullLayout;
  const { w, h } = layout._size;
  const all = [...trace.customdata.keys()].map(i => ({
    x: layout.xaxis.l2p(trace.x[i]), y: layout.yaxis.l2p(trace.y[i]),
    isOwn: String(trace.customdata[i]) === category }));
  const others = all.filter(one => !one.isOwn);
  const depth = one => Math.min(one.x, w - one.x, one.y, h - one.y,
    ...others.map(other => Math.hypot(one.x - other.x, one.y - other.y)));
  const deepest = all.filter(one => one.isOwn).reduce((a, b) => depth(a) < depth(b) ? b : a);
  return [deepest.x, deepest.y];
}"""


def test_the_app_opens_on_a_verdict_on_the_sample(visit):
    one = visit()
    expect(one.heading("Overview", level=1)).to_be_visible()
    expect(one.keyed("verdict")).to_contain_text("13 encounters that only one system detects")


@pytest.mark.parametrize(
    ("category", "words", "count"), [("x_only", "only X", 8), ("neither", "neither", 3)]
)
def test_a_click_on_a_venn_region_lists_its_encounters(visit, category, words, count):
    one = visit()
    one.click_plot("venn", FIND_REGION, category)
    expect(one.heading("Encounters", level=1)).to_be_visible()
    expect(one.page.get_by_text(f"{count} of 46 encounters")).to_be_visible()
    one.query("category", category)


def test_the_overview_has_its_own_address_too(visit):
    one = visit("overview?alpha=0.4")
    expect(one.heading("Overview", level=1)).to_be_visible()
    expect(one.slider("alpha")).to_have_value("0.4")
    assert one.page.url.startswith(f"{one.address}/?")


def test_a_worst_moment_opens_its_frame(visit):
    one = visit()
    one.page.get_by_role("button", name="Open frame").first.click()
    expect(one.heading("Timeline", level=1)).to_be_visible()
    expect(one.viewer).to_have_attribute(
        "data-frame", one.page.evaluate("() => new URL(location).searchParams.get('frame')")
    )
    expect(one.page.get_by_text("Missed, the tallest first")).to_be_visible()


def test_the_zip_holds_the_files_of_the_command_line_byte_for_byte(visit, tmp_path):
    one = visit("export?alpha=0.4&recording=rural_child")
    with one.page.expect_download() as download:
        one.page.get_by_role("button", name="All files (ZIP)").click()
    download.value.save_as(tmp_path / "report.zip")
    command = [sys.executable, "-m", "nvcore", "compare", "sample_data/session.toml"]
    command += ["--alpha", "0.4", "--out", str(tmp_path / "report")]
    subprocess.run(command, cwd=ROOT, check=True, capture_output=True)
    with zipfile.ZipFile(tmp_path / "report.zip") as report:
        sent = {name.rpartition("/")[2]: report.read(name) for name in report.namelist()}
    written = {path.name: path.read_bytes() for path in (tmp_path / "report").iterdir()}
    assert sent.keys() == written.keys()
    # session.toml names its inputs beside itself, not where the command was started
    del sent["session.toml"], written["session.toml"]
    assert [name for name in sent if sent[name] != written[name]] == []


def test_the_address_of_a_term_scrolls_to_its_explanation(visit):
    one = visit("metrics#saliency")
    expect(one.page.locator("#saliency")).to_be_in_viewport()


def test_the_dark_theme_reaches_page_plots_and_viewer(visit):
    one = visit("timeline?recording=rural_child&frame=57", theme="dark")
    one.shows(57)
    expect(one.page.get_by_test_id("stApp")).to_have_css("background-color", "rgb(17, 22, 27)")
    expect(one.viewer).to_have_attribute("data-theme", "dark")
    title = one.keyed("time_plot_4").locator(".gtitle")
    expect(title).to_have_css("fill", "rgb(230, 234, 240)")


@pytest.fixture(scope="module", params=THEMES)
def themed(request, person, app) -> Iterator[Visit]:
    """One session that goes through all pages."""
    one = Visit(person(request.param), app)
    one.go("")
    yield one
    one.close()


@pytest.mark.parametrize("title", TITLES)
def test_a_page_has_no_accessibility_fault(themed, title):
    themed.switch_to(title)
    if title == "Timeline":
        themed.shows(0)
    found = Axe().run(themed.page).response
    faults = [
        f"{rule['impact']} {rule['id']}: {node['html'][:200]} {node['failureSummary']}"
        for rule in found["violations"]
        for node in rule["nodes"]
    ]
    assert faults == []
    assert themed.complaints == []
    assert len(found["passes"]) > 10
