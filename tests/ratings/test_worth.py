"""Whether alerts were worth it: the file of alerts, and kinds against answers."""

import numpy as np
import pandas as pd
import pytest

from nvcore.errors import FormatError
from nvcore.ratings.worth import agreement_of_kinds, read_alerts

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


def test_a_kind_is_judged_among_all_others():
    # nuisance: 4 of 5 answers no, of the others 5 of 15; by chance (5 * 9 + 15 * 11) / 20 = 10.5
    table = agreement_of_kinds(answers(
        ("nuisance", "no", 4), ("nuisance", "yes", 1), ("wanted", "no", 5), ("wanted", "yes", 10),
    )).set_index("kind")  # fmt: skip
    assert table.loc["nuisance", "kappa"] == pytest.approx((14 - 10.5) / (20 - 10.5))
    assert table.loc["nuisance", "share"] == pytest.approx(0.8)


def test_few_recordings_have_no_interval_and_one_kind_always_right_no_kappa():
    few = agreement_of_kinds(answers(("false", "no", 7), ("needed", "yes", 7), n_recordings=7))
    assert few["kappa"].tolist() == [1, 1, 1]
    assert few[["share_low", "kappa_high"]].isna().all(axis=None)
    alike = agreement_of_kinds(answers(("false", "no", 20)))
    assert alike["kappa"].isna().all()
    assert alike["share"].tolist() == [1, 1]


def test_alerts_are_read_from_a_file_or_a_table():
    text = f"{HEAD}night,FIR,1.5,3,false\nnight,NIR,1.5,3,needed\n"
    alerts = read_alerts(text.encode(), name="alerts.csv")
    assert alerts[0] == ("night", "FIR", 1.5, 3.0, "false")
    table = pd.DataFrame(alerts).assign(more=1)
    assert read_alerts(table) == alerts


@pytest.mark.parametrize(
    ("line", "words"),
    [
        ("night,FIR,3,1.5,false", "line 2: the alert ends at 1.5 s, before 3 s"),
        ("night,FIR,1,2,wrong", "line 2: kind: expected false, nuisance"),
        ("night,FIR,soon,2,false", "line 2: start_s: expected a number"),
        ("night,FIR,1,2,false\nnight,FIR,1,2,needed", "line 3: this alert of FIR in night"),
    ],
)
def test_alerts_that_cannot_be_are_refused_by_line(line, words):
    with pytest.raises(FormatError, match=words):
        read_alerts(f"{HEAD}{line}\n".encode(), name="alerts.csv")
