"""Comparison of two runs: what it must notice, what the list of wordings and prose allow."""

from __future__ import annotations

import json
from pathlib import Path

import click
import pytest

from nvcore.cli import main
from scripts.comparisons import COMPARISONS, FILES
from scripts.differences import (
    Rewording,
    Wording,
    WordingError,
    compare_files,
    compare_folders,
    read_wordings,
)
from scripts.same_results import WORDINGS, Task, exit_codes, make_tasks, report

SHORTER = Wording("there is no such file", "no such file")
TABLE = b"figure,label,x\nlamr,log-average miss rate,0.6271\n"
PAGE = (
    '<p class="{}">It&#39;s low</p>'
    '<script type="application/json">{{"title":"It\'s low\\u003cbr\\u003e","y":0.5}}</script>'
)

RANGES = {
    "params": {
        "alpha": {"choices": None, "low": 0, "high": 1, "above_low": False},
        "spread": {"choices": None, "low": 0, "high": 10_000, "above_low": True},
        "threshold_x": {"choices": None, "low": -float("inf"), "high": float("inf"),
                        "above_low": False},
        "confirm_n": {"choices": None, "low": 1, "high": 100, "above_low": False, "is_whole": True},
        "match": {"choices": ["iou", "lateral"]},
    },
    "protocols": ["all", "near"],
}  # fmt: skip


FAULT = """\
Traceback (most recent call last):
  File "{}", line {}, in plan
    ^^^

    return json
TypeError: no text

Error: this is a fault
"""


def where(name: str, old: bytes, new: bytes, *wordings: Wording) -> str | None:
    return compare_files(name, old, new, Rewording(wordings))


def which_facts(name: str, old: str, new: str) -> str | None:
    return compare_files(name, old.encode(), new.encode(), None)


def write(folder: Path, **files: str) -> Path:
    for stem, text in files.items():
        path = folder / "report" / f"{stem}.csv"
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text)
    return folder


def test_a_changed_number_is_shown_with_its_line():
    difference = where("significance.csv", TABLE, TABLE.replace(b"0.6271", b"0.6272"))
    assert difference is not None
    assert difference.startswith("line 2\n")
    assert "0.6271" in difference
    assert "0.6272" in difference


def test_the_first_lines_that_differ_are_shown_and_the_others_are_counted():
    old = "".join(f"miss {i}\n" for i in range(6))
    difference = where("a.txt", old.encode(), old.replace("miss", "alarm").encode())
    assert difference is not None
    assert [line for line in ("line 1", "line 3", "line 4") if line in difference] == [
        "line 1", "line 3",
    ]  # fmt: skip
    assert difference.endswith("and 3 more lines")


@pytest.mark.parametrize(
    ("name", "old", "new"),
    [
        ("7-train.stderr.txt", "trained in 5.8 s\n", "trained in 1 min 20 s\n"),
        ("7-train.stderr.txt", "12% done: background, about 8 s left\nwritten\n", "written\n"),
        ("5-detect.stderr.txt", "about 1 s (0.077 s a picture)", "about 2 s (9.6e-06 s a picture)"),
        ("5-detect.stdout.txt", "in 1.4 s (7.4 pictures a second)", "in 2 s (5 pictures a second)"),
        ("3-plan.stderr.txt", FAULT.format("/old/a.py", 1), FAULT.format("/new/b.py", 20)),
        ("3-compare.stdout.txt", "chosen on 2026-11-29 at 20:37", "chosen on 2026-11-30 at 08:00"),
        ("summary.json", '{"version": "0.1.0"}', '{"version": "0.2.0"}'),
        ("detect/provenance.json", "nvcore 0.1.0", "nvcore 1.10.0rc1"),
        ("report/SHA256SUMS", f"{'0a' * 32}  a.csv\n", f"{'1b' * 32}  a.csv\n"),
    ],
)
@pytest.mark.parametrize("rewording", [Rewording(), None], ids=["wordings", "facts"])
def test_times_of_the_run_and_versions_are_masked(
    name: str, old: str, new: str, rewording: Rewording | None
):
    assert compare_files(name, old.encode(), new.encode(), rewording) is None


@pytest.mark.parametrize(
    ("name", "old", "new"),
    [
        ("3-compare.stdout.txt", "3 against 5 in 150 s)", "3 against 5 in 151 s)"),
        ("7-train.stderr.txt", "trained in 5.8 s", "learned in 5.8 s"),
        ("3-plan.stderr.txt", FAULT, FAULT.replace("TypeError", "ValueError")),
        ("frames.csv", "in 5.8 s", "in 5.9 s"),
        ("report/SHA256SUMS", f"{'0a' * 32}  a.csv", f"{'0a' * 32}  b.csv"),
    ],
)
def test_numbers_of_results_and_sentences_are_not_masked(name: str, old: str, new: str):
    assert where(name, old.encode(), new.encode()) is not None


def test_a_file_that_is_written_by_one_program_only_is_a_difference(tmp_path: Path):
    old = write(tmp_path / "old", frames="a\n", events="b\n")
    new = write(tmp_path / "new", frames="a\n", encounters="c\n")
    assert dict(compare_folders(old, new, Rewording())) == {
        "report/encounters.csv": "only the newer program writes it",
        "report/events.csv": "only the older program writes it",
    }


def test_a_wording_that_is_not_listed_is_a_difference_and_a_listed_one_hides_no_other():
    old, new = b"a.csv: there is no such file\n", b"a.csv: no such file\n"
    assert where("check.txt", old, new) is not None
    assert where("check.txt", old, new, SHORTER) is None
    assert where("check.txt", old, new.replace(b"a.csv", b"b.csv"), SHORTER) is not None


def test_a_longer_wording_is_applied_once_and_it_is_known_that_it_was_needed():
    longer = Wording("miss", "a miss")
    rewording = Rewording((longer, Wording("unused", "unneeded")))
    assert compare_files("check.txt", b"no miss\n", b"no a miss\n", rewording) is None
    assert rewording.needed == {longer}


@pytest.mark.parametrize(
    ("old", "new", "wording"),
    [
        (b"figure,label,x\nmiss,b,1\n", b"figure,label,x\nalarm,b,1\n", ("miss", "alarm")),
        (b"figure,miss,x\na,b,1\n", b"figure,alarm,x\na,b,1\n", ("miss", "alarm")),
        (b'figure,label\na,"b"\n', b"figure,label\na,b\n", ("miss", "alarm")),
        (b"figure,label\na,b\n", b"figure,label\r\na,b\r\n", ("miss", "alarm")),
        (b"x\ninf\n", b"x\nnone\n", ("inf", "none")),
    ],
    ids=["column figure", "header", "quoting", "line ends", "number"],
)
def test_csv_stays_to_the_byte_in(old: bytes, new: bytes, wording: tuple[str, str]):
    assert where("a.csv", old, new, Wording(*wording)) is not None


def test_cells_of_csv_may_be_reworded():
    new = TABLE.replace(b"log-average miss rate", b'"miss rate, log-average"')
    wording = Wording("log-average miss rate", "miss rate, log-average")
    assert where("a.csv", TABLE, new, wording) is None


def test_keys_of_json_stay_and_its_strings_may_be_reworded():
    old = json.dumps({"miss": "a miss", "n": 1.50}, indent=2).encode()
    wording = Wording("miss", '"alarm"')
    assert where("a.json", old, old.replace(b"a miss", b'a \\"alarm\\"'), wording) is None
    assert where("a.json", old, old.replace(b'"miss"', b'"alarm"'), Wording("miss", "alarm"))
    assert where("a.json", old, old.replace(b"1.5", b"1.50"), wording) is not None


def test_html_is_reworded_in_its_text_and_in_the_json_of_its_figures():
    old = PAGE.format("low").encode()
    new = old.replace(b"It&#39;s low", b"It&#39;s &lt; X&#39;s").replace(
        b"It's low", b"It's \\u003c X's"
    )
    assert where("a.html", old, new, Wording("It's low", "It's < X's")) is None
    assert (
        where("a.html", old, PAGE.format("high").encode(), Wording("It's low", "It's")) is not None
    )


def test_pictures_are_compared_to_the_byte():
    assert where("a.png", b"\xff\x00\x01", b"\xff\x00\x02") == "byte 2 (3 and 3 bytes)"


@pytest.mark.parametrize(("old", "new"), [("0.5 of all", "0.6 of all"), ("0.5", "0.5"), ("", "x")])
def test_a_wording_cannot_change_a_number(old: str, new: str):
    with pytest.raises(WordingError, match="a wording"):
        Wording(old, new)


def test_an_entry_of_other_keys_is_an_error(tmp_path: Path):
    path = tmp_path / "wordings.toml"
    path.write_text('[[wording]]\nold = "miss"\n')
    with pytest.raises(WordingError, match="the keys old and new"):
        read_wordings(path)
    assert isinstance(read_wordings(WORDINGS), tuple)


def test_the_same_seed_gives_the_same_settings():
    def flags(seed: int) -> list[tuple[str, ...]]:
        tasks = make_tasks(RANGES, COMPARISONS, Path("sample"), count=3, seed=seed)
        return [task.flags for task in tasks if task.setting.startswith("random")]

    assert flags(1) == flags(1)
    assert flags(1) != flags(2)
    assert len(set(flags(1))) > 1


def test_random_settings_are_in_their_ranges():
    tasks = make_tasks(RANGES, COMPARISONS, Path("sample"), count=60, seed=7)
    given: dict[str, set[str]] = {}
    for flag in [flag for task in tasks for flag in task.flags if "=" in flag]:
        name, _, value = flag.partition("=")
        given.setdefault(name, set()).add(value)
    assert given["--match"] == {"iou", "lateral"}
    assert given["--protocol"] == {"all", "near"}
    assert {"0", "1"} < given["--alpha"]
    assert all(0 <= float(value) <= 1 for value in given["--alpha"])
    assert all(0 < float(value) <= 10_000 for value in given["--spread"])
    assert {"1", "3", "100"} < given["--confirm-n"] <= {str(n) for n in range(1, 101)}
    assert "100" in given["--confirm-m"]  # never fewer than confirm
    assert all(-0.9 <= float(value) <= 8.6 for value in given["--threshold-x"])


def names_of(group: click.Command, name: str = "") -> set[str]:
    """All commands of the program, such as ``driver train``."""
    if not isinstance(group, click.Group):
        return {name.strip()}
    return set().union(*(names_of(known, f"{name} {key}") for key, known in group.commands.items()))


def test_every_command_is_run_and_but_for_the_server_is_meant_to_succeed():
    tasks = make_tasks(RANGES, COMPARISONS, Path("sample"), count=1, seed=1)
    run = {command for task in tasks for command in task.commands if command[0] != "!"}
    names = {" ".join(command[:n]) for command in run for n in (1, 2)}
    assert names_of(main) - names == {"app"}


def test_commands_name_files_that_are_there_and_no_placeholder_is_left():
    tasks = make_tasks(RANGES, COMPARISONS, Path("sample"), count=1, seed=1)
    words = {word for task in tasks for command in task.commands for word in command}
    assert not [word for word in words if "{" in word]
    assert {*FILES} - {"alerts.csv", "gaze.csv", "speed.csv"} <= words


def test_a_command_that_ends_otherwise_than_meant_is_named(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
):
    commands = (("check", "a"), ("!", "check", "b"), ("plan", "c d"), ("!", "models"))
    task = Task(COMPARISONS[0], "default", (), commands)
    for side in ("old", "new"):
        (tmp_path / side / "printed").mkdir(parents=True)
        for number, code in enumerate((1, 2, 2, 0), start=1):
            (tmp_path / side / "printed" / f"{number:02}-x.exit.txt").write_text(f"{code}\n")
    old, new = tmp_path / "old", tmp_path / "new"
    assert exit_codes(task, new) == [("1", True), ("2", True), ("2", False), ("0", False)]
    is_same, named = report(task, old, new, 1.0, Rewording())
    assert is_same
    assert named == [
        "exit code 2: sample default: plan 'c d'",
        "exit code 0: sample default: '!' models",
    ]
    assert "1x0 1x1 2x2" in capsys.readouterr().out


FACTS = {
    "significance.csv": 'figure,note,x,better\nlamr,"too few, they say",0.5,\nap,,1,higher\n',
    "summary.json": '{"x": {"name": "FIR", "lamr": 0.5}, "label": "miss rate", "notes": ["a b"]}',
    "session.toml": '[[system]]\nname = "FIR"\nthreshold = 0.5\n',
    "gate.xml": '<testsuites><testsuite tests="1" failures="1"><testcase name="lamr_y &lt;= 0.1">'
    '<failure message="lamr_y is 0.5">lamr_y is 0.5</failure></testcase></testsuite></testsuites>',
    "gate.md": "## Gate: 1 of 2 rules failed\n\n| `lamr_y <= 0.1` | 0.5 | **failed** |\n",
    "compare.txt": "In short: 3 are missed.\n         X: FIR   Y: NIR\nmiss rate   0.5   -0.6\n",
    "compare.exit.txt": "1\n",
    "SHA256SUMS": "48de5  frames.csv\n",
    "report.html": '<h2>Misses</h2><section id="misses"><p>In 3 frames</p>'
    '<span class="y better"><i>Y</i>0.5</span><span style="width:5.5%"></span>'
    "<table><tr><td>set06/V000</td><td>of 38 encounters</td><td>\u22126.4 pp</td>"
    "<td>From 10 recordings, a bootstrap of them all</td></tr></table>"
    '<figure id="chart-misses"><img src="data:picture"><script type="application/json">'
    '{"data": [{"y": [0.5], "name": "X misses"}], "layout": {"title": "Misses"}}'
    "</script></figure></section>",
}


@pytest.mark.parametrize(
    ("name", "old", "new"),
    [
        ("significance.csv", "0.5", "0.51"),
        ("significance.csv", "lamr", "miss_rate"),
        ("significance.csv", "higher", "lower"),
        ("significance.csv", '"too few, they say"', ""),
        ("significance.csv", "better", "best"),
        ("significance.csv", "ap,,1,higher\n", ""),
        ("significance.csv", "ap,,1,higher\n", "ap,,1,higher\nap,,1,higher\n"),
        ("summary.json", "0.5", "0.51"),
        ("summary.json", '"lamr"', '"miss_rate"'),
        ("summary.json", "FIR", "NIR"),
        ("summary.json", ', "label": "miss rate"', ""),
        ("session.toml", "FIR", "NIR"),
        ("session.toml", "threshold", "score"),
        ("session.toml", "0.5", "0.6"),
        ("gate.xml", "&lt;=", "&lt;"),
        ("gate.xml", "0.5", "0.6"),
        ("gate.xml", 'failures="1"', 'failures="0"'),
        ("gate.xml", '<failure message="lamr_y is 0.5">lamr_y is 0.5</failure>', "lamr_y is 0.5"),
        ("gate.md", "0.5", "0.6"),
        ("gate.md", "lamr_y", "lamr_x"),
        ("compare.txt", "-0.6", "0.6"),
        ("compare.txt", "miss rate   0.5   -0.6\n", ""),
        ("compare.exit.txt", "1", "0"),
        ("SHA256SUMS", "frames", "events"),
        ("report.html", 'id="misses"', 'id="missed"'),
        ("report.html", "</i>0.5", "</i>0.6"),
        ("report.html", "y better", "y"),
        ("report.html", "5.5%", "6%"),
        ("report.html", "set06/V000", "set06/V001"),
        ("report.html", "38", "39"),
        ("report.html", "\u22126.4", "6.4"),
        ("report.html", "<td>set06/V000</td>", ""),
        ("report.html", "data:picture", "data:another"),
        ("report.html", "[0.5]", "[0.51]"),
        ("report.html", '"y"', '"x"'),
    ],
)
def test_a_number_name_key_column_row_or_outcome_is_a_fact(name: str, old: str, new: str):
    assert which_facts(name, FACTS[name], FACTS[name].replace(old, new)) is not None


@pytest.mark.parametrize(
    ("name", "old", "new"),
    [
        ("significance.csv", "too few, they say", "3 are too few"),
        ("summary.json", "miss rate", "rate of misses"),
        ("summary.json", '["a b"]', '["a", "b"]'),
        ("session.toml", "name", "# of the system\nname"),
        ("gate.xml", "lamr_y is 0.5<", "0.5 is what lamr_y is<"),
        ("gate.md", "1 of 2 rules failed", "one failed"),
        ("gate.md", "**failed**", "failed"),
        ("compare.txt", "In short: 3 are missed.", "Three are missed."),
        ("compare.txt", "miss rate   ", "rate of misses      "),
        ("SHA256SUMS", "48de5", "49de5"),
        ("report.html", "<h2>Misses</h2>", "<h2>Who is missed</h2>"),
        ("report.html", "In 3 frames", "Three"),
        ("report.html", "of 38 encounters", "encounters (38)"),
        ("report.html", "\u22126.4 pp", "-6.4 points"),
        ("report.html", "From 10 recordings, a bootstrap of them all", "Bootstrap"),
        ("report.html", "X misses", "missed by X"),
        ("report.html", '"Misses"', '"Missed"'),
    ],
)
def test_prose_is_no_fact(name: str, old: str, new: str):
    changed = FACTS[name].replace(old, new)
    assert changed != FACTS[name]
    assert which_facts(name, FACTS[name], changed) is None


def test_columns_may_stand_in_another_order_and_a_cell_that_differs_is_shown_by_its_place():
    assert which_facts("a.csv", "track,x\n1,0.5\n", "x,track\n0.5,1\n") is None
    assert which_facts("a.csv", "track,x\n1,0.5\n", "x,track\n0.6,1\n") == (
        "1 of 4 facts\n  - row 1, x: 0.5\n  + row 1, x: 0.6"
    )


def test_facts_of_folders_are_compared_with_their_file_names(tmp_path: Path):
    old = write(tmp_path / "old", frames="x,note\n1,few\n", events="y\n2\n")
    same = write(tmp_path / "same", frames="x,note\n1,too few\n", events="y\n2\n")
    other = write(tmp_path / "other", frames="x,note\n1,few\n", encounters="y\n2\n")
    assert not dict(compare_folders(old, same, None))
    assert set(dict(compare_folders(old, other, None))) == {
        "report/events.csv", "report/encounters.csv",
    }  # fmt: skip
