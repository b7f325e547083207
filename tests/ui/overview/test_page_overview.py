"""Overview page, run without a browser."""

from __future__ import annotations

from collections.abc import Callable

import cv2
import numpy as np
import pandas as pd
import pytest
from streamlit.testing.v1 import AppTest

from nvcore.common.errors import InputError
from nvcore.evidence.table import evidence_table
from nvcore.report import tiles as report_tiles
from nvcore.report.verdict import Verdict, verdict
from nvcore.tables.moments import worst_moments
from pages import checked, figures, measures, opened, part, press, tables, texts, to_page
from ui.jobs import companions
from ui.session import results
from ui.views.overview import evidence as evidence_page
from ui.views.overview import moments, venn
from ui.views.overview import verdict as verdict_page
from ui.views.overview.moments import window_row
from ui.views.overview.scorecard import Scorecard
from ui.widgets.drawing import cut_out

VENN = "ui.views.overview.venn.draw(RESULT)"
WORST = "ui.views.overview.venn.draw_worst(RESULT)"
EVIDENCE = "ui.session.results.measure_evidence(RESULT)"


@pytest.fixture
def app() -> AppTest:
    """The app on the sample recordings, at the Overview."""
    return checked(opened())


@pytest.fixture(scope="module")
def page() -> AppTest:
    """The same, to look at."""
    return checked(opened())


def closer(name: str, *calls: str, **address: str) -> AppTest:
    """What one looks at closer."""
    page = part(*calls, f"ui.views.overview.more.draw(RESULT, {EVIDENCE}, None)", **address)
    page.session_state["overview_more"] = name
    return checked(page.run())


def scorecard(app: AppTest) -> dict[str, tuple[str, ...]]:
    return measures(app, "scorecard")


def test_the_app_opens_on_verdict_and_scorecard_which_follow_the_parameters(app: AppTest):
    assert app.title[0].value == "Overview"
    assert "Of the 13 encounters that only one system detects, X detects 8 and Y 5" in texts(app)
    before = scorecard(app)
    assert before["mean similarity ↑"] == ("0.915", "0.896", "+0.019")
    assert before["encounters detected, of 38 ↑"] == ("30", "27", "+3")
    checked(app.slider(key="alpha").set_value(0.5).run())
    after = scorecard(app)
    assert after["mean similarity ↑"] != before["mean similarity ↑"]
    assert after["encounters detected, of 38 ↑"] == before["encounters detected, of 38 ↑"]
    assert app.query_params["alpha"] == "0.5"


def tiles(app: AppTest) -> str:
    (body,) = [item.proto.body for item in app.get("html") if '"nv-tiles"' in item.proto.body]
    return body


def test_four_tiles_say_what_is_shown_and_the_better_value_has_a_mark(page: AppTest):
    assert page.markdown[0].value.startswith("## 10 recordings do not tell X and Y apart")
    body = tiles(page)
    assert body.count("<section") == 4
    assert '<span class="x better"><i>FIR</i><span data-value="x">30</span></span>' in body
    assert '<span class="y"><i>NIR</i><span data-value="y">27</span></span>' in body
    assert body.count(">not shown to be more than chance<") == 3
    assert "95 % interval −" in body
    (table,) = [item.proto.body for item in page.get("html") if 'nv-scorecard"' in item.proto.body]
    assert '<td class="x better">30</td><td class="y">27</td>' in table
    assert table.count("<tr") == 1 + 8
    unfolded = part(f"ui.views.overview.scorecard.Scorecard(RESULT).draw({EVIDENCE})")
    unfolded.session_state["all_measures"] = True
    every = measures(checked(unfolded.run()), "all_measures")
    assert every["largest event of all (s) ↓"] == ("3.813", "3.491", "+0.322")
    assert len(every) == 22


def test_tiles_call_systems_x_and_y_where_a_name_is_long(monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr(verdict_page, "short_names", lambda _: {"x": "thermal", "y": "NIR"})
    body = tiles(checked(opened()))
    assert "<i>X</i>" in body
    assert "<i>Y</i>" in body


def test_bars_are_explained_only_where_there_are_some(
    page: AppTest, monkeypatch: pytest.MonkeyPatch
):
    assert any("Bars: " in item.value for item in page.caption)
    monkeypatch.setattr(report_tiles, "_bar", lambda *_, **__: None)
    assert not any("Bars: " in item.value for item in checked(opened()).caption)


def test_the_verdict_is_short_and_its_reason_stands_below(page: AppTest):
    headline, reason = page.markdown[0].value.split("\n\n")
    assert headline == "## 10 recordings do not tell X and Y apart\\."
    assert reason.startswith("No difference in severity of missed pedestrians is shown to be more")
    lead = "X is ahead by 0.019 in mean similarity, whichever recording is left out: by"
    assert lead in reason.replace("\\", "")


def test_a_verdict_that_is_shown_stays_until_the_next_unless_it_is_about_others(
    app: AppTest, monkeypatch: pytest.MonkeyPatch
):
    def refuse(*_: object) -> None:
        raise InputError("no evidence")

    drawn: list[str] = []
    monkeypatch.setattr(results, "cached_evidence", refuse)
    monkeypatch.setattr(verdict_page.VerdictBox, "draw_known", lambda *_: drawn.append("known"))
    app.slider(key="alpha").set_value(0.5).run()
    assert drawn == []
    app.multiselect(key="tags_chosen").set_value(["rural"]).run()  # it was not about these alone
    assert drawn == ["known"]


def test_what_is_known_is_drawn_once_and_not_first_as_unknown(
    app: AppTest, monkeypatch: pytest.MonkeyPatch
):
    drawn: list[bool] = []
    monkeypatch.setattr(Scorecard, "draw", lambda _, evidence: drawn.append(evidence is not None))
    monkeypatch.setattr(verdict_page.VerdictBox, "draw_known", lambda *_, **__: drawn.append(False))
    checked(app.run())
    assert drawn == [True]
    assert app.markdown[0].value.startswith("## 10 recordings do not tell X and Y apart")
    assert tiles(app).count(">not shown to be more than chance<") == 3
    newcomer = checked(opened())  # sees at once what another has waited for
    assert newcomer.session_state["workspace"] is not app.session_state["workspace"]
    assert drawn[1:] == [False, True]  # the words wait for the page's end


@pytest.mark.parametrize(("x", "y"), [("FIR", "NIR"), ("NIR", "FIR")])
def test_a_system_keeps_its_colour_and_line_as_x_and_as_y(x: str, y: str):
    page = closer("moments", "ui.shell.systems.draw()", x=x, y=y)
    (styles,) = [item.proto.body for item in page.get("html") if "--nv-x:" in item.proto.body]
    for name, look in (
        ("FIR", "#0067B1;--nv-dash-{}:solid"),
        ("NIR", "#C45A00;--nv-dash-{}:dashed"),
    ):
        letter = "x" if name == x else "y"
        assert f"--nv-{letter}:{look.format(letter)};" in styles
    blue, orange = ("X", "Y") if x == "FIR" else ("Y", "X")
    assert f"{blue} solid blue" in texts(page)
    assert f"{orange} dashed orange" in texts(page)


def test_footnotes_belong_to_their_rows():
    page = closer("tests")
    rows = measures(page, "evidence")
    marked = [label for label in rows if "[" in label]
    assert [("urgent" in label, "impact" in label) for label in marked] == [
        (True, False),
        (True, False),
        (False, True),
    ]  # few recordings and encounters tell X and Y apart in these
    result = page.session_state["workspace"].result
    evidence = evidence_table(result).assign(note="")
    evidence.loc[1, "note"] = "too few; odd"
    evidence.loc[2, "note"] = "odd"
    shown, notes = evidence_page.shown_evidence(result, evidence)
    assert [row.marks for row in shown[:4]] == ["", "a b", "b", ""]
    assert notes == {"too few": "a", "odd": "b"}


@pytest.mark.parametrize("clicked", [75, "x_only"])
def test_a_mark_of_the_venn_diagram_opens_its_frame_and_a_region_its_encounters(
    clicked: int | str, monkeypatch: pytest.MonkeyPatch
):
    opened_rows: list[int] = []
    opened_categories: list[str] = []
    monkeypatch.setattr(venn, "clicked_chart", lambda *_, **__: clicked)
    monkeypatch.setattr(venn, "open_row", opened_rows.append)
    monkeypatch.setattr(venn, "_open", opened_categories.append)
    checked(part(VENN).run())
    assert [*opened_rows, *opened_categories] == [clicked]


def test_regions_say_what_they_mean_for_the_next_version_of_a_system(page: AppTest):
    assert "newly misses" in page.button(key="open_x_only").proto.help
    assert "mends" in page.button(key="open_y_only").proto.help


def test_the_encounters_that_weigh_most_are_listed_and_open_by_a_click(
    monkeypatch: pytest.MonkeyPatch,
):
    page = checked(part(WORST).run())
    (table,) = tables(page)
    larger = table[["severity_s_x", "severity_s_y"]].max(axis=1)
    assert len(table) == venn.N_WORST
    assert larger.is_monotonic_decreasing
    result = page.session_state["workspace"].result
    assert larger.iloc[0] == max(
        result.x.failures["severity_s"].max(), result.y.failures["severity_s"].max()
    )
    shown: list[int] = []
    monkeypatch.setattr(venn, "open_row", shown.append)
    page.session_state["overview_open"] = 123
    checked(page.run())
    assert shown == [123]


def test_all_failures_are_reviewed_one_by_one_from_the_heaviest_on(app: AppTest):
    press(app, "overview_review")
    assert app.title[0].value == "Encounters"
    assert "**1** of 38" in texts(app)  # distant ones are no failures
    assert not app.button(key="encounters_next").disabled


def test_every_kind_of_moment_can_be_looked_at():
    page = closer("moments")
    for kind in ("x", "y", "x_better", "y_better"):
        page.session_state["moments"] = kind
        checked(page.run())
        assert [button for button in page.button if button.label == "Open frame"]


def test_the_picture_of_a_moment_is_around_the_pedestrian_who_is_named(
    monkeypatch: pytest.MonkeyPatch,
):
    drawn: dict[tuple[int, int], bytes] = {}

    def thumbnail(what: tuple[int, int], draw: Callable[[], bytes]) -> bytes:
        return drawn.setdefault(what, draw())

    monkeypatch.setattr(moments.drawing, "thumbnail", thumbnail)
    result = closer("moments").session_state["workspace"].result
    table = worst_moments(result, n=moments.N_MOMENTS)
    for moment in table[table["kind"] == "x"].to_dict("records"):
        start, stop = result.dataset.truth.offsets[moment["row"] : moment["row"] + 2]
        at = start + result.tracks.track[start:stop].tolist().index(moment["track"])
        box = np.array([getattr(result.dataset.truth, name)[at] for name in "xywh"])
        assert moments.named_box(result, moment).tolist() == box.tolist()
        content = np.frombuffer(drawn[moment["row"], moment["track"]], np.uint8)
        shape = cv2.imdecode(content, cv2.IMREAD_COLOR).shape
        height, width, _ = cut_out(np.zeros((960, 1280, 3)), 2 * box).shape  # drawn twice as large
        assert shape[1] == min(width, moments.THUMBNAIL_PX)
        assert shape[1] / shape[0] == pytest.approx(width / height, rel=0.01)
    assert moments.named_box(result, {**moment, "track": pd.NA}) is None
    assert moments.named_box(result, {**moment, "track": 10_000}) is None


def test_the_page_says_why_many_encounters_have_no_marks(
    page: AppTest, monkeypatch: pytest.MonkeyPatch
):
    assert "Each mark is an encounter" in texts(page)
    monkeypatch.setattr(venn, "MOST_MARKS", 20)
    without = texts(checked(part(VENN).run()))
    assert "Encounters have marks of their own only up to 20 of them" in without


def forest(app: AppTest) -> str:
    """The forest plot of subgroups, as sent to the browser; empty: none is drawn."""
    return "".join(str(plot) for plot in figures(app) if "X minus Y, by group" in str(plot))


def test_the_figure_that_groups_are_compared_in_can_be_chosen():
    app = closer("groups")
    box = app.selectbox(key="subgroup_figure")
    assert box.value == "encounters_detected"
    label = "Share of encounters detected, within these recordings"
    assert f"{label}: X minus Y, by group" in forest(app)
    for measure, title, group in (
        ("saliency", "Saliency of a recording", "place: edge"),
        ("log_average_miss_rate", "Log-average miss rate: X minus Y, by group", "distance: near"),
    ):
        checked(app.selectbox(key="subgroup_figure").set_value(measure).run())
        assert title in forest(app)
        assert group in forest(app)
        assert "a false alert belongs to no pedestrian" not in texts(app)
    box = app.selectbox(key="subgroup_figure")
    checked(box.set_value("false_alert_episodes_per_hour").run())
    assert "a false alert belongs to no pedestrian" in texts(app)
    assert "place: edge" not in forest(app)


def test_a_window_that_was_clicked_is_opened_in_the_timeline(monkeypatch: pytest.MonkeyPatch):
    rows: list[int] = []
    monkeypatch.setattr(moments, "open_row", rows.append)
    page = closer("windows")
    (table,) = tables(page)
    assert table["recording"].iloc[0] == "all recordings"
    assert len(table) == 11
    page.session_state["clicked_window"] = 57
    checked(page.run())
    assert rows == [57]


@pytest.mark.parametrize(
    ("column", "row"), [("window_time_s_y", 7), ("lost_s_per_min_x", 3), ("recording", 3), ("", 3)]
)
def test_a_click_means_the_column_s_system_or_the_worse_one(column: str, row: int):
    columns = {"window_similarity_x": [1, 0.2], "window_similarity_y": [1, 0.3]}
    table = pd.DataFrame({**columns, "window_row_x": [0, 3], "window_row_y": [0, 7]})
    assert window_row(table, 1, column) == row


def test_the_verdict_waits_for_the_comparison_at_equal_false_alarms(
    app: AppTest, monkeypatch: pytest.MonkeyPatch
):
    known: list[bool] = []

    def noted(*of: object, **more: object) -> Verdict:
        known.append(more["companions"] is not None)
        return verdict(*of, **more)

    monkeypatch.setattr(companions, "QUICK_BOXES", 0)  # in the background, as with many boxes
    monkeypatch.setattr(verdict_page, "verdict", noted)
    app.slider(key="alpha").set_value(0.5).run()
    assert "Of the 13 encounters that only one system detects, X detects 8 and Y 5" in texts(app)
    job = app.session_state["workspace"].job("companions")
    job.join()
    checked(app.run())
    assert known[-1]
    assert app.session_state["workspace"].job("companions") is job


def test_the_operating_point_is_that_of_every_page_and_of_the_address(app: AppTest):
    mark, control = "As set, at unequal operating points", "operating_point"
    assert mark not in texts(app)
    assert control not in {group.key for group in app.button_group}
    checked(app.slider(key="threshold_x").set_value(0.1).run())
    alarms = "false alarms per frame ↓"
    at_equal = scorecard(app)[alarms]
    assert (
        texts(app).count("At equal false alarms, not as set (X at a confidence threshold of ") == 1
    )
    assert mark not in texts(app)
    assert "point" not in app.query_params
    checked(app.button_group(key=control).set_value("as-set").run())
    assert texts(app).count(mark) == 1
    assert scorecard(app)[alarms] != at_equal
    assert app.query_params["point"] == "as-set"
    for name in ("timeline", "encounters", "saliency"):
        assert texts(checked(to_page(app, name))).count(mark) == 1
    checked(app.button_group(key=control).set_value("equal-alarms").run())
    assert mark not in texts(app)
    checked(to_page(app, "overview"))
    assert scorecard(app)[alarms] == at_equal
    checked(app.button(key="keep_threshold").click().run())
    assert control not in {group.key for group in app.button_group}
    assert scorecard(app)[alarms] == at_equal
