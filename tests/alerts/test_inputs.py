"""Logs and policies as files, the command, and what of all this a comparison shows."""

from __future__ import annotations

import csv
import json
from pathlib import Path

import pandas as pd
import pytest
from approach import ALL, approach, only
from builders import Box, at
from inputs import nvcore as run
from inputs import write

import nvcore as nv
from nvcore.common.errors import InputError, ParameterError
from nvcore.inputs.session.toml import read_session, write_session
from nvcore.metrics.encounter_classes import classes_of
from nvcore.subjects.alerts.policy import named_policy
from nvcore.subjects.alerts.steps import AlertsView, alerts_in

HEAD = "frame,x,y,w,h,score,track"


def rows(boxes: list[Box]) -> list[str]:
    return [f"{box.frame},{box.x},{box.y},{box.w},{box.h},{box.score},{box.track}" for box in boxes]


@pytest.fixture
def night(tmp_path: Path) -> Path:
    """A session: an urgent pedestrian, whom X finds from frame 5 on; both have a false track."""
    boxes = approach(ALL, 5)
    false = [at(frame, 20, w=6.0, track=9, score=0.5) for frame in range(10, 20)]
    truth = [f"{box.frame},{box.x},{box.y},{box.w},{box.h},{box.track}" for box in boxes]
    write(tmp_path / "truth.csv", "frame,x,y,w,h,track", *truth)
    write(tmp_path / "x.csv", HEAD, *rows([*only(boxes, range(5, 40)), *false]))
    write(tmp_path / "y.csv", HEAD, *rows(false))
    return session(tmp_path)


def session(folder: Path, *of_x: str) -> Path:
    return write(
        folder / "night.toml",
        "[defaults]", 'size = "100x100"', "fps = 10", 'frames = "0:39"',
        "[truth]", 'path = "truth.csv"',
        "[[system]]", 'name = "X"', 'path = "x.csv"', *of_x,
        "[[system]]", 'name = "Y"', 'path = "y.csv"',
    )  # fmt: skip


def of_x(view: AlertsView) -> pd.DataFrame:
    own = view.table[view.table["system"] == "x"].reset_index(drop=True)
    return own.drop(columns="log_kind")


def test_a_log_written_from_a_policy_gives_its_alerts(night: Path):
    by_policy = of_x(nv.judge_alerts(night, policy="eager"))
    assert by_policy["kind"].tolist() == ["wanted", "false"]
    end_s = by_policy["start_s"] + by_policy["duration_s"] - 0.1  # begin of its last frame
    log = [
        f"{start},{end:.6f},pedestrian,{track}"
        for start, end, track in zip(by_policy["start_s"], end_s, by_policy["track"], strict=True)
    ]
    write(night.parent / "log.csv", "start_s,end_s,kind,track", *log)
    view = nv.judge_alerts(session(night.parent, 'alerts = "log.csv"'))
    pd.testing.assert_frame_equal(of_x(view), by_policy)
    assert view.table["log_kind"].tolist()[:2] == ["pedestrian"] * 2
    assert view.curve[view.curve["of"] == "log"]["system"].tolist() == ["x"]


def test_a_column_of_the_detections_is_a_log_as_well(night: Path):
    quick = {"alert_off_s": 0.0, "alert_least_s": 0.0, "alert_corridor": 1.0}
    by_policy = of_x(nv.judge_alerts(night, alerts="policy", **quick))
    with (night.parent / "x.csv").open() as file:
        lines = [*csv.reader(file)]
    spans = by_policy[["track", "start_frame", "end_frame"]].to_numpy().tolist()
    flags = [
        int(
            any(int(line[6]) == track and low <= int(line[0]) <= high for track, low, high in spans)
        )
        for line in lines[1:]
    ]
    alerted = [",".join([*line, str(flag)]) for line, flag in zip(lines[1:], flags, strict=True)]
    write(night.parent / "x.csv", f"{HEAD},alerted", *alerted)
    view = nv.judge_alerts(session(night.parent, 'alerts = "x.csv"'))
    pd.testing.assert_frame_equal(of_x(view), by_policy)


def test_a_log_without_tracks_is_about_whom_the_system_finds_meanwhile(night: Path):
    write(night.parent / "log.csv", "start_s;end_s;kind", "0;0,3;a", "1,04;1,2;b", "0,4;0,6;")
    table = of_x(nv.judge_alerts(session(night.parent, 'alerts = "log.csv"')))
    kinds = table[["start_frame", "end_frame", "kind"]].to_numpy().tolist()
    # before frame 5 X has no box; of two boxes in frame 11 that which matches counts
    assert kinds == [[0, 3, "false"], [4, 6, "wanted"], [11, 12, "wanted"]]
    assert table["lead_s"].tolist()[1] == pytest.approx(2.5)


@pytest.mark.parametrize(
    ("lines", "words"),
    [
        (["start_s,end_s", "0,1"], "kind is missing"),
        (["start_s,end_s,kind", "2,1,a"], "line 2.*end_s: expected start_s or more"),
        (["start_s,end_s,kind", "0,1,a", "9,10,a"], r"line 3.*9 s, but .* ends at 3.9 s"),
        (["start_s,end_s,kind", "0,1,a", "1,99,a"], r"line 3: end_s: 99 s, but .* ends at 4 s"),
        (["start_s,end_s,kind", "0,1e308,a"], "line 2: end_s: expected 0 to"),
        (["start_s,end_s,kind,recording", "0,1,a,there"], "line 2.*there is no 'there'"),
        (["start_s,end_s,kind,track", "0,1,a,", "1,2,a,9.5"], "line 3: track: .*whole number"),
        (["start_s,end_s,kind,track", "0,1,a,-1"], "line 2: track: expected 0 to"),
        (["start_s,end_s,kind,track", "0,1,a,1", "1,2,a,7"], "line 3: track: X has no track 7 in"),
        (["frame,x,y,w,h,alerted", "0,1,1,1,1,1"], "no file of the detections of X"),
    ],
)
def test_a_log_that_cannot_be_used_is_refused_with_its_line(night: Path, lines, words):
    write(night.parent / "log.csv", *lines)
    with pytest.raises(InputError, match=words):
        nv.judge_alerts(session(night.parent, 'alerts = "log.csv"'))


def test_rows_of_one_begin_and_end_are_one_alert_whatever_their_kinds(night: Path):
    rows = ("0,1,sign", "0,1,tone", "0,1,tone", "0,1.5,sign", "0.5,1,tone")
    write(night.parent / "log.csv", "start_s,end_s,kind", *rows)
    view = nv.judge_alerts(session(night.parent, 'alerts = "log.csv"'))
    own = view.table[view.table["system"] == "x"]
    assert own["end_frame"].tolist() == [10, 15, 10]
    assert own["log_kind"].tolist() == ["sign, tone", "sign", "tone"]
    # of two tracks, as a policy gives them, they are about two pedestrians
    write(night.parent / "log.csv", "start_s,end_s,kind,track", "1,1,a,1", "1,1,a,9", "1,1,b,1")
    own = of_x(nv.judge_alerts(session(night.parent, 'alerts = "log.csv"')))
    assert own[["track", "kind"]].to_numpy().tolist() == [[1, "wanted"], [9, "false"]]


def test_an_alert_may_last_to_the_end_of_the_last_frame(night: Path):
    write(night.parent / "log.csv", "start_s,end_s,kind", "3,4,a")
    own = of_x(nv.judge_alerts(session(night.parent, 'alerts = "log.csv"')))
    assert own["end_frame"].tolist() == [39]


@pytest.mark.parametrize("n_recordings", [1, 2])
def test_a_log_without_rows_is_a_system_without_alerts(night: Path, n_recordings: int):
    folder = night.parent
    of = [f"{name},{line}" for name in ("a", "b")[:n_recordings] for line in rows(approach(ALL, 5))]
    write(folder / "x.csv", f"recording,{HEAD}", *of)
    write(folder / "y.csv", f"recording,{HEAD}", *of)
    write(folder / "truth.csv", f"recording,{HEAD}", *of)
    write(folder / "log.csv", "start_s,end_s,kind")
    view = nv.judge_alerts(session(folder, 'alerts = "log.csv"'))
    assert of_x(view).empty
    assert len(view.table) == n_recordings  # of Y, by the policy
    assert view.is_logged(view.result.x)
    write(folder / "log.csv", "start_s,end_s,kind", "0,1,a")
    if n_recordings > 1:
        with pytest.raises(InputError, match=r"line 2.*expected a column recording"):
            nv.load(session(folder, 'alerts = "log.csv"'))


def flagged(lines: list[str], *flags: object) -> list[str]:
    return [f"{HEAD},alerted", *(f"{line},{flag}" for line, flag in zip(lines, flags, strict=True))]


def test_the_column_is_found_without_being_named_and_is_not_called_unused(night: Path):
    lines = rows(only(approach(ALL, 5), range(4, 10)))
    write(night.parent / "x.csv", *flagged(lines, 0, 1, 1, 0, 0, 0))
    dataset = nv.load(night)
    of_system = dataset.inputs[dataset.inputs["subject"] == "X"]["conversion"].item()
    assert "unused" not in of_system
    assert "column alerted: a log of alerts" in of_system
    view = nv.judge_alerts(night)
    assert of_x(view)[["start_frame", "end_frame"]].to_numpy().tolist() == [[5, 6]]
    assert "X gave 1 alert according to its own log" in run("alerts", night).output
    # a log that the session names goes before it
    write(night.parent / "log.csv", "start_s,end_s,kind")
    assert of_x(nv.judge_alerts(session(night.parent, 'alerts = "log.csv"'))).empty


def test_logs_are_named_by_flags_with_and_without_a_session(night: Path, monkeypatch):
    monkeypatch.chdir(night.parent)
    (night.parent / "elsewhere").mkdir()
    by_session = ["elsewhere/../night.toml"]
    by_flags = ["--truth", "truth.csv", "--x", "x.csv", "--y", "y.csv"]
    by_flags += ["--size", "100x100", "--fps", "10", "--frames", "0:39"]
    write(night.parent / "x.log", "start_s,end_s,kind", "0,1,a", "2,3,a")
    write(night.parent / "y.log", "start_s,end_s,kind")
    for inputs in (by_session, by_flags):
        result = run("alerts", *inputs, "--alerts-x", "x.log", "--alerts-y", "y.log")
        assert "X gave 2 alerts according to its own log" in result.output, result.output
        assert "Y gave no alert" in result.output.replace("gives", "gave")


def test_the_column_is_found_in_all_files_of_a_system_or_left_unused(night: Path):
    boxes, folder = rows(only(approach(ALL, 5), range(4, 8))), night.parent
    truth = [f"{name},{line}" for name in ("a", "b") for line in rows(approach(ALL, 5))]
    write(folder / "truth.csv", f"recording,{HEAD}", *truth)
    write(folder / "y.csv", f"recording,{HEAD}", *truth)
    (folder / "x").mkdir()
    write(folder / "x" / "a.csv", *flagged(boxes, 1, 1, 0, 0))
    write(folder / "x" / "b.csv", *flagged(boxes, 0, 0, 1, 1))
    write(night, night.read_text().replace('"x.csv"', '"x"'))
    own = of_x(nv.judge_alerts(night))
    assert own[["recording", "start_frame"]].to_numpy().tolist() == [["a", 4], ["b", 6]]
    write(folder / "x" / "b.csv", HEAD)  # without boxes
    assert of_x(nv.judge_alerts(night))["recording"].tolist() == ["a"]
    write(folder / "x" / "b.csv", HEAD, *boxes)
    assert "alerted-unused" in {finding.code for finding in nv.load(night).findings}


def test_a_column_that_is_no_log_is_left_unused_with_a_warning(night: Path):
    lines = rows(only(approach(ALL, 5), range(4, 6)))
    write(night.parent / "x.csv", *flagged(lines, 0, "loud"))
    (finding,) = [of for of in nv.load(night).findings if of.code == "alerted-unused"]
    assert finding.example == "line 3"
    assert not nv.judge_alerts(night).table["log_kind"].any()
    with pytest.raises(InputError, match=r"x\.csv, line 3"):
        nv.load(session(night.parent, 'alerts = "x.csv"'))


def test_a_column_with_a_longer_name_is_no_log(night: Path):
    lines = [f"{line},?" for line in rows(only(approach(ALL, 5), range(4, 6)))]
    for boxes in ([], lines):
        write(night.parent / "x.csv", f"{HEAD},alerted_by", *boxes)
        assert "alerted-unused" not in {finding.code for finding in nv.load(night).findings}


def test_a_policy_is_a_file_that_begins_from_a_named_one(night: Path):
    write(night.parent / "ours.toml", 'base = "eager"', "alert_on_s = 3.4")
    view = nv.judge_alerts(night, policy=night.parent / "ours.toml")
    params = view.result.params
    assert (params.alert_on_s, params.alert_k) == (3.4, named_policy("eager")["alert_k"])
    assert of_x(view)["start_frame"].tolist() == [39]
    own = nv.judge_alerts(session(night.parent, 'alert_policy = "ours.toml"'))
    assert of_x(own)["start_frame"].tolist() == [39]
    assert own.table["system"].tolist() == ["x", "y"]  # Y by the settings
    for line in ("alert_corner = 1", "alert_k = 2", 'alerts = "off"', 'base = "bold"', "= 1"):
        write(night.parent / "ours.toml", "# ours", "alert_on_s = 1", line)
        with pytest.raises(InputError, match=r"ours\.toml.*line 3"):
            nv.judge_alerts(night, policy=night.parent / "ours.toml")
    write(night.parent / "ours.toml", f"alert_k = {'9' * 400}")
    with pytest.raises(InputError, match=r"ours\.toml: .*an integer of more than 64 bits"):
        nv.judge_alerts(night, policy=night.parent / "ours.toml")
    with pytest.raises(ParameterError, match="cautious, balanced and eager"):
        nv.judge_alerts(night, policy="bold")


def test_named_policies_alert_the_more_the_bolder_they_are(night: Path):
    n = [len(nv.judge_alerts(night, policy=name).table) for name in ("cautious", "balanced")]
    assert named_policy("balanced")["alert_k"] == 0.5
    assert n[0] <= n[1] <= len(nv.judge_alerts(night, policy="eager").table)


def test_the_session_that_is_written_names_log_and_policy(night: Path):
    write(night.parent / "log.csv", "start_s,end_s,kind", "0,1,a")
    write(night.parent / "ours.toml", "alert_k = 0.1")
    given = session(night.parent, 'alerts = "log.csv"', 'alert_policy = "ours.toml"')
    text = write_session(read_session(given), version="0", fingerprint="0")
    again = read_session(write(night.parent / "again.toml", text))
    assert again.systems[0].alerts == (night.parent / "log.csv").as_posix()
    comparison = nv.compare(night.parent / "again.toml", alerts="log")
    comparison.write(night.parent / "out")
    write(night.parent / "log.csv", "start_s,end_s,kind", "0,2,a")
    changed = nv.load(night.parent / "out" / "session.toml")
    assert "input-changed" in {finding.code for finding in changed.findings}
    assert changed.fingerprint != comparison.dataset.fingerprint


def test_the_log_is_found_again_where_recordings_are_renamed_or_left_out(night: Path):
    name = night.parent.name  # of the recording, too
    write(night.parent / "log.csv", "start_s,end_s,kind,recording", f"0,1,a,{name}")
    given = session(night.parent, 'alerts = "log.csv"')
    dataset = nv.load(given, alerts="log")
    renamed = dataset.renamed({"X": "FIR"}, {name: "drive"})
    table = alerts_in(nv.compare(renamed).result).table
    assert table[table["system"] == "x"]["recording"].tolist() == ["drive"]


def test_the_command_prints_measures_and_curve_and_writes_both_tables(night: Path):
    out = night.parent / "out"
    result = run("alerts", night, "--policy", "eager", "--out", out)
    assert result.exit_code == 0, result.output
    assert "X gives 2 alerts (1 false, 1 wanted), in time for 1 of 1 urgent encounter" in (
        result.output
    )
    assert "unwanted alerts" in result.output
    assert "every box" in result.output
    written = pd.read_csv(out / "alerts.csv")
    assert written["kind"].tolist() == ["wanted", "false", "false"]
    assert {"policy", "in use"} == set(pd.read_csv(out / "alert_curve.csv")["of"])
    assert run("alerts", night, "--alerts", "off").exit_code == 2


def test_a_comparison_shows_alerts_only_if_it_is_asked_for_them(night: Path, tmp_path: Path):
    plain = run("compare", night, "--full", "--out", tmp_path / "plain").stdout
    policy = ["--alerts", "policy", "--full"]
    asked = run("compare", night, *policy, "--out", tmp_path / "asked").stdout
    assert "\nAlerts\n" in asked
    assert "\nAlerts\n" not in plain
    summaries = [
        json.loads((tmp_path / name / "summary.json").read_text()) for name in ("plain", "asked")
    ]
    new = set(summaries[1]["x"]) - set(summaries[0]["x"])
    assert {"alerts_unwanted_per_hour", "alerted_in_time", "median_alert_lead_s"} <= new
    assert "alerts" not in summaries[0]["parameters"]
    assert summaries[1]["parameters"]["alerts"] == "policy"
    heads = [list(pd.read_csv(tmp_path / name / "encounters.csv")) for name in ("plain", "asked")]
    assert set(heads[1]) - set(heads[0]) == {
        f"alert_{name}_{letter}" for name in ("frame", "lead_s") for letter in "xy"
    }
    rule = ("gate", night, "--rule", "alerted_in_time_x >= 1")
    assert run(*rule, "--alerts", "policy").exit_code == 0
    assert run(*rule).exit_code == 1  # undefined


def test_rules_of_a_gate_file_about_alerts_pass_and_fail_and_lack_what_nobody_knows(night: Path):
    # X: one false and one wanted alert in 4 s, in time for the only urgent one; Y: one false
    rules = ("alerts_unwanted_x <= 1", "alerted_in_time_x >= 1")
    held = write(night.parent / "held.txt", *rules, "alerts_needed_x >= 0 or undefined")
    gate = ("gate", night, "--alerts", "policy", "--alert-corridor", "1", "--rules")
    assert run(*gate, held).exit_code == 0, run(*gate, held).output
    lacking = ("alerts_redundant_x <= 9", "alerts_unwanted_per_hour_x <= 9999")
    for rule in ("alerts_unwanted_x <= 0", "alerted_in_time_y >= 1", *lacking):
        broken = write(night.parent / "broken.txt", "alerts_false_x <= 1", rule)
        result = run(*gate, broken)
        assert result.exit_code == 1, result.output
        assert rule in result.output


def test_speeds_codes_and_logs_count_seconds_from_the_first_evaluated_frame(night: Path):
    # frames 10 to 39, ten a second: 1 s is frame 20 in all three, as on the Timeline
    write(night.parent / "speed.csv", "time_s,speed_kmh", "0,50", "1,60", "2,70")
    write(night.parent / "log.csv", "start_s,end_s,kind", "1,1,a")
    name = night.parent.name
    of_recording = ["[[recording]]", f'name = "{name}"', 'speed = "speed.csv"']
    code = ["[[code]]", f'recording = "{name}"', "start_s = 1", "end_s = 1", 'code = "glare"']
    text = session(night.parent, 'alerts = "log.csv"').read_text().replace("0:39", "10:39")
    boxes = approach(ALL, 5)
    early, there, late = (boxes[:20], boxes[20:21], boxes[21:])
    tracks = [box._replace(track=n) for n, part in enumerate((early, there, late)) for box in part]
    rows_of = [f"{box.frame},{box.x},{box.y},{box.w},{box.h},{box.track}" for box in tracks]
    write(night.parent / "truth.csv", "frame,x,y,w,h,track", *rows_of)
    view = nv.judge_alerts(write(night, text, *of_recording, *code))
    frames = view.result.dataset.frame_columns
    assert frames.speed_kmh[frames.frame == 20].tolist() == pytest.approx([60])
    assert of_x(view)[["start_frame", "start_s"]].to_numpy().tolist() == [[20, 1.0]]
    classes = classes_of(view.result.dataset).members
    assert classes["glare"].tolist() == [False, True, False]
    assert classes["no_code"].tolist() == [True, False, True]


def test_alerts_of_sampled_frames_are_warned_of(night: Path):
    text = night.read_text()
    said = [run("alerts", write(night, text.replace("0:39", frames))).output
            for frames in ("0:39", "0:39:4")]  # fmt: skip
    words = "1 recording is not evaluated in every frame. alerts between the evaluated frames are"
    assert [words in output.lower() for output in said] == [False, True]


def test_the_report_has_a_section_and_the_figure_marks_what_is_in_use(night: Path, tmp_path: Path):
    comparison = nv.compare(night, alerts="policy")
    comparison.write_html(tmp_path / "night.html", stability=False)
    html = (tmp_path / "night.html").read_text()
    assert 'id="alerts"' in html
    assert "Alerts by what they were worth" in html
    names = [trace.name for trace in comparison.figures.alert_trade_off().data]
    assert names == ["X: X", "X: X, in use", "Y: Y", "Y: Y, in use"]


@pytest.mark.realdata
def test_on_kitti_the_kinds_part_the_alerts_and_a_log_of_them_is_the_same(
    realdata: Path, tmp_path: Path
):
    folder = realdata / "kitti_tracking"
    text = [
        "[defaults]", 'size = "1224x370"', "fps = 10",
        "[truth]", f'path = "{folder}/label_02/0016.txt"',
        "[[system]]", 'name = "X"', f'path = "{folder}/rrc_ped/0016.txt"',
        "[[system]]", 'name = "Y"', f'path = "{folder}/pointrcnn_ped/0016.txt"',
    ]  # fmt: skip
    view = nv.judge_alerts(write(tmp_path / "kitti.toml", *text), policy="eager")
    alerts = of_x(view)
    assert len(alerts) > 10
    assert {"wanted", "false"} <= set(alerts["kind"])
    assert (alerts["duration_s"] >= 0.5 - 1e-9).sum() >= len(alerts) - 3  # but at the end
    about = alerts["kind"].isin(["nuisance", "redundant", "needed", "wanted"])
    assert (alerts["encounter"].notna() == about).all()
    curve = view.curve[view.curve["of"] == "policy"]
    assert (curve[["in_time", "alerted"]].iloc[-1] <= curve[["in_time", "alerted"]].iloc[0]).all()
    end_s = alerts["start_s"] + alerts["duration_s"] - 0.1
    log = [
        f"{start:.6f},{end:.6f},,{track}"
        for start, end, track in zip(alerts["start_s"], end_s, alerts["track"], strict=True)
    ]
    write(tmp_path / "log.csv", "start_s,end_s,kind,track", *log)
    text.insert(text.index('name = "X"'), 'alerts = "log.csv"')
    logged = nv.judge_alerts(write(tmp_path / "logged.toml", *text))
    pd.testing.assert_frame_equal(of_x(logged), alerts)
