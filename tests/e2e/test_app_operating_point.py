"""Every number of a measure on a page is at one operating point, the one that is chosen."""

from __future__ import annotations

import re
from collections.abc import Iterable
from dataclasses import replace

import pytest
from app_server import ROOT
from app_visit import Visit
from playwright.sync_api import expect

from nvcore.comparison.compare import Result, compare
from nvcore.evidence.claims import values_of
from nvcore.evidence.operating_points import find_equal_alarms
from nvcore.inputs.load import load
from nvcore.inputs.session.toml import read_session
from nvcore.settings.defaults import POINTS, OperatingPoint

THRESHOLD_X = 0.1
"""At which X has 25 times as many false alarms as Y."""
NUMBER = r"([\d.,]+)"
ROWS = "rows => rows.map(row => [...row.querySelectorAll('td, th')].map(cell => cell.innerText))"
TILES = {
    "Pedestrians found": "encounters_detected",
    "Time missed": "severity_s_per_encounter",
    "False-alert episodes": "false_alert_episodes",
    "Worst miss": "worst_severity_s",
}
SCORECARD = {
    "mean similarity": "mean_similarity",
    "similarity lost (s per minute)": "lost_s_per_min",
    "saliency, mean largest event (s)": "saliency",
    "encounters detected, of 38": "encounters_detected",
    "severity of missed pedestrians (s)": "severity_s",
    "per encounter (s)": "severity_s_per_encounter",
    "false alarms per frame": "false_alarms_per_frame",
    "false-alert episodes": "false_alert_episodes",
}
EVIDENCE = {
    "mean similarity": "mean_similarity",
    "saliency of a recording, largest event (s)": "saliency",
    "severity of missed pedestrians per encounter (s)": "severity_s_per_encounter",
    "false-alert episodes in 150 s": "false_alert_episodes",
}
SAID = {
    r"mean similarity \({} vs {}\)": "mean_similarity",
    r"severity per encounter \({} vs {} s\)": "severity_s_per_encounter",
    r"mean saliency over recordings \({} vs {} s\)": "saliency",
    r"false-alert episodes \({} vs {} in 150 s\)": "false_alert_episodes",
    r"X has {} and Y has {} false boxes per frame": "false_alarms_per_frame",
    r"both at {} false boxes per frame": "false_alarms_per_frame",
}


@pytest.fixture(scope="module")
def results() -> dict[OperatingPoint, Result]:
    dataset = load(read_session(ROOT / "sample_data" / "session.toml"))
    as_set = compare(dataset, replace(dataset.params_of(), threshold_x=THRESHOLD_X))
    equal = find_equal_alarms(as_set)
    assert equal is not None
    return {"as-set": as_set, "equal-alarms": equal}


def agree(texts: list[str], pair: tuple[float, float]) -> bool:
    """Whether these are the values, to their decimals: X's first, or those of one or two."""
    for text, value in zip(texts, pair, strict=False):
        _, _, decimals = text.rstrip(".").partition(".")
        number = float(text.replace(",", "").rstrip("."))
        if abs(number - value) > 0.50001 * 10 ** -len(decimals):
            return False
    return True


def rows_of(one: Visit, key: str) -> dict[str, list[str]]:
    """Numbers of X and Y in a table of measures, by the label without arrows and marks."""
    lines = one.page.locator(f"table.nv-{key} tbody tr")
    lines.first.wait_for()  # it is unfolded a run after the click
    rows = lines.evaluate_all(ROWS)
    return {
        re.split(r"\s*[↑↓]", label)[0].strip(): [re.sub(r"[^\d.,]", "", cell) for cell in cells[:2]]
        for label, *cells in rows
    }


def numbers_on(one: Visit) -> Iterable[tuple[str, list[str]]]:
    """Every measure that the Overview shows, with the numbers of X and Y in each place."""
    for title, key in TILES.items():
        values = one.page.get_by_role("region", name=title).locator(".values")
        yield key, re.findall(NUMBER, values.inner_text())
    one.page.get_by_text(re.compile(r"^All \d+ measures$")).click()
    one.look_closer("Is the difference real?")
    for table, labels in (("all_measures", SCORECARD), ("evidence", EVIDENCE)):
        rows = rows_of(one, table)
        for label, key in labels.items():
            yield key, rows[label]
    both, only_x, only_y, _ = (
        int(re.search(NUMBER, text)[1])
        for text in one.keyed("venn_open").get_by_role("button").all_inner_texts()
    )
    yield "encounters_detected", [str(both + only_x), str(both + only_y)]
    venn = "\n".join(one.keyed("venn").locator("text").all_text_contents())
    yield "encounters_detected", re.findall(r"(\d+) of 38", venn)


def numbers_said(one: Visit) -> Iterable[tuple[str, list[str]]]:
    """Every measure that the verdict's reasons name, with its numbers as they stand there."""
    one.page.get_by_text("What this rests on").click()
    text = one.page.get_by_test_id("stMain").inner_text()
    for pattern, key in SAID.items():
        for found in re.finditer(pattern.format(NUMBER, NUMBER), text):
            yield key, [*found.groups()]


@pytest.mark.parametrize("point", POINTS)
def test_every_number_of_a_measure_is_at_the_chosen_operating_point(
    visit, results: dict[OperatingPoint, Result], point: OperatingPoint
):
    one = visit(f"?threshold_x={THRESHOLD_X}&point={point}")
    result = results["equal-alarms" if point == "equal-alarms" else "as-set"]
    other = next(of for of in results.values() if of is not result)
    places = [(*place, False) for place in numbers_on(one)]
    places += [(*place, True) for place in numbers_said(one)]
    for key, texts, is_said in places:
        pair = values_of(key, result)
        assert texts, key
        # reasons name the better system first, whichever it is
        assert agree(texts, pair) or (is_said and agree(texts, pair[::-1])), (key, texts, pair)
        assert values_of(key, other) != pair
    assert len(places) > 20
    one.switch_to("Saliency")
    for value in values_of("saliency", result):
        expect(one.page.get_by_text(f"{value:.2f} s", exact=True).first).to_be_visible()


def test_the_switch_moves_all_pages_and_the_address(visit, results: dict[OperatingPoint, Result]):
    one = visit(f"?threshold_x={THRESHOLD_X}")
    for point, words in (("as-set", "As set"), ("equal-alarms", "At equal false alarms")):
        one.page.get_by_role("radio", name=words).click()
        found, _ = values_of("encounters_detected", results[point])
        tile = one.page.get_by_role("region", name="Pedestrians found")
        expect(tile.locator(".values .x, .values span").first).to_contain_text(f"{found:.0f}")
        one.wait_until_drawn()
        assert ("point=as-set" in one.page.url) == (point == "as-set")
        one.switch_to("Encounters")
        expect(one.page.get_by_role("radio", name=words)).to_be_checked()
        one.switch_to("Overview")
