"""The worst rows of results, and the filters that choose them."""

from __future__ import annotations

import operator
from pathlib import Path
from typing import Any

import pyarrow as pa
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from nvcore.common.errors import InputError
from nvcore.subjects.fleet.folder import SUMMARY, write_batch
from nvcore.subjects.fleet.leases import seal
from nvcore.subjects.fleet.location import Location
from nvcore.subjects.fleet.plan import Batch, Plan
from nvcore.subjects.fleet.query import LONGEST_FILTER, worst
from nvcore.subjects.fleet.results import ScanParams

ENCOUNTERS = pa.table(
    {
        "recording": ["a", "a", "b", "c", "c"],
        "track": pa.array([1, 2, 1, None, 7], pa.int64()),
        "first_frame": [0, 5, 7, 9, 20],
        "shown_frame": [2, 5, 8, 9, 21],
        "shown_s": [0.2, 0.5, 0.1, 0.0, 1.2],
        "n_frames": [3, 20, 30, 40, 50],
        "severity_s_x": [1.0, None, 2.0, 0.5, None],
        "severity_s_y": [0.0, 3.0, None, 0.1, None],
        "coverage_x": [1.0, 0.5, 0.2, None, 0.9],
        "detected_x": [True, True, False, None, False],
        "category": ["both", "x_only", "neither", "it's", None],
    }
)
RECORDINGS = pa.table(
    {
        "recording": ["a", "b", "c"],
        "fps": [10.0, 10.0, 20.0],
        "n_frames": [100, 200, 300],
        "unit": ["u1", "", "u2"],
        "tags": [["night", "road=rural"], ["road=it's", "rain"], ["speed=60", "speedy=x"]],
    }
)
INTERVALS = pa.table(
    {
        "recording": ["a", "c"],
        "system": ["x", "y"],
        "first_frame": [10, 20],
        "last_frame": [15, 40],
        "start_s": [1.0, 2.0],
        "depth_s": [0.1, 0.7],
        "worst_frame": [12, 30],
    }
)


@pytest.fixture(scope="session")
def results(tmp_path_factory: pytest.TempPathFactory) -> Location:
    # a folder whose name DuckDB would take for a pattern, and SQL for the end of a text
    folder = tmp_path_factory.mktemp("results") / "it's *"
    tables = {"encounters": ENCOUNTERS, "recordings": RECORDINGS, "intervals": INTERVALS}
    place, scan = Location(str(folder)), ScanParams("x", "y")
    plan = Plan("store", {}, scan, {}, (Batch("batch", ("a", "b", "c"), 600),), {})
    done = write_batch(place, "batch", tables)
    shown = seal({"plan": plan.key})
    for path, content in (
        ("done/batch.json", done), (f"plans/{plan.key}.json", plan.to_json()), (SUMMARY, shown),
    ):  # fmt: skip
        place.write(path, content)
    return place


def chosen(results: Location, where: str) -> list[int]:
    """Rows of the encounters that fit, by their first frames."""
    table = worst(results, by="first_frame", where=where, is_reversed=True).table
    return [*table["first_frame"]]


@pytest.mark.parametrize(
    ("where", "frames"),
    [
        ("tag.road = 'rural' and n_frames > 10", [5]),
        ("tag.road='it''s'", [7]),
        ("tag.night", [0, 5]),
        ("not tag.night", [7, 9, 20]),
        ("tag.night = true or tag.rain is true", [0, 5, 7]),
        ("tag.speed > 50 and tag.speed < 100", [9, 20]),
        ("tag.road > 1", []),
        ("tag.road is null", [9, 20]),
        ("tag.road in ('rural', 'urban')", [0, 5]),
        ("tag.road like 'r%'", [0, 5]),
        ("recording.n_frames between 100 and 200 and n_frames between 20 and 40", [5, 7]),
        ("unit = 'u2'", [9, 20]),
        ("category = 'it''s'", [9]),
        ("category not like '%\\_only'", [0, 7, 9]),
        ("category ilike 'X%'", [5]),
        ("detected_x", [0, 5]),
        ("not detected_x", [7, 20]),
        ("detected_x is null or (detected_x) is (true)", [0, 5, 9]),
        ("n_frames in (3, 20.0, 1e400) and -0.5 < 0.1", [0, 5]),
        ("detected_x is not true", [7, 9, 20]),
        ("category is not null and coverage_x is not null", [0, 5, 7]),
        ("n_frames <> 3 -- a comment\n and n_frames not in (20, 30)", [9, 20]),
    ],
)
def test_a_filter_chooses_rows_by_their_columns_tags_and_recordings(results, where, frames):
    assert chosen(results, where) == frames


@pytest.mark.parametrize(
    ("where", "message"),
    [
        ("category = 'x'; drop table encounters", "cannot be read at character"),
        ("n_frames >", "cannot be read at character 10: a column or value is missing$"),
        ("1 = 1; select 2 = 2", "filter: "),
        ("category = (select 'x')", r"found \(SELECT 'x'\); expected conditions"),
        ("n_frames in (select 1)", "found n_frames IN"),
        ("read_text('/etc/passwd') = 'x'", "found READ_TEXT"),
        ("n_frames::text = 'x'", "found CAST"),
        ("-1.5e0 < -coverage_x", "expected a column, a number or a text, found -coverage_x"),
        ("tag.1 = 'a'", r"expected a column, a number or a text, found tag\.1"),
        ("tag.'road' = 'rural'", r"expected a column, a number or a text, found tag\.'road'"),
        ("recording.* = 1", r"expected a column, a number or a text, found recording\.\*"),
        ("1e = 1", "expected a column, a number or a text, found 1e"),
        ("n_frames + 1 > 2", r"found n_frames \+ 1"),
        ("n_frames in ()", r"expected a column, a number or a text, found n_frames IN \(\)"),
        ("category = $1", r"found \$1"),
        ("category like 'a!%' escape '!'", "found category LIKE"),
        ("n_frames", "expected a condition, found n_frames, which is a number"),
        ("n_frames = 'many'", "n_frames: expected a number, found 'many'"),
        ("detected_x = 1", "detected_x: expected true or false, found 1"),
        ("category = null", "found NULL"),
        ('category = "both"', "a text stands in single quotes"),
        ("nigt", r"there is no column nigt \(a tag is written tag.NAME\)"),
        ("n_frame > 3", "did you mean 'n_frames'"),
        ("tag.raod = 'rural'", "no recording has a tag raod; did you mean 'road'"),
        ("tags = 'night'", "name one of them, as in tag.night"),
        ("x.n_frames > 1", "before the dot there is tag or recording"),
        ("(" * 3000 + "tag.night" + ")" * 3000, "fewer conditions and brackets"),
        ("x" * (LONGEST_FILTER + 1), "expected at most 10,000 characters"),
        ("tag.night and\x1b[31m", r"\A[ -~]*\Z"),
    ],
)
def test_whatever_else_a_filter_says_is_refused_with_what_it_should_be(results, where, message):
    with pytest.raises(InputError, match=message):
        chosen(results, where)


COLUMNS = {"n_frames": 30, "first_frame": 7, "coverage_x": 0.5, "severity_s_x": 1}
OPERATIONS = {
    "=": operator.eq, "<>": operator.ne, "<": operator.lt,
    "<=": operator.le, ">": operator.gt, ">=": operator.ge,
}  # fmt: skip
Row = dict[str, Any]


def _compared(column: str, sign: str) -> tuple[str, Any]:
    def holds(row: Row) -> bool | None:
        return None if row[column] is None else OPERATIONS[sign](row[column], COLUMNS[column])

    return f"{column} {sign} {COLUMNS[column]}", holds


def _joined(word: str, left: tuple[str, Any], right: tuple[str, Any]) -> tuple[str, Any]:
    decides = word == "or"

    def holds(row: Row) -> bool | None:
        values = {left[1](row), right[1](row)}
        return decides if decides in values else None if None in values else not decides

    return f"({left[0]}) {word} ({right[0]})", holds


def _denied(of: tuple[str, Any]) -> tuple[str, Any]:
    def holds(row: Row) -> bool | None:
        return None if (value := of[1](row)) is None else not value

    return f"not ({of[0]})", holds


CONDITIONS = st.recursive(
    st.builds(_compared, st.sampled_from([*COLUMNS]), st.sampled_from([*OPERATIONS])),
    lambda of: st.builds(_joined, st.sampled_from(["and", "or"]), of, of) | st.builds(_denied, of),
    max_leaves=8,
)


@given(CONDITIONS)
@settings(max_examples=60, deadline=None)
def test_any_condition_holds_where_sql_says_that_it_does(results, condition):
    where, holds = condition
    rows = ENCOUNTERS.to_pylist()
    assert chosen(results, where) == [row["first_frame"] for row in rows if holds(row) is True]


def test_a_filter_may_be_a_long_chain_of_conditions(results):
    assert chosen(results, " or ".join(["detected_x"] * 700)) == [0, 5]


def test_the_worst_come_first_by_whatever_a_name_means(results):
    found = worst(results)
    assert found.by == ("severity_s_x", "severity_s_y")
    # a row of which neither system's severity is known is not the worst
    assert [*found.table["shown_frame"]] == [5, 8, 2, 9]
    assert [*found.table["time_s"]] == [0.5, 0.1, 0.2, 0.0]
    assert [*worst(results, by="severity_x", n=1).table["recording"]] == ["b"]
    # of coverage, little is bad
    assert [*worst(results, by="coverage_x").table["coverage_x"]] == [0.2, 0.5, 0.9, 1.0]
    best = worst(results, by="coverage_x", n=2, is_reversed=True).table
    assert [*best["recording"]] == ["a", "c"]
    with pytest.raises(InputError, match="did you mean 'severity'"):
        worst(results, by="severty")


def test_the_frame_to_look_at_has_its_time_whatever_frame_the_table_times(results):
    table = worst(results, "intervals", where="recording.fps > 1").table
    assert [*table["frame"]] == [30, 12]
    assert [*table["time_s"]] == [pytest.approx(2.5), pytest.approx(1.2)]
    assert "frame" not in worst(results, "recordings", by="n_frames").table


def test_results_that_are_not_there_are_said_to_be_missing(results, tmp_path: Path):
    with pytest.raises(InputError, match="there is no such table of results"):
        worst(Location(str(tmp_path)))
    with pytest.raises(InputError, match="did you mean 'encounters'"):
        worst(results, "encounter")
    assert str(worst(results, where="n_frames > 99")) == "no row fits"
    with pytest.raises(InputError, match="cannot be asked"):
        worst(results, where="recording like 'a\\'")
