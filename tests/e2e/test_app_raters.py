"""A rater in a real browser, from the page Alerts to the agreement that the organiser sees."""

from __future__ import annotations

import csv
from pathlib import Path

import pytest
import viewer_scene as scene
from app_files import CLIP_FRAMES, RECORDING
from app_visit import Visit
from playwright.sync_api import expect

FORM = {"age": "41", "licence": "yes", "night_driving": "every week", "1. Glasses": "none"}
ANSWERS = ("Yes", "No", "Cannot say")
# whether the red rim of a warning sign stands in the picture
HAS_SIGN = """canvas => {
  const { data } = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height);
  let n = 0;
  for (let i = 0; i < data.length; i += 4) {
    if (data[i] > 190 && data[i + 1] < 40 && data[i + 2] < 50) n += 1;
  }
  return n > 100;
}"""


@pytest.fixture(scope="module")
def app(short_app: str) -> str:
    """What is visited."""
    return short_app


def begin_session(one: Visit) -> tuple[str, str, int]:
    """From the alerts to a session with a form; pages of raters and organiser, and its alerts."""
    one.keyed("alerts_ask").get_by_role("button").click()
    expect(one.heading("Start a rating session")).to_be_visible()
    told = one.page.get_by_text("Nobody is told the kind")
    expect(told).to_be_visible()
    n_alerts = int(told.inner_text().partition(" ")[0])
    one.wait_until_drawn()
    one.keyed("rating_terms").locator("summary").click()
    one.wait_until_drawn()
    one.keyed("rating_has_form").get_by_text("Ask for age").click()
    questions = one.page.get_by_label("Own questions")
    questions.fill("Glasses")
    questions.press("Control+Enter")
    one.wait_until_drawn()
    one.keyed("rating_start").get_by_role("button").click()
    expect(one.heading("The rating session")).to_be_visible()
    codes = one.page.get_by_test_id("stCode").locator("code")
    expect(codes).to_have_count(2)
    study, conduct = (code.inner_text().strip().rpartition("/")[2] for code in codes.all())
    return study, conduct, n_alerts


def fill_in(one: Visit) -> None:
    """The form and the consent, as somebody who leaves out their sex."""
    one.page.get_by_role("spinbutton", name="Age in years").fill(FORM["age"])
    for label, answer in (
        ("Driving licence", FORM["licence"]), ("Driving at night", FORM["night_driving"]),
    ):  # fmt: skip
        one.page.get_by_role("combobox", name=label).click()
        one.page.get_by_role("option", name=answer, exact=True).click()
    one.page.get_by_label("Glasses").fill(FORM["1. Glasses"])
    one.page.get_by_label("Your name").fill("Ann")
    one.page.get_by_text("I have read this and agree to take part").click()
    one.page.get_by_role("button", name="Begin").click()


def watch_and_answer(one: Visit, heading: str, answer: str) -> bool:
    """Play what is shown to its end; only then it is asked. Whether a sign is there then."""
    expect(one.heading(heading)).to_be_visible()
    scale = one.keyed("rating_scale")
    expect(one.page.get_by_role("button", name="Play the clip")).to_be_visible()
    expect(scale).to_have_count(0)
    one.page.get_by_role("button", name="Play the clip").click()
    expect(scale).to_be_visible()
    has_sign = one.viewer.locator("canvas.picture").evaluate(HAS_SIGN)
    scale.get_by_role("button", name=answer, exact=True).click()
    return has_sign


def downloaded(one: Visit, label: str, path: Path) -> list[dict[str, str]]:
    with one.page.expect_download() as download:
        one.page.get_by_role("button", name=label).click()
    assert download.value.suggested_filename == path.name
    download.value.save_as(path)
    with path.open(newline="") as file:
        return list(csv.DictReader(file))


def test_a_rater_goes_through_form_clips_and_alerts_and_the_organiser_sees_the_agreement(
    visit, tmp_path: Path
):
    study, conduct, n_alerts = begin_session(visit("alerts?alerts=policy"))
    assert n_alerts > 1
    one = visit(study)
    fill_in(one)
    for clip, rating in enumerate("62", start=1):
        assert not watch_and_answer(one, f"Clip {clip} of 2", rating)
    given = [ANSWERS[i % len(ANSWERS)] for i in range(n_alerts)]
    n_signs = sum(
        watch_and_answer(one, f"Alert {alert} of {n_alerts}", answer)
        for alert, answer in enumerate(given, start=1)
    )
    expect(one.heading("Thank you")).to_be_visible()

    organiser = visit(conduct)
    metrics = organiser.page.get_by_test_id("stMetric")
    expect(metrics.filter(has_text="have rated all clips")).to_contain_text("1")
    expect(organiser.heading("Were the alerts worth it?")).to_be_visible()
    everything = organiser.table("worth").get_by_role("row").filter(has_text="all")
    n_sure = n_alerts - given.count("Cannot say")
    cells = everything.get_by_role("gridcell")
    expect(cells.nth(0)).to_have_text(str(n_alerts))
    expect(cells.nth(1)).to_have_text(str(n_sure))
    answers = downloaded(organiser, "Answers about alerts", tmp_path / "alert_answers.csv")
    assert [row["recording"] for row in answers] == [RECORDING] * n_alerts
    lasting = [row for row in answers if float(row["end_s"]) >= CLIP_FRAMES / scene.FPS - 1e-6]
    assert n_signs == len(lasting) > 0  # an alert that lasts to the end still shows its sign then
    expected = {
        "false": "no",
        "nuisance": "no",
        "redundant": "no",
        "needed": "yes",
        "wanted": "yes",
    }
    sure = [row for row in answers if row["answer"] != "unsure"]
    share = sum(row["answer"] == expected[row["kind"]] for row in sure) / n_sure
    expect(cells.nth(3)).to_have_text(f"{share:.2f}")
    (person,) = downloaded(organiser, "Participants", tmp_path / "participants.csv")
    assert person == {"participant": "Ann", "sex": "", **FORM}
