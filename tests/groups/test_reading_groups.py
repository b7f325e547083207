"""Tables of groups: what is recognised, what is refused, and what is done before comparing."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from inputs import write

from nvcore.common.arguments.groups import GroupArguments
from nvcore.common.errors import InputError, NvcoreError, ParameterError
from nvcore.evidence.groups import compare_groups
from nvcore.evidence.groups.reading import MOST_ROWS, GroupTable, read_groups


def read(path: Path, *lines: str, **asked: object) -> GroupTable:
    return read_groups(GroupArguments(write(path / "table.csv", *lines), **asked))


def test_values_and_summaries_are_told_by_their_columns(tmp_path: Path):
    values = read(tmp_path, "condition,value", "a,1.5", "b,2", "a,3")
    assert [*values.rows] == ["participant", "condition", "value"]
    assert values.rows["value"].tolist() == [1.5, 2, 3]
    assert values.conditions == ["a", "b"]
    summaries = read(tmp_path, "condition;n;mean;sd", "a;3;1,5;0,2", "b;1;2;")
    assert summaries.rows["mean"].tolist() == [1.5, 2]
    assert np.isnan(summaries.rows["sd"]).tolist() == [False, True]
    assert len(read(tmp_path, "condition,n,mean,sd", "a,3,1,1", measure="mean").rows) == 1


@pytest.mark.parametrize(
    ("header", "field", "scale"),
    [
        ("duration_s", "4", "times"),
        ("rt_ms", "4", "times"),
        ("violations", "4", "counts"),
        ("value", "100", "numbers"),
        ("value", "4.5", "numbers"),
    ],
)
def test_what_the_numbers_are_follows_from_name_and_values(
    tmp_path: Path, header: str, field: str, scale: str
):
    table = read(tmp_path, f"condition,{header}", f"a,{field}", "b,")
    assert (table.measure, table.scale) == (header, scale)
    assert read(tmp_path, f"condition,{header}", f"a,{field}", scale="numbers").scale == "numbers"


def test_the_measure_is_value_or_the_first_column_of_numbers(tmp_path: Path):
    lines = ("participant,condition,trial,note,duration_s,violations", "P,a,1,x,4,2")
    assert read(tmp_path, *lines).measure == "duration_s"
    assert read(tmp_path, *lines, measure="violations").measure == "violations"
    assert read(tmp_path, "condition,speed,value", "a,1,2").measure == "value"


def test_a_table_in_memory_does_as_well_and_errors_name_its_row():
    table = pd.DataFrame({"condition": ["a", "b"], "value": [1.5, np.nan]})
    assert len(read_groups(GroupArguments(table)).rows) == 1
    wrong = table.astype(object).replace({1.5: "soon"})
    with pytest.raises(InputError, match="table, row 0: value: expected a number, found 'soon'"):
        read_groups(GroupArguments(wrong, "value"))
    with pytest.raises(InputError, match="table: a table of groups has the columns condition"):
        read_groups(GroupArguments(table.drop(columns="condition")))


def test_participants_are_one_however_their_names_are_typed(tmp_path: Path):
    table = read(tmp_path, "participant,condition,value", "Anna K,a,1.5", "anna  k,b,2")
    assert table.rows["participant"].tolist() == ["Anna K", "Anna K"]


def test_drives_have_a_row_for_each_kind_of_violation(tmp_path: Path):
    lines = (
        "participant,condition,duration_s,violations,kind",
        "A,none,200,3,speeding",
        "A,none,200,2,lane departure",
        "B,none,210,0,",
        "C,audio,220,4,speeding",
    )
    assert read(tmp_path, *lines, measure="violations").rows["value"].tolist() == [5, 0, 4]
    of_kind = read(tmp_path, *lines, measure="violations", kind="lane departure")
    assert of_kind.rows["value"].tolist() == [2, 0, 0]
    times = read(tmp_path, *lines).rows.groupby("participant")["value"].mean()
    assert times.tolist() == [200, 210, 220]
    with pytest.raises(ParameterError, match="kind: no 'speding'; did you mean 'speeding'"):
        read(tmp_path, *lines, measure="violations", kind="speding")
    with pytest.raises(ParameterError, match="kind: expected counts, with a column kind"):
        read(tmp_path, *lines, kind="speeding")


def test_drives_are_numbered_where_one_person_has_several(tmp_path: Path):
    lines = ("participant,condition,run,violations,kind", "A,none,1,3,s", "A,none,2,2,s")
    assert read(tmp_path, *lines).rows["value"].tolist() == [3, 2]
    without = [",".join(line.split(",")[:2] + line.split(",")[3:]) for line in lines]
    with pytest.raises(InputError, match=r"table.csv, line 3: this drive has a row of this kind"):
        read(tmp_path, *without)
    nameless = ("condition,violations,kind", "none,3,s", "none,2,s")
    assert len(read(tmp_path, *nameless).rows) == 2


def test_a_count_that_is_missing_leaves_that_of_the_drive_unknown(tmp_path: Path):
    lines = ("participant,condition,violations,kind", "A,none,3,s", "A,none,,l", "B,none,1,s")
    assert read(tmp_path, *lines).rows["value"].tolist() == [1]


def test_conditions_get_other_names_or_are_left_out_as_are_participants(tmp_path: Path):
    lines = ("participant,condition,value", "A,a,1.5", "B,b,2", "C,c,3", "D,c,4")
    new = {"a": "ab", "b": "ab", "c": ""}
    assert read(tmp_path, *lines, rename=new).rows["condition"].tolist() == ["ab", "ab"]
    assert read(tmp_path, *lines, leave_out=["c"]).rows["participant"].tolist() == ["A", "B", "D"]
    for asked, words in (
        ({"rename": {"aa": "x"}}, "rename: no 'aa'; did you mean 'a'"),
        ({"leave_out": ["X"]}, "leave_out: no 'x'"),
        ({"measure": "volue"}, "measure: no 'volue'; did you mean 'value'"),
    ):
        with pytest.raises(ParameterError, match=words):
            read(tmp_path, *lines, **asked)


@pytest.mark.parametrize(
    ("lines", "words"),
    [
        (["value", "1"], r"table.csv, line 1: a table of groups has the columns condition"),
        (["condition,value"], "expected 1 to 10,000 rows below the header, found 0"),
        (["condition,value", "a,soon"], "line 1: no column has numbers to compare"),
        (["condition,value", "a,1", "b,soon"], "line 3: value: expected a number, found 'soon'"),
        (["condition,value", ",1"], "line 2: condition is empty"),
        (["participant,condition,value", ",a,1"], "line 2: participant is empty"),
        (["condition,rt_ms", "a,1", "a,0"], "line 3: rt_ms: expected a time above 0, found 0"),
        (["condition,n,mean,sd", "a,2,1,"], "line 2: sd is empty, which it is for n = 1 alone"),
        (["condition,n,mean,sd", "a,2,1,-1"], "line 2: sd: expected 0 to 1e\\+12, found -1"),
        (["condition,value", "a,1", "b,1e13"], r"line 3: value: expected -1e\+12 to 1e\+12"),
        (["condition,n,mean,sd", "a,0,1,1"], "line 2: n: expected 1"),
        (["condition,n,mean,sd", "a,2,1,1", "a,2,1,1"], "line 3: the condition a is there a sec"),
        (["condition,value", *(f"c{i},1" for i in range(11))], "10 conditions at most, found 11"),
    ],
)
def test_what_cannot_be_used_is_refused_with_file_and_line(
    tmp_path: Path, lines: list[str], words: str
):
    with pytest.raises(InputError, match=words):
        read(tmp_path, *lines)


def test_counts_that_are_none_are_refused_where_they_are_called_so(tmp_path: Path):
    for value in ("-1", "0.5"):
        with pytest.raises(InputError, match=rf"line 3: value: expected a count.*found {value}"):
            read(tmp_path, "condition,value", "a,1", f"a,{value}", scale="counts")


def test_what_is_about_values_is_refused_of_summaries(tmp_path: Path):
    lines = ("condition,n,mean,sd", "a,2,1,1")
    for asked in ({"scale": "times"}, {"kind": "s"}, {"rename": {"a": "b"}}, {"leave_out": ["A"]}):
        with pytest.raises(ParameterError, match="is about values, and these are means and SD"):
            read(tmp_path, *lines, **asked)


def test_a_file_that_is_not_there_or_too_long_is_refused(tmp_path: Path):
    with pytest.raises(NvcoreError, match="cannot be opened"):
        read_groups(GroupArguments(tmp_path / "none.csv"))
    with pytest.raises(InputError, match="rows below the header, found 10,001"):
        read(tmp_path, "condition,value", *["a,1"] * (MOST_ROWS + 1))


def test_a_column_without_a_name_has_values_too(tmp_path: Path):
    path = write(tmp_path / "table.csv", "condition,", "a,1.5", "b,2.5")
    assert compare_groups(GroupArguments(path)).groups["mean"].tolist() == [1.5, 2.5]
