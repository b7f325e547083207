"""The calls of Python users: they use what the session says, and write what the program writes."""

from __future__ import annotations

import inspect
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import plotly.graph_objects as go
import pytest
from inputs import FACTS, flags, nvcore, session_of
from places import SAMPLE

import nvcore as nv
from nvcore.api.comparison import Comparison
from nvcore.common.findings import Severity
from nvcore.common.output.files import LOCK
from nvcore.report.files import summary_json
from nvcore.report.terminal import render_scorecard
from nvcore.settings.params import Params
from nvcore.settings.protocols import PROTOCOLS

SIZE = {"size": (640, 480), "fps": 20.0}


@pytest.fixture(scope="module")
def sample() -> Comparison:
    return nv.compare(SAMPLE)


def paths(folder: Path) -> dict[str, Path]:
    return {key: folder / f"{name}.csv" for key, name in zip(KEYS, FILES, strict=True)}


KEYS, FILES = ("truth", "x", "y"), ("truth", "fir", "nir")


def tables(folder: Path) -> dict[str, pd.DataFrame]:
    return {key: pd.read_csv(path) for key, path in paths(folder).items()}


def written(folder: Path) -> dict[str, bytes]:
    return {path.name: path.read_bytes() for path in folder.iterdir() if path.name != LOCK}


# what a session says is used


def test_the_sessions_thresholds_are_used(sample: Comparison):
    assert (sample.params.threshold_x, sample.params.threshold_y) == (0.5, 0.5)
    assert sample.x.summary.mean == pytest.approx(0.9152, abs=5e-5)


def test_each_way_to_name_a_session_compares_the_same(sample: Comparison):
    for source in (str(SAMPLE), nv.read_session(SAMPLE), nv.load(SAMPLE)):
        assert summary_json(nv.compare(source).result) == summary_json(sample.result)


def test_a_keyword_goes_before_the_session(folder: Path):
    session = replace(session_of(folder), params=Params(alpha=0.7, lag_s=1.0))
    params = nv.compare(session, alpha=0.8).params
    assert (params.alpha, params.lag_s) == (0.8, 1.0)
    assert nv.compare(session).params.alpha == 0.7


def test_a_threshold_of_none_goes_before_any_other_and_counts_every_detection(folder: Path):
    systems = (nv.SystemSource("fir.csv", threshold=0.85), nv.SystemSource("nir.csv"))
    session = replace(session_of(folder), systems=systems)
    limited = nv.compare(session)
    assert (limited.x.threshold, limited.x.n_det.sum()) == (0.85, 12)
    for again in (nv.compare(session, threshold_x=None),
                  nv.compare(limited.dataset, threshold_x=None)):  # fmt: skip
        assert (again.x.threshold, again.x.n_det.sum()) == (None, 40)


def test_the_dataset_of_a_result_keeps_what_was_set(folder: Path):
    changed = nv.compare(**paths(folder), **SIZE, alpha=0.6, protocol="reasonable")
    again = nv.compare(changed.dataset)
    assert (again.params.alpha, again.protocol) == (0.6, PROTOCOLS["reasonable"])


def test_a_name_chooses_a_system_with_its_own_threshold(folder: Path):
    systems = (nv.SystemSource("fir.csv", threshold=0.8), nv.SystemSource("nir.csv", threshold=0.6))
    dataset = nv.load(replace(session_of(folder), systems=systems, x="fir", y="nir"))
    swapped = nv.compare(dataset, name_x="nir")
    assert (swapped.x.name, swapped.y.name) == ("nir", "fir")
    assert (swapped.params.threshold_x, swapped.params.threshold_y) == (0.6, 0.8)


def test_an_audit_uses_the_sessions_thresholds(folder: Path):
    session = session_of(folder, "truth.csv", nv.SystemSource(("fir.csv",), threshold=2.0))
    assert "threshold-keeps-nothing" in {finding.code for finding in nv.audit(session)}
    assert nv.audit(nv.load(session)) == nv.audit(session)


# tables in memory


def test_tables_compare_as_their_files_do_and_can_be_mixed_with_them(folder: Path):
    of_files = nv.compare(**paths(folder), **SIZE)
    of_tables = nv.compare(**tables(folder), **SIZE)
    pd.testing.assert_frame_equal(of_files.frames, of_tables.frames)
    pd.testing.assert_frame_equal(of_files.encounters, of_tables.encounters)
    assert (of_tables.x.name, of_tables.y.name) == ("X", "Y")
    mixed = nv.compare(**{**paths(folder), "y": tables(folder)["y"]}, **SIZE, name_y="candidate")
    assert (mixed.x.name, mixed.y.name) == ("fir", "candidate")


def test_tables_of_one_recording_need_not_name_it(folder: Path):
    urban = {
        key: table[table["recording"] == "urban"].drop(columns="recording")
        for key, table in tables(folder).items()
    }
    result = nv.compare(**urban, **SIZE)
    assert len(result.recordings) == 1
    assert result.y.matches.is_matched.sum() == 10


@pytest.mark.parametrize(
    ("key", "column", "value", "words"),
    [
        ("x", "x", "left", r"x \(table\), row 7: expected a number as x, found 'left'"),
        ("x", "frame", 7.5, r"x \(table\), row 7: expected a whole number as frame, found 7.5"),
        ("x", "recording", None, r"x \(table\), row 7: expected the name of a recording"),
        ("truth", "ignore", "no", r"row 7: expected 0, 1, true or false as ignore"),
    ],
)
def test_a_wrong_cell_is_an_error_with_its_row(
    folder: Path, key: str, column: str, value: object, words: str
):
    given = tables(folder)
    given["truth"]["ignore"] = 0
    given[key] = given[key].astype({column: object})
    given[key].iloc[7, given[key].columns.get_loc(column)] = value
    with pytest.raises(nv.NvcoreError, match=words):
        nv.compare(**given, **SIZE)


@pytest.mark.parametrize(
    ("column", "words"),
    [
        ("w", r"x \(table\): expected the columns .* missing: w"),
        ("recording", "as the ground truth has 2 recordings"),
    ],
)
def test_a_missing_column_is_an_error_that_names_it(folder: Path, column: str, words: str):
    given = tables(folder)
    given["x"] = given["x"].drop(columns=column)
    with pytest.raises(nv.NvcoreError, match=words):
        nv.compare(**given, **SIZE)


def test_marks_to_ignore_and_empty_cells_are_read_as_in_a_file(folder: Path, tmp_path: Path):
    given = tables(folder)
    truth = given["truth"].assign(
        ignore=[None, True, False, "1", 0.0] * 8, track=["a", "b"] * 20, distance_m=[5.0, None] * 20
    )
    file = tmp_path / "truth.csv"
    truth.to_csv(file, index=False)
    of_file = nv.load(truth=file, x=given["x"], **SIZE).boxes
    of_table = nv.load(truth=truth, x=given["x"], **SIZE).boxes
    pd.testing.assert_frame_equal(of_file.drop(columns="line"), of_table.drop(columns="line"))


def test_findings_about_a_table_name_its_row(folder: Path):
    given = tables(folder)
    given["x"].loc[3, "w"] = 0.0
    finding = next(finding for finding in nv.audit(**given, **SIZE) if finding.code == "no-area")
    assert (finding.file, finding.example.split(",")[0]) == ("x (table)", "row 3")


# what cannot be done


def test_an_unknown_setting_says_which_there_are():
    with pytest.raises(nv.NvcoreError, match=r"no parameter 'alpa'; did you mean 'alpha'\? The .*"):
        nv.compare(SAMPLE, alpa=0.8)


def test_without_inputs_and_with_too_many_it_is_an_error(folder: Path):
    with pytest.raises(nv.NvcoreError, match="expected a session file, or truth="):
        nv.compare()
    with pytest.raises(nv.NvcoreError, match="give one of the two"):
        nv.compare(SAMPLE, x=folder / "fir.csv")
    with pytest.raises(nv.NvcoreError, match="truth is missing"):
        nv.compare(x=folder / "fir.csv", y=folder / "nir.csv")


def test_what_is_missing_or_comes_too_late_is_asked_for_by_its_keyword(folder: Path):
    dataset = nv.load(**paths(folder), **SIZE)
    with pytest.raises(nv.NvcoreError, match=r"loaded already: give fps= to load\(\)"):
        nv.compare(dataset, fps=10)
    with pytest.raises(nv.NvcoreError, match=r"in Python: size=\(WIDTH, HEIGHT\), fps=FPS"):
        nv.load(**paths(folder))


def test_a_size_may_be_written_as_on_the_command_line(folder: Path):
    as_text = nv.load(**paths(folder), size="640x480", fps=20)
    assert nv.compare(as_text).summary == nv.compare(**paths(folder), **SIZE).summary
    for wrong in ("640", (640,), (640, 480, 3), (640, 0), (640.5, 480), 640):
        with pytest.raises(nv.NvcoreError, match=r'expected \(WIDTH, HEIGHT\) in pixels or "WID'):
            nv.load(**paths(folder), size=wrong, fps=20)


def test_one_system_is_enough_to_audit_but_not_to_compare(folder: Path):
    inputs = {key: path for key, path in paths(folder).items() if key != "y"}
    assert isinstance(nv.audit(**inputs, **SIZE), tuple)
    with pytest.raises(nv.NvcoreError, match="a comparison needs two systems"):
        nv.compare(**inputs, **SIZE)


# what comes back


def test_its_repr_is_a_single_line(sample: Comparison):
    assert repr(sample) == (
        "<Comparison of FIR (X) and NIR (Y): 10 recordings, 3,000 frames, 38 encounters, "
        "mean similarity 0.9152 and 0.8963>"
    )


def test_a_notebook_shows_a_table_in_which_names_are_text(folder: Path):
    shown = nv.compare(**tables(folder), **SIZE, name_x="<b>new</b>")._repr_html_()
    assert "<td>mean similarity ↑</td>" in shown
    assert "&lt;b&gt;new" in shown
    assert "<b>" not in shown


def test_tables_have_the_columns_of_the_report(sample: Comparison):
    for name in ("frames", "encounters", "events", "intervals", "recordings"):
        columns = nv.tables.report_columns()[f"{name}.csv"]
        expected = [column.name for column in columns if not column.only_if]
        assert list(getattr(sample, name)) == expected


def test_the_verdict_and_the_evidence_are_those_of_the_scorecard(sample: Comparison):
    conclusion = " ".join(render_scorecard(sample.result).split()).split("In short: ")[1]
    assert conclusion.startswith(sample.verdict()[0])
    assert [sentence for sentence in sample.verdict() if sentence not in conclusion] == []
    table = sample.evidence()
    row = table.set_index("figure").loc["mean_similarity"]
    assert row["x"] == pytest.approx(sample.x.summary.mean)
    table.loc[0, "p"] = -1.0
    assert sample.evidence().loc[0, "p"] != -1.0


def test_the_rest_passes_through_to_the_result(sample: Comparison):
    for name in ("dataset", "x", "y", "params", "venn", "exclusivity", "boxes", "duration_s"):
        assert getattr(sample, name) is getattr(sample.result, name)
    assert sample.fusion is sample.result.fusion
    assert sample.of("time_left") is sample.result.of("time_left")
    assert np.array_equal(sample.lead_time_s, sample.result.lead_time_s, equal_nan=True)


def test_every_figure_is_drawn(sample: Comparison):
    names = [name for name in dir(sample.figures) if not name.startswith("_") and name != "dark"]
    assert names
    for name in names:
        assert isinstance(getattr(sample.figures, name)(), go.Figure), name


def test_a_figure_of_a_recording_takes_its_name_or_its_row(sample: Comparison):
    by_name, by_row = sample.figures.timeline("rural_child"), sample.figures.timeline(4)
    assert by_name.to_json() == by_row.to_json() != sample.figures.dark().timeline(4).to_json()
    with pytest.raises(nv.NvcoreError, match="no recording 'rural_chil'; did you mean 'rural_chi"):
        sample.figures.timeline("rural_chil")
    with pytest.raises(nv.NvcoreError, match="there is no encounter 46; there are 46"):
        sample.figures.weightings(46)


# files


def test_its_text_and_files_are_those_of_the_command_line(folder: Path, tmp_path: Path):
    result = nv.compare(**paths(folder), **SIZE, alpha=0.8)
    result.write(tmp_path / "python")
    result.write_html(tmp_path / "python.html", stability=False)
    given = flags(folder, "--alpha", 0.8)
    printed = nvcore("compare", *given, "--out", tmp_path / "shell")
    nvcore("report", *given, "--no-stability", "--out", tmp_path / "shell.html")
    _audit, heading, scorecard, *_ = str(result).split("\n\n")  # its fixes are flags or keywords
    assert f"\n\n{heading}\n\n{scorecard}\n\n" in printed.stdout
    assert written(tmp_path / "python") == written(tmp_path / "shell")
    assert (tmp_path / "python.html").read_bytes() == (tmp_path / "shell.html").read_bytes()


def test_it_writes_parquet_and_every_box(folder: Path, tmp_path: Path):
    result = nv.compare(**paths(folder), **SIZE)
    result.write(tmp_path / "out", tables="parquet", matches=True)
    boxes = pd.read_parquet(tmp_path / "out" / "matches.parquet")
    assert len(boxes) == len(result.matches) == len(result.dataset.boxes)
    assert boxes["file"].str.rpartition("/")[2].unique().tolist() == [
        *("truth.csv", "fir.csv", "nir.csv")
    ]
    with pytest.raises(nv.NvcoreError, match="tables: expected csv or parquet, got 'xlsx'"):
        result.write(tmp_path / "out", tables="xlsx")  # type: ignore[arg-type]


def test_the_session_it_writes_gives_the_same_again(folder: Path, tmp_path: Path):
    systems = (nv.SystemSource("fir.csv", threshold=0.85), nv.SystemSource("nir.csv"))
    first = nv.compare(replace(session_of(folder), systems=systems), threshold_x=None, alpha=0.7)
    first.write(tmp_path / "out")
    assert nv.compare(tmp_path / "out" / "session.toml").summary == first.summary


def test_a_report_of_tables_has_no_session(folder: Path, tmp_path: Path):
    result = nv.compare(**tables(folder), **SIZE)
    result.write(tmp_path / "out")
    assert "summary.json" in written(tmp_path / "out")
    assert "session.toml" not in written(tmp_path / "out")


def test_no_input_and_no_session_of_the_user_is_replaced(folder: Path):
    (folder / "truth.csv").rename(folder / "frames.csv")
    inputs = {**paths(folder), "truth": folder / "frames.csv"}
    result = nv.compare(**inputs, **SIZE)
    with pytest.raises(nv.NvcoreError, match=r"frames\.csv: is an input"):
        result.write(folder)
    with pytest.raises(nv.NvcoreError, match=r"fir\.csv: is an input"):
        result.write_html(folder / "fir.csv")
    other = folder / "other"
    other.mkdir()
    (other / "session.toml").write_text("[truth]\npath = 't.csv'\n")
    with pytest.raises(nv.NvcoreError, match="written by hand"):
        result.write(other)


def test_a_dataset_made_of_tables_is_compared_and_written(tmp_path: Path):
    boxes = pd.DataFrame({
        "frame_index": [0, 1, 0, 1, 0], "source": [0, 0, 1, 1, 2], "x": 300.0, "y": 100.0,
        "w": 40.0, "h": 200.0, "track": [1, 1, -1, -1, -1],
    })  # fmt: skip
    recordings = pd.DataFrame({"name": ["a"], "width": [640], "height": [480], "fps": [10.0]})
    dataset = nv.dataset_from_tables(recordings, [np.arange(2)], boxes, ["new", "old"])
    result = nv.compare(dataset, alpha=0.5)
    assert (result.x.name, result.params.alpha) == ("new", 0.5)
    assert [side.matches.is_matched.sum() for side in (result.x, result.y)] == [2, 1]
    result.write(tmp_path / "out")
    result.write_html(tmp_path / "r.html", stability=False)
    assert "session.toml" not in written(tmp_path / "out")


# rules and conversion


def test_a_gate_is_true_if_all_rules_hold(sample: Comparison, folder: Path):
    assert nv.gate(sample, ["newly_missed <= 8"])
    outcome = nv.gate(sample, ["newly_missed == 0", "encounters == 38"])
    assert not outcome
    assert [of_rule.rule.name for of_rule in outcome.failed] == ["newly_missed"]
    assert [of_rule.rule.name for of_rule in outcome.passed] == ["encounters", "audit_errors"]
    assert "FAILED  newly_missed == 0  (newly_missed is 8)" in str(outcome)
    hint = "no rule is about false alarms"
    assert hint in str(outcome)
    assert hint not in str(nv.gate(sample, ["newly_missed == 0", "precision_y >= 0.5"]))
    assert hint not in str(nv.gate(sample, ["encounters == 38"]))
    with pytest.raises(nv.NvcoreError, match="there is no measure 'new_mises'"):
        nv.gate(sample, ["new_mises == 0"])
    same = nv.compare(**{**paths(folder), "y": folder / "fir.csv"}, **SIZE, name_y="again")
    assert Severity.WARNING in {finding.severity for finding in same.findings}
    assert nv.gate(same, [])
    assert not nv.gate(same, [], strict=True)


def test_a_conversion_writes_what_the_command_line_writes(folder: Path, tmp_path: Path):
    done = nv.convert(folder / "truth.csv", tmp_path / "a.json", "coco", size=(640, 480))
    nvcore("convert", folder / "truth.csv", tmp_path / "b.json", "--to", "coco", *FACTS[:2])
    assert done.files == (tmp_path / "a.json",)
    assert (tmp_path / "a.json").read_bytes() == (tmp_path / "b.json").read_bytes()
    assert nv.convert(folder / "truth.csv", tmp_path / "c.json", "coco").warnings  # no size
    with pytest.raises(nv.NvcoreError, match="this has scores"):
        nv.convert(folder / "fir.csv", tmp_path / "a.csv", "csv")


def test_every_public_name_is_there():
    assert set(nv.__all__) <= set(dir(nv))
    for name in dir(nv):
        assert getattr(nv, name) is not None
    with pytest.raises(AttributeError, match="no attribute 'compaer'"):
        _ = nv.compaer


def test_every_parameter_of_a_call_with_arguments_is_described_and_no_flag():
    public = [*(getattr(nv, name) for name in dir(nv)), *vars(Comparison).values()]
    calls = [call for call in public if "__signature__" in getattr(call, "__dict__", ())]
    assert len(calls) == 15
    for call in calls:
        text = inspect.getdoc(call)
        for name in {*inspect.signature(call).parameters} - {"self"}:
            described = re.search(rf"^(\w+, )*{name}(, \w+)*\n    \S", text, re.MULTILINE)
            assert described, f"{call.__name__}: {name}"
        assert not re.search(r"(?<![\w-])--[a-z]", text), call.__name__
