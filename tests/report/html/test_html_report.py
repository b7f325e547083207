"""The HTML report: what it says, that names stay text, that it is the same each time."""

from __future__ import annotations

import re
from concurrent.futures import CancelledError
from dataclasses import replace

import pytest
from builders import Place, at, make_dataset, result_of
from drives import at_thresholds
from inputs import drive, session_of
from limits import limits_read
from report_page import Page, written

from nvcore import __version__
from nvcore.common.arguments.report import Inscription
from nvcore.common.errors import InputError
from nvcore.common.findings import Finding, Severity
from nvcore.common.wording import number
from nvcore.comparison.compare import Result, compare
from nvcore.evidence.bootstrap import INTERVAL_RULE
from nvcore.evidence.operating_points import find_equal_alarms
from nvcore.figures.venn import venn_figure
from nvcore.inputs.load import load
from nvcore.inputs.session import Session
from nvcore.report.html import write_html_report
from nvcore.report.html.page import css_text
from nvcore.report.section import (
    MAX_CELL,
    MAX_NOTE,
    MAX_PRINTED,
    MAX_ROWS,
    Chart,
    Paragraphs,
    Table,
    table,
)
from nvcore.report.sections import encounters as encounter_sections
from nvcore.report.sections import results as result_sections
from nvcore.report.sections.results import classes_section
from nvcore.settings.defaults import Settings
from nvcore.settings.objects import PEDESTRIAN
from nvcore.settings.params import Params
from nvcore.settings.protocols import PROTOCOLS
from nvcore.tables.encounters.severity import weighed_encounters

HOSTILE = "</script><img src=x onerror=alert(1)>{{ 7*7 }}"

FINDINGS = (Finding(Severity.WARNING, "a-code", "nir", 3, "Odd thing.", "Mend it.", "n.csv"),)


@pytest.fixture(scope="module")
def session(tmp_path_factory: pytest.TempPathFactory) -> Session:
    return session_of(drive(tmp_path_factory.mktemp("drive")))


@pytest.fixture(scope="module")
def result(session: Session) -> Result:
    return compare(load(session))


@pytest.fixture(scope="module")
def content(result: Result, session: Session, tmp_path_factory: pytest.TempPathFactory) -> str:
    """The one whole report of this module, of its `drive`."""
    path = tmp_path_factory.mktemp("report") / "report.html"
    return written(path, result, session, FINDINGS)


@pytest.fixture(scope="module")
def page(content: str) -> Page:
    return Page(content)


def test_every_section_says_what_it_is_about(content):
    anchors = re.findall(r'<section id="([\w-]+)">', content)
    assert anchors == [
        "verdict", "scorecard", "encounters", "time-left", "similarity", "saliency",
        "false-alerts", "significance", "plan", "subgroups", "detection", "stability", "frames",
        "only-one", "audit", "inputs", "parameters", "reading", "appendix",
    ]  # fmt: skip
    assert re.findall(r'<li><a href="#([\w-]+)">', content) == anchors
    introduced = re.findall(r'<section id="([\w-]+)">\s*<h2>.*?</h2>\s*<p class="what">', content)
    assert introduced == [anchor for anchor in anchors if anchor not in ("reading", "appendix")]
    for anchor in re.findall(r'href="#(about-[\w-]+)"', content):
        assert content.count(f'<h3 id="{anchor}">') == 1


def test_what_classes_were_read_is_counted_by_hand():
    section = classes_section(limits_read()).worded(PEDESTRIAN)
    read_by_x, figure, counts, read_by_y = section.blocks
    assert read_by_x == Paragraphs(
        ("X: class correct in 60.0 % of 5 matches, 95 % confidence interval 23.1 % to 88.2 % "
         "(Wilson, as if boxes were independent).",)
    )  # fmt: skip
    assert isinstance(figure, Chart)
    assert isinstance(counts, Table)
    assert counts.rows == (
        ("30", "30", "2"),
        ("30", "50", "1"),
        ("50", "50", "1"),
        ("50", "no class", "1"),
    )
    assert read_by_y == Paragraphs(("Y names no classes.",))


def test_the_report_has_classes_where_there_are_any(tmp_path):
    content = written(tmp_path / "report.html", limits_read(), Settings(), ())
    assert '<section id="classes">' in content
    assert "What the systems took the matched pedestrians for" in content


def cover(content: str) -> str:
    return content.partition('<div class="cover">')[2].partition('<dl class="facts">')[0]


def test_the_first_page_has_verdict_tiles_frames_and_limits(content, result):
    first = cover(content)
    assert "<h1>fir (X) and nir (Y) compared</h1>" in first
    assert 'class="question"' not in first
    assert "too few" in first.lower()
    assert first.count('class="tile"') == 4
    assert 1 <= first.count("<img src=") <= 2
    assert "2 recordings: the result for others is open (6 are needed)." in first
    assert "Bars: " not in first  # so few recordings have no intervals
    assert 'class="dot"' not in first


def test_the_first_page_says_who_x_and_y_are_and_on_what_they_are_compared(content):
    first = Page(cover(content)).text
    assert "fir, every detection counts" in first
    assert "nir, every detection counts" in first
    assert "2 recordings, 40 evaluated frames, 2 s, 40 pedestrian boxes; 2 encounters" in first


def test_measures_that_are_0_for_both_have_a_sentence_instead_of_a_tile(tmp_path):
    truth = [at(frame, 50, track=1) for frame in range(8)]
    result = result_of(make_dataset(truth, truth, truth))
    content = written(tmp_path / "r.html", result, session_of(tmp_path), stability=False)
    first = cover(content)
    assert first.count('class="tile"') == 1
    assert "0 for both: time missed, false-alert episodes, worst miss." in first


def test_negative_numbers_have_a_minus_and_no_hyphen(page):
    text = " ".join(words for words in page.words if not words.startswith("\n:root"))  # no style
    assert re.search(r"−\d", text)
    assert re.findall(r"(?<![\w.])-(?=\.?\d)|X - Y", text) == []


def test_long_tables_say_on_paper_how_many_rows_are_left_out_and_where_they_are(content, page):
    n_left_out = len(page.tables["Parameters"]) - 1 - MAX_PRINTED
    assert content.count('<tr class="screen">') >= n_left_out > 0
    assert f'<p class="note paper">{n_left_out} more: in the HTML file.</p>' in content


def test_what_the_author_writes_stands_on_the_first_page_as_text(result, session, tmp_path):
    inscription = Inscription(
        title="Night <b>drive</b>", author="A. N. Other", question="Which\none?", date="1 May"
    )
    content = written(
        tmp_path / "r.html", result, session, stability=False, inscription=inscription
    )
    first = cover(content)
    assert "<h1>Night &lt;b&gt;drive&lt;/b&gt;</h1>" in first
    assert '<p class="subtitle">fir (X) and nir (Y) compared</p>' in first
    assert "A. N. Other, 1 May" in first
    assert r"Which\none?" in first


def test_the_heaviest_encounter_is_weighed_by_all_three(page: Page):
    caption = "The heaviest encounter, weighted by height, horizon and distance"
    assert page.row(caption, "height (in use)")[1:] != ["–"] * 4
    assert page.row(caption, "distance") == ["–"] * 5


def test_the_scorecard_has_the_measures_counted_by_hand(page):
    # fir matches all 40 boxes of 2 pedestrians, nir 10 of them, with one false alarm
    caption = "Measures of X and Y"
    assert page.row(caption, "encounters detected, of 2") == ["2", "1", "+1", "higher"]
    assert page.row(caption, "boxes matched, near or far, of 40") == ["40", "10", "+30", "higher"]
    assert page.row(caption, "false-alert episodes") == ["0", "1", "−1", "lower"]
    assert page.row("Detection measures", "recall at the threshold")[:2] == ["1.0000", "0.2500"]
    assert "Log-average miss rate of X: nothing is missed at any of the 9 references" in page.text
    assert "Few pedestrians: 40, a single miss changes" in page.text


def test_encounters_have_who_detects_them_and_what_a_fusion_gives(page):
    assert page.row("Encounters by who detects them", "only X")[:2] == ["1", "0.00"]
    assert page.row("Encounters by who detects them", "distant")[:3] == ["0", "–", "–"]
    assert page.tables["Boxes of pedestrians by who matches them"][1] == ["10", "30", "0", "0"]
    assert [row[:3] for row in page.tables["X and Y as one system"][1:]] == [
        ["X alone", "2", "0"], ["Y alone", "1", "1"], ["X or Y", "2", "1"], ["X and Y", "1", "0"],
    ]  # fmt: skip
    assert "“X or Y” detects 2 of 2 encounters, as many as X alone" in page.text
    _, row = page.tables["1 encounter that only one system detects"]
    assert row[:4] == ["only X", "rural", "1", "0.00"]
    assert row[-3:] == ["100 %", "0 %", "never"]


def test_the_encounters_that_weigh_most_are_listed(page, result):
    caption = "The encounters whose failures weigh most"
    row, late = page.tables[caption][1:]
    severity_s = result.y.failures["severity_s"].max()
    assert late[2] == "both"
    assert float(late[5]) < float(row[5])
    assert row[:4] == ["rural", "1", "only X", "0.00"]
    assert row[4:6] == ["0.00", f"{severity_s:.2f}"]
    assert row[8:] == ["none", "never"]
    (category,) = [
        row for row in page.tables["Encounters by who detects them"] if row[0] == "only X"
    ]
    assert category[3] == f"{severity_s:.2f}"


@pytest.mark.parametrize(
    ("x", "y", "loser", "text"),
    [
        ("x", "y", "y", "orange (diamond) where Y's"),
        ("y", "x", "x", "orange (diamond) where X's failure weighs more"),
    ],
)
def test_the_words_say_with_which_marks_the_diagram_is_drawn(x, y, loser, text):
    boxes = [at(frame, 50, track=1) for frame in range(8)]
    result = compare(make_dataset(boxes, boxes, boxes[:2]), Params(), x=x, y=y)
    scheme = result.scheme("light")
    figure = venn_figure(
        result.venn, (x, y), theme=scheme, encounters=weighed_encounters(result), objects=PEDESTRIAN
    )
    marks = next(trace.marker for trace in figure.data if "severity" in trace.name)
    style = scheme.style(loser)
    assert (marks.symbol[0], marks.color[0]) == (style.symbol, style.light)
    section = encounter_sections.encounters_section(result).worded(PEDESTRIAN)
    assert text in section.about["best"]


def test_subgroups_have_who_detects_more_and_the_other_figures(page):
    caption = "Encounters detected by subgroup"
    assert page.row(caption, "all")[1:6] == ["2", "1", "1", "0", "0"]
    # groups of two recordings have neither interval nor test
    assert [name for name in page.tables if name.endswith(", by subgroup")] == []
    assert "rows with too little data for an interval or a test left out" in page.text


def test_every_choice_of_settings_has_its_row(page):
    rows = {(row[0], row[1]): row[2:] for row in page.tables["Verdict and settings"][1:]}
    assert len(rows) == 6 * 3
    outcome, share, _ = rows["Both thresholds", "mean similarity"]
    assert outcome.startswith(("X has", "Y has"))
    assert share.endswith("%") or share in ("all", "none")
    assert rows["Traffic context and alpha", "encounters detected"][1:] == [
        "does not depend on them", "–",
    ]  # fmt: skip
    assert "By mean similarity: " in page.text
    assert page.text.count("false alarms per frame.") == 3  # one for each criterion


def test_audit_inputs_and_parameters(page, result):
    finding = ["nir", "Odd thing.", "n.csv", "Mend it."]
    assert page.row("1 finding, worst first", "warning") == finding
    hashes = result.dataset.inputs.set_index("subject")["sha256"]
    assert page.row("Files", "fir")[1] == hashes["fir"]
    assert [row[:2] for row in page.tables["Sources"][1:]] == [
        ["truth", "ground truth"], ["fir", "X"], ["nir", "Y"],
    ]  # fmt: skip
    assert result.dataset.fingerprint in page.text
    assert f"nvcore {__version__}" in page.text
    rows = {row[0]: row for row in page.tables["Parameters"][1:]}
    assert list(rows) == list(Params().stated())
    assert rows["alpha"][1:3] == ["0.9", "0.9"]
    assert rows["midpoint"][1] == "48 px"  # 10 % of the height
    assert all(row[-1].endswith(".") for row in rows.values())
    assert "here with midpoint 48 px (10 % of the height of each recording's picture) and" in (
        page.text
    )
    assert page.row("Recordings", "rural")[3:5] == ["48", "9.6"]


def test_both_systems_are_named_all_the_way_and_paper_has_page_numbers(content, result):
    head, _, _body = content.partition("<main>")
    running = head.partition('<div class="running"')[2]
    assert "<strong>X</strong>fir" in running
    assert "<strong>Y</strong>nir" in running
    page = content.partition("@page {")[2].partition("@media print")[0]
    assert r'content: "fir \28 X\29  and nir \28 Y\29  compared"' in page
    assert "counter(page)" in page
    assert result.dataset.fingerprint in page


def test_a_text_in_css_can_end_neither_it_nor_the_style():
    assert css_text('"; } </style>', 80) == r'"\22 \3b  \7d  \3c \2f style\3e "'
    assert css_text("a" * 90, 5) == r'"aaaa\2026 "'


def test_charts_are_figures_of_plotly_and_nothing_is_fetched_from_elsewhere(page, content):
    charts = page.charts()
    assert len(charts) == content.count('<figure class="chart"') > 0
    assert {chart["layout"]["title"].get("text") for chart in charts.values()} == {None}
    captions = re.findall(r"<figcaption><strong>(.*?)</strong> <span class=.muted.>", content)
    assert "Similarity by recording" in captions
    assert not re.search("click", " ".join(captions), flags=re.IGNORECASE)
    assert re.findall(r'(?:src|href)="(?!#|data:image/jpeg;base64,)[^"]*"', content) == []
    assert "@import" not in content
    assert "default-src 'none'" in content


def test_the_same_comparison_gives_the_same_bytes(session, tmp_path, content):
    again = compare(load(session))
    assert written(tmp_path / "again.html", again, session, FINDINGS) == content


def test_changed_parameters_and_the_protocol_are_told_and_the_stability_map_may_be_left_out(
    result, session, tmp_path
):
    changed = compare(result.dataset, Params(alpha=0.625, proximity="none", match="lateral"))
    session = replace(session, protocol=PROTOCOLS["reasonable"])
    content = written(tmp_path / "r.html", changed, session, stability=False)
    page = Page(content)
    assert page.row("Parameters", "alpha")[:2] == ["0.625, changed", "0.9"]
    assert "1 − (0.625 × D(truth, system) + 0.375 × D(system, truth))" in page.text
    assert "1 for everybody" in page.text
    assert "at most 2 % of the picture's width" in page.text
    assert "Protocol reasonable:" in page.text
    assert "height 50 or more px" in page.text
    assert "Not computed for these 40 frames" in page.text
    assert 'id="chart-stability"' not in content


def test_frames_rather_than_persons_are_no_evidence_of_their_own(tmp_path, page):
    truth = [at(f, 50, track=f) for f in range(12)]
    places = [Place(range(12), height=100.0), Place([0, 1], height=120.0)]
    untracked = at(0, 50, recording=1)
    dataset = make_dataset([*truth, untracked], truth, truth[:2], places=places)
    result = compare(replace(dataset, notes=("evaluated frames: as given",)))
    content = written(tmp_path / "r.html", result, session_of(tmp_path), stability=False)
    for anchor, sentence in (
        ("encounters", "shares of encounters are shares of frames"),
        ("significance", "one pedestrian may stand in many of them"),
        ("subgroups", "one pedestrian may stand in many of them"),
    ):
        section = content.partition(f'<section id="{anchor}">')[2].partition("</section>")[0]
        assert sentence in section
    assert "A split this uneven" not in content
    short = Page(content)
    label = "share of encounters detected, within these recordings"
    assert short.row("Differences and tests", f"{label} ↑")[3:7] == ["–"] * 4
    assert short.row("Methods", label)[1] == "–"
    assert {row[-2] for row in short.tables["Encounters detected by subgroup"][1:]} == {"–"}
    assert "one pedestrian may stand" not in page.text
    # recordings of two sizes have two midpoints
    assert "midpoint 10 to 12 px (10 %" in short.text
    assert short.row("Parameters", "midpoint")[0] == "10 to 12 px"
    assert "Evaluated frames: as given." in short.words
    assert "The truth of 1 recording has pedestrians without track ids" in short.text


def test_the_heaviest_of_many_encounters_that_only_one_detects_are_listed(tmp_path, monkeypatch):
    for module in (encounter_sections, result_sections):
        monkeypatch.setattr(module, "MAX_ROWS", 6)
    # track t is missed by Y for t + 1 frames at 10 fps, all of full weight
    truth = [at(f, 50, track=t, recording=t) for t in range(8) for f in range(1 + t)]
    result = result_of(
        make_dataset(truth, truth, [], places=[Place(range(8))] * 8), proximity="none"
    )
    page = Page(written(tmp_path / "r.html", result, session_of(tmp_path), stability=False))
    rows = page.tables["8 encounters that only one system detects"][1:]
    assert [float(row[4]) for row in rows] == pytest.approx([0.8, 0.7, 0.6, 0.5, 0.4, 0.3])
    assert "The heaviest 6 are shown, 2 are left out." in page.text
    assert "The 6 recordings in which the systems differ most are shown, 2 are left out." in (
        page.text
    )


def test_long_texts_and_tables_are_cut():
    long = table("t", ["a"], [["x" * 5000]] * (MAX_ROWS + 1), notes=["y" * 9000])
    assert len(long.rows) == MAX_ROWS
    assert max(len(cell) for row in long.rows for cell in row) == MAX_CELL
    assert len(long.note) == MAX_NOTE


def test_names_from_files_are_text(tmp_path):
    drive(tmp_path)
    for name in ("truth", "fir", "nir"):
        path = tmp_path / f"{name}.csv"
        path.write_text(path.read_text().replace("urban", HOSTILE))
    session = session_of(tmp_path)
    dataset = replace(load(session), systems=(HOSTILE, "<b>nir</b>"))
    findings = (Finding(Severity.ERROR, "x", HOSTILE, 1, HOSTILE, HOSTILE, HOSTILE, HOSTILE),)
    content = written(tmp_path / "r.html", compare(dataset), session, findings)
    page = Page(content)
    pictures = content.count('<img src="data:')
    assert page.tags.count("img") == pictures  # none of them from a name
    assert page.tags.count("b") == 0
    assert page.row("Similarity by recording", HOSTILE)[0] == "20"
    assert f"{HOSTILE} (X) and <b>nir</b> (Y) compared" in page.words
    # their JSON is whole: no name ended its script
    assert len(page.charts()) == content.count('<figure class="chart"') > 0


@pytest.mark.parametrize(
    "dataset",
    [
        make_dataset(n_frames=3),
        make_dataset(places=[Place([])]),
        make_dataset([(0, 10, 10, 5, 50, 1)], [(0, 10, 10, 5, 50)]),
        make_dataset([], [(0, 10, 10, 5, 50)], [(0, 50, 10, 5, 50, -1, 0.4)]),
    ],
    ids=["nobody", "no frame", "one frame", "false alarms only"],
)
def test_with_next_to_no_data_it_says_what_is_undefined(dataset, tmp_path):
    content = written(tmp_path / "r.html", result_of(dataset), session_of(tmp_path))
    page = Page(content)
    assert "nan" not in re.sub(r"<script.*?</script>", "", content, flags=re.DOTALL).lower().split()
    assert len(page.tables["Measures of X and Y"]) > 10


def test_a_cancelled_report_leaves_nothing(result, session, tmp_path):
    shares = []

    def progress(share: float, _what: str) -> None:
        shares.append(share)
        if share >= 0.3:
            raise CancelledError

    path = tmp_path / "r.html"
    with pytest.raises(CancelledError):
        write_html_report(result, session, (), path, progress=progress)
    assert not path.exists()
    assert shares == [0.0, 0.15, 0.3]


def test_a_folder_that_cannot_be_written_is_told(result, session, tmp_path):
    (tmp_path / "file").write_text("")
    with pytest.raises(InputError, match="cannot be written"):
        write_html_report(result, session, (), tmp_path / "file" / "r.html", stability=False)


def test_all_numbers_are_at_one_operating_point(tmp_path):
    path, result = tmp_path / "report.html", at_thresholds()
    equal = find_equal_alarms(result)
    for of, n_marked in ((result, 10), (equal, 0)):
        write_html_report(of, Settings(), (), path, stability=False)
        page = Page(path.read_text(encoding="utf-8"))
        as_set = "As set, at unequal operating points"
        assert sum(text.startswith(as_set) for text in page.words) == n_marked
        assert ("nothing is claimed from that comparison." in page.text) == (of is result)
        assert ("At equal false alarms, not as set (X at a confidence" in page.text) == (
            of is equal
        )
        rows = {row[0]: row[1:] for row in page.tables["Measures of X and Y"][1:]}
        assert rows["mean similarity"][0] == number(of.x.summary.mean, ".4f")
        assert f"of {of.venn.n_near}" in page.text
    assert INTERVAL_RULE in " ".join(page.words)
    assert "“X or Y” can detect one that neither system does" in page.text
