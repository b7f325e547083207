"""Each setting tried is a chance to err: its verdict counts once, and corrects the others."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from inputs import nvcore
from places import ROOT

from nvcore.common.errors import InputError
from nvcore.comparison.compare import compare
from nvcore.evidence.looks import Look, add_look, correct_for_looks, look_of
from nvcore.evidence.table import judge_both
from nvcore.inputs.load import load
from nvcore.inputs.session.toml import read_session
from nvcore.report.plan import planned_verdict
from nvcore.settings.params import Params
from nvcore.settings.primary import Primary
from nvcore.settings.protocols import PROTOCOLS

SAMPLE = ROOT / "sample_data" / "session.toml"


def test_each_setting_counts_once(tmp_path: Path) -> None:
    dataset, path = load(read_session(SAMPLE)), tmp_path / "looks.jsonl"
    tried = [Params(), Params(iou=0.3), Params(), Params(threshold_x=0.6)]
    looks = [add_look(path, compare(dataset, of)) for of in tried]
    assert looks == [Look(1, 2), Look(2, 6), Look(1, 2), Look(3, 12)]
    assert add_look(path, compare(dataset), PROTOCOLS["reasonable"]).number == 4
    path.write_text(path.read_text() + "{}\n")
    with pytest.raises(InputError, match=r"looks\.jsonl, line 5"):
        add_look(path, compare(dataset))


def test_p_is_multiplied_for_both_operating_points() -> None:
    result = compare(load(read_session(SAMPLE)))
    evidence, companions = judge_both(result, has_intervals=False)
    corrected, _ = correct_for_looks(evidence, companions, Look(2, 6))
    before, after = (of["p_corrected"].dropna().to_numpy() for of in (evidence, corrected))
    assert after == pytest.approx((6 * before).clip(max=1))
    assert (corrected["p"].dropna() == evidence["p"].dropna()).all()


def test_the_verdict_says_how_many_were_tried() -> None:
    result = compare(load(read_session(SAMPLE)))
    assert "tried" not in " ".join(planned_verdict(result, plan_command="plan").sentences)
    sentences = planned_verdict(result, plan_command="plan", look=Look(3, 12)).sentences
    assert any("setting 3 tried on these data" in sentence for sentence in sentences)


def test_the_command_line_keeps_looks(tmp_path: Path) -> None:
    path = str(tmp_path / "looks.jsonl")
    first = nvcore("compare", SAMPLE, "--looks", path, "--full")
    second = nvcore("compare", SAMPLE, "--looks", path, "--full", "--iou", "0.3")
    again = nvcore("compare", SAMPLE, "--looks", path, "--full", "--iou", "0.3")
    assert "setting 1 tried" in first.stdout
    assert "setting 2 tried" in second.stdout
    assert again.stdout == second.stdout
    report = tmp_path / "night.html"
    nvcore("report", SAMPLE, "--looks", path, "--no-stability", "--out", report)
    assert "setting 1 tried" in report.read_text(encoding="utf-8")


def test_all_looks_together_may_err_as_often_as_one() -> None:
    dataset = load(read_session(SAMPLE))
    spent = sum(1 / look_of(number, dataset).factor for number in range(1, 1000))
    assert 0.99 < spent <= 1
    fixed = Primary("mean_similarity")
    chosen = replace(dataset, settings=replace(dataset.settings, primary=fixed))
    assert [look_of(number, chosen).factor for number in (1, 2)] == [1, 6]


def test_numbers_of_the_files_follow(tmp_path: Path) -> None:
    path = str(tmp_path / "looks.jsonl")
    for name in ("json", "out"):
        flags = ["--json"] if name == "json" else ["--out", str(tmp_path / "out")]
        nvcore("compare", SAMPLE, "--looks", path, *flags)
    plain = nvcore("compare", SAMPLE, "--out", str(tmp_path / "plain"))
    assert plain.exit_code == 0
    assert len(Path(path).read_text().splitlines()) == 1
    ours, theirs = (
        pd.read_csv(tmp_path / name / "significance.csv")["p_corrected"]
        for name in ("out", "plain")
    )
    assert np.allclose(ours, (2 * theirs).clip(upper=1), equal_nan=True)


def test_a_file_of_looks_may_lack_its_last_line_end_but_not_be_something_else(
    tmp_path: Path,
) -> None:
    result, path = compare(load(read_session(SAMPLE))), tmp_path / "looks.jsonl"
    add_look(path, result)
    path.write_text(path.read_text().rstrip())
    params = replace(result.params, iou=0.3)
    assert add_look(path, compare(result.dataset, params)).number == 2
    assert add_look(path, result).number == 1
    path.write_bytes(b"\xff\n")
    with pytest.raises(InputError, match=r"looks\.jsonl, line 1"):
        add_look(path, result)
