"""Whether alerts were worth it: the file of alerts, and kinds against answers."""

import numpy as np
import pandas as pd
import pytest
from places import SAMPLE

import nvcore as nv
from nvcore.common.errors import FormatError
from nvcore.subjects.alerts.calls.python import write_alerts
from nvcore.subjects.ratings.worth import agreement_of_kinds, read_alerts

HEAD = "recording,system,start_s,end_s,kind\n"


def answers(*groups, n_recordings=10):
    """Answers (kind, answer, how many), over the recordings in turn; each alert has one."""
    rows = [(kind, answer) for kind, answer, n in groups for _ in range(n)]
    table = pd.DataFrame(rows, columns=["kind", "answer"])
    number = np.arange(len(table))
    return table.assign(alert=number, recording=[f"r{i % n_recordings}" for i in number])


def test_share_and_kappa_are_those_counted_by_hand():
    # agreed 20 and 15 of 50; by chance 25 * 30 / 50 + 25 * 20 / 50 = 25: (35 - 25) / (50 - 25)
    table = agreement_of_kinds(answers(
        ("needed", "yes", 20), ("needed", "no", 5), ("false", "yes", 10), ("false", "no", 15),
        ("false", "unsure", 3),
    )).set_index("kind")  # fmt: skip
    assert table.index.tolist() == ["all", "false", "needed"]
    assert table["kappa"].tolist() == pytest.approx([0.4, 0.4, 0.4])
    assert table["share"].tolist() == pytest.approx([0.7, 0.6, 0.8])
    assert table["n_unsure"].tolist() == [3, 3, 0]
    assert table["n_answers"].tolist() == [50, 25, 25]
    assert table["n_alerts"].tolist() == [53, 28, 25]
    for of in ("share", "kappa"):
        assert (table[f"{of}_low"] < table[of]).all()
        assert (table[f"{of}_high"] > table[of]).all()


def test_a_kind_is_told_from_those_that_let_expect_the_other_answer():
    # nuisance: 4 of 5 answers no, of wanted 5 of 15; by chance (5 * 9 + 15 * 11) / 20 = 10.5
    groups = ("nuisance", "no", 4), ("nuisance", "yes", 1), ("wanted", "no", 5)
    groups = *groups, ("wanted", "yes", 10)
    table = agreement_of_kinds(answers(*groups)).set_index("kind")
    assert table.loc["nuisance", "kappa"] == pytest.approx((14 - 10.5) / (20 - 10.5))
    assert table.loc["nuisance", "share"] == pytest.approx(0.8)
    # a right no to alerts of another kind neither raises nor lowers it
    more = agreement_of_kinds(answers(*groups, ("false", "no", 30))).set_index("kind")
    assert more.loc["nuisance", ["kappa", "share"]].equals(
        table.loc["nuisance", ["kappa", "share"]]
    )
    assert more.loc["wanted", "kappa"] == more.loc["all", "kappa"] > table.loc["wanted", "kappa"]


def test_few_recordings_have_no_interval_and_one_kind_always_right_no_kappa():
    few = agreement_of_kinds(answers(("false", "no", 7), ("needed", "yes", 7), n_recordings=7))
    assert few["kappa"].tolist() == [1, 1, 1]
    assert few[["share_low", "kappa_high"]].isna().all(axis=None)
    alike = agreement_of_kinds(answers(("false", "no", 20)))
    assert alike["kappa"].isna().all()
    assert alike["share"].tolist() == [1, 1]


@pytest.fixture(scope="module")
def judged():
    """The alerts of the sample; its systems are FIR and NIR."""
    return nv.judge_alerts(SAMPLE, policy="eager")


def test_the_table_that_alerts_are_written_to_is_read_as_it_is(judged, tmp_path):
    write_alerts(tmp_path, judged)
    alerts = read_alerts((tmp_path / "alerts.csv").read_bytes(), judged.result, name="alerts.csv")
    assert alerts == read_alerts(judged.table, judged.result)
    asked = judged.table[judged.table["kind"] != "ignored"]
    assert len(alerts) == len(asked) < len(judged.table)
    read = pd.DataFrame(alerts)
    assert read["system"].tolist() == asked["system"].map({"x": "FIR", "y": "NIR"}).tolist()
    for column in ("recording", "start_s", "kind"):
        assert read[column].tolist() == asked[column].tolist()
    assert read["end_s"].to_numpy() == pytest.approx(asked["start_s"] + asked["duration_s"])
    assert read_alerts(read.assign(more=1), judged.result) == alerts  # by names, with its end


def test_alerts_that_come_together_are_one_of_the_kind_that_says_most_for_them(judged):
    line = "rural_road,{},1.5,3,{}"
    pairs = ("x", "needed"), ("x", "false"), ("NIR", "false"), ("NIR", "nuisance"), ("y", "ignored")
    text = HEAD + "\n".join(line.format(*pair) for pair in pairs)
    assert read_alerts(text.encode(), judged.result) == [
        ("rural_road", "FIR", 1.5, 3.0, "needed"), ("rural_road", "NIR", 1.5, 3.0, "nuisance"),
    ]  # fmt: skip


@pytest.mark.parametrize(
    ("line", "words"),
    [
        ("rural_road,FIR,3,1.5,false", "line 2: end_s: expected start_s or more"),
        ("rural_road,FIR,1,2,wrong", "line 2: kind: expected ignored, false, nuisance, .*'wrong'"),
        ("rural_road,FIR,soon,2,false", "line 2: start_s: expected a number"),
        ("rural_road,FIR,1,2,false\nrural_road,RGB,1,2,false", "line 3: system: .* FIR or NIR"),
        ("x,FIR,1,2,false", "line 2: recording: there is no 'x'"),
        ("rural_road,FIR,900,901,false", "line 2: start_s: 900 s, but rural_road ends at"),
        ("rural_road,FIR,1,99,false", "line 2: end_s: 99 s, but rural_road ends at"),
    ],
)
def test_alerts_that_cannot_be_are_refused_by_line(judged, line, words):
    with pytest.raises(FormatError, match=words):
        read_alerts(f"{HEAD}{line}\n".encode(), judged.result, name="alerts.csv")


def test_a_duration_beyond_all_recordings_is_refused(judged):
    line = "rural_road,x,1,{},false"
    for duration in ("1e308", "900"):
        text = HEAD.replace("end_s", "duration_s") + line.format(duration)
        with pytest.raises(FormatError, match="line 2: duration_s"):
            read_alerts(text.encode(), judged.result)


def test_a_table_of_alerts_without_an_end_is_refused(judged):
    with pytest.raises(FormatError, match="line 1: a table of alerts needs end_s or duration_s"):
        read_alerts(judged.table.drop(columns="duration_s"), judged.result)
    with pytest.raises(FormatError, match="kind is missing"):
        read_alerts(judged.table.drop(columns="kind"), judged.result)
