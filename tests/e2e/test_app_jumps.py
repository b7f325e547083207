"""Every way to another page keeps settings, tags and address, and is one step of the history."""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Final, NamedTuple

import field_scene
import pandas as pd
import pytest
from app_server import ROOT, serve
from app_visit import SHARE, Visit
from jump_sites import WAYS, jump_sites
from playwright.sync_api import BrowserContext, expect

SETTINGS: Final = {"alpha": "0.5", "midpoint": "60", "speed_kmh": "70"}
OF_THE_SAMPLE: Final = {**SETTINGS, "threshold_x": "0.3", "tags": "winter"}
WALK: Final = 12
"""So many ways one after the other: a browser's history ends with fifty pages."""
PLACE: Final = "navigation.currentEntry.index"
# Place in the plot's area of the first mark that a click there finds.
FIRST_MARK: Final = """plot => {
  const { _fullData, _fullLayout: { xaxis, yaxis } } = plot;
  const trace = _fullData.find(one => one.customdata?.length && one.mode?.includes("markers"));
  return [xaxis.d2p(trace.x[0]), yaxis.d2p(trace.y[0])];
}"""
LARGEST_MARK: Final = """plot => {
  const { _fullData, _fullLayout: { xaxis, yaxis } } = plot;
  const trace = _fullData.find(one => / by severity$/.test(one.name));
  const size = Array.from(trace.marker.size), at = size.indexOf(Math.max(...size));
  return [xaxis.l2p(trace.x[at]), yaxis.l2p(trace.y[at])];
}"""
REGION: Final = """(plot, category) => {
  const trace = plot._fullData[0], { xaxis, yaxis, _size: { w, h } } = plot._fullLayout;
  const all = [...trace.customdata.keys()].map(i => ({ x: xaxis.l2p(trace.x[i]),
    y: yaxis.l2p(trace.y[i]), isOwn: String(trace.customdata[i]) === category }));
  const others = all.filter(one => !one.isOwn);
  const depth = one => Math.min(one.x, w - one.x, one.y, h - one.y,
    ...others.map(other => Math.hypot(one.x - other.x, one.y - other.y)));
  const deepest = all.filter(one => one.isOwn).reduce((a, b) => depth(a) < depth(b) ? b : a);
  return [deepest.x, deepest.y];
}"""
Click = Callable[[Visit], None]


class Jump(NamedTuple):
    """A way to another page.

    Attributes
    ----------
    site
        File and function that lead there, as `jump_sites` has them.
    page, to
        Titles of the page where it begins and of the one where it ends.
    """

    site: str
    page: str
    to: str
    click: Click


def press(key: str) -> Click:
    return lambda one: one.keyed(key).get_by_role("button").click()


def plot(key: str, place: str = FIRST_MARK, arg: object = None) -> Click:
    return lambda one: one.click_plot(key, place, arg)


def row(key: str) -> Click:
    """Click the first row of the table whose key begins so."""

    return lambda one: one.table(key).get_by_role("rowheader").first.click()


def open_case(one: Visit) -> None:
    one.page.get_by_role("button", name=re.compile("Show (all|the)")).first.click()
    one.page.locator("[class*='st-key-entries_table_']").wait_for()
    one.wait_until_drawn()
    row("entries_table_")(one)


def choose_pedestrian(one: Visit) -> None:
    """Choose who is in the frame, if nobody is chosen, and open the page about them."""
    chosen = one.page.locator(".st-key-open_chosen button")
    if not chosen.count():
        one.table("pedestrians").get_by_role("gridcell").first.click()
    chosen.click()


def ask_of_alerts(one: Visit) -> None:
    """Ask raters of the alerts, where none are judged yet."""
    for choice in ("Rating session", "Those of this comparison"):
        one.page.get_by_role("radio", name=choice, exact=True).first.click()
        one.wait_until_drawn()
    press("rating_open_alerts")(one)


def follow(title: str) -> Click:
    def click(one: Visit) -> None:
        one.find_entry(title).click()

    return click


def ask(question: str) -> Click:
    return lambda one: one.keyed("questions").get_by_role("link", name=question).click()


def closer(part: str, then: Click) -> Click:
    def click(one: Visit) -> None:
        one.look_closer(part)
        then(one)

    return click


VENN: Final = "ui/views/overview/venn.py"
SALIENCY: Final = "ui/views/saliency/events.py:open_asked"
ONE_ENCOUNTER: Final = "ui/views/encounters/details.py:_draw_ways"
CHANGED: Final = "ui/subjects/releases/cases.py:_draw_case"
LAST_CHANCE: Final = "ui/subjects/time_left/approaches.py:_follow"
IN_THE_SAMPLE: Final = (
    Jump(f"{VENN}:_open", "Overview", "Encounters", press("open_x_only")),
    Jump(f"{VENN}:_open", "Overview", "Encounters", press("open_y_only")),
    Jump(f"{VENN}:_open", "Overview", "Encounters", plot("venn", REGION, "both")),
    Jump(f"{VENN}:draw", "Overview", "Timeline", plot("venn", LARGEST_MARK)),
    Jump(f"{VENN}:draw_worst", "Overview", "Timeline", row("overview_worst")),
    Jump(f"{VENN}:draw_worst", "Overview", "Encounters", press("overview_review")),
    Jump(
        "ui/views/overview/strip.py:draw",
        "Overview",
        "Timeline",
        plot("loss_strip", SHARE, [0.6, 0.1]),
    ),
    Jump(
        "ui/views/overview/moments.py:_moment",
        "Overview",
        "Timeline",
        closer(
            "Moments to look at",
            lambda one: one.page.get_by_role("button", name="Open frame").first.click(),
        ),
    ),
    Jump(
        "ui/views/overview/scorecard.py:by_recording",
        "Overview",
        "Timeline",
        closer("Recording by recording", plot("by_recording")),
    ),
    Jump(
        "ui/views/overview/moments.py:worst_windows",
        "Overview",
        "Timeline",
        closer("Worst windows", row("windows")),
    ),
    Jump(ONE_ENCOUNTER, "Encounters", "Timeline", press("encounters_show")),
    Jump(
        "ui/subjects/time_left/encounter.py:draw_ways",
        "Encounters",
        "Timeline",
        press("encounters_show_chance"),
    ),
    Jump(CHANGED, "What changed", "Timeline", press("releases_show")),
    Jump(CHANGED, "What changed", "Encounters", press("releases_encounter")),
    Jump(
        "pages/time_left.py:draw",
        "Time left",
        "Timeline",
        closer("One by one", row("time_left_list")),
    ),
    Jump(LAST_CHANCE, "Time left", "Timeline", plot("time_left_approaches")),
    Jump(LAST_CHANCE, "Time left", "Timeline", closer("One by one", plot("time_left_margins"))),
    Jump(
        "ui/views/saliency/figures.py:_draw_way", "Saliency", "Timeline", press("saliency_show_x")
    ),
    Jump(SALIENCY, "Saliency", "Timeline", row("saliency_events")),
    Jump(SALIENCY, "Saliency", "Timeline", plot("saliency_curve")),
    Jump(SALIENCY, "Saliency", "Timeline", plot("saliency_plane")),
    Jump(
        "ui/subjects/review/gallery.py:draw",
        "Review",
        "Timeline",
        lambda one: one.page.get_by_role("option").first.dblclick(),
    ),
    Jump("ui/views/data/audit/entries.py:_go", "Data", "Timeline", open_case),
    Jump("ui/views/timeline/listed.py:draw", "Timeline", "Data", press("listed_back")),
    Jump("ui/views/timeline/panel.py:_chosen", "Timeline", "Encounters", choose_pedestrian),
    Jump("ui/subjects/ratings/session_setup.py:_ask_alerts", "Ratings", "Alerts", ask_of_alerts),
    Jump("ui/shell/pages.py:draw_bar", "Data", "Time left", follow("Time left")),
    Jump("ui/shell/pages.py:_draw_group", "Data", "Stability", follow("Stability")),
    Jump(
        "ui/shell/pages.py:draw_questions",
        "Overview",
        "Systems",
        ask("How do all systems compare?"),
    ),
    Jump("ui/shell/pages.py:draw_tabs", "Encounters", "Saliency", follow("Saliency")),
)
WITH_THREE: Final = (
    Jump("ui/views/systems/pairs.py:_open", "Systems", "Overview", press("pair_1")),
    Jump("ui/views/overview/verdict.py:_draw_doubt", "Overview", "Data", press("see_findings")),
)
WITH_TWO: Final = (
    Jump("ui/views/systems/pairs.py:draw_only_pair", "Systems", "Data", press("add_system")),
)
WITH_ONE: Final = (
    Jump("ui/shell/messages.py:_one_system_only", "Saliency", "Data", press("open_data_page")),
)
WALKED: Final = (*IN_THE_SAMPLE, *WITH_THREE, *WITH_TWO, *WITH_ONE)
ELSEWHERE: Final = {
    "ui/subjects/alerts/listed.py:draw": "walked by the test of raters, with a policy",
    "ui/views/data/opening.py:_draw_opened": "other files were opened, with settings of their own",
    "ui/subjects/detectors/run.py:_open": "as above: the session that it opens has the settings",
    "ui/subjects/driver/run.py:draw_aside": "a link of Streamlit's, as those of the navigation",
    "ui/subjects/ratings/sessions.py:draw_waiting": "a participant has no settings",
}


def test_every_way_to_another_page_is_walked_and_pages_are_changed_in_one_place():
    sites = {site for site in jump_sites() if not site.startswith(WAYS)}
    assert sites == {jump.site for jump in WALKED} | {*ELSEWHERE}
    sources = {
        path.relative_to(ROOT).as_posix()
        for path in [*ROOT.glob("ui/**/*.py"), *ROOT.glob("pages/*.py")]
        if "switch_page" in path.read_text(encoding="utf-8")
    }
    assert sources == {"ui/shell/navigate.py"}


def walk(one: Visit, jumps: Sequence[Jump], settings: dict[str, str]) -> None:
    """Go each of these ways, from the page that was reached or by the navigation."""
    for jump in jumps:
        if not one.heading(jump.page, level=1).count():
            one.switch_to(jump.page)
        place = one.page.evaluate(PLACE)
        jump.click(one)
        expect(one.heading(jump.to, level=1), jump.site).to_be_visible()
        one.wait_until_drawn()
        for name, value in settings.items():
            one.query(name, value)
        if jump.to != "Data":
            expect(one.slider("alpha"), jump.site).to_have_value("0.5")
        assert one.page.evaluate(PLACE) == place + 1, jump.site


def query(settings: dict[str, str]) -> str:
    return "&".join(f"{name}={value}" for name, value in settings.items())


def test_every_way_in_the_sample_keeps_settings_and_tags(visit):
    for first in range(0, len(IN_THE_SAMPLE), WALK):
        one = visit(f"overview?{query(OF_THE_SAMPLE)}")
        walk(one, IN_THE_SAMPLE[first : first + WALK], OF_THE_SAMPLE)
        one.close()


def test_every_way_between_many_systems_and_with_one_keeps_settings(
    person: BrowserContext, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    for systems, jumps in (("xyz", WITH_THREE), ("xy", WITH_TWO), ("x", WITH_ONE)):
        (tmp_path / systems).mkdir()
        monkeypatch.setenv("NVCORE_SESSION", str(write_session(tmp_path / systems, systems)))
        with serve(ROOT / "app.py") as address:
            one = Visit(person, address)
            one.go(f"overview?{query(SETTINGS)}")
            walk(one, jumps, SETTINGS)
            one.close()
        assert one.complaints == []


def write_session(folder: Path, systems: str) -> Path:
    """The scene's pedestrians and these of its systems: some of y are twice, z is half of y."""
    text = '[defaults]\nsize = "640x480"\nfps = 10\nframes = "0:39"\n[truth]\npath = "truth.csv"\n'
    truth = field_scene.truth()
    tables = {"truth": truth[truth["name"] == field_scene.PERSON]}
    for name in systems:
        table = field_scene.detections(name if name in "xy" else "y")
        table = table[table["name"] == field_scene.PERSON]
        tables[name] = {"x": table, "y": pd.concat([table, table.tail(40)]), "z": table[::2]}[name]
        text += f'[[system]]\nname = "{name}"\npath = "{name}.csv"\n'
    for name, table in tables.items():
        table.drop(columns="name").assign(recording="walk").to_csv(
            folder / f"{name}.csv", index=False
        )
    path = folder / "session.toml"
    path.write_text(text, encoding="utf-8")
    return path
