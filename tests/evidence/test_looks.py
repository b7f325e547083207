"""Each setting tried is a chance to err: its verdict counts once, and corrects the others."""

from __future__ import annotations

from pathlib import Path

import pytest
from inputs import nvcore
from places import ROOT

from nvcore.common.errors import InputError
from nvcore.comparison.compare import compare
from nvcore.evidence.looks import add_look, correct_for_looks
from nvcore.evidence.table import judge_both
from nvcore.inputs.load import load
from nvcore.inputs.session.toml import read_session
from nvcore.report.plan import planned_verdict
from nvcore.settings.params import Params

SAMPLE = ROOT / "sample_data" / "session.toml"


def test_each_setting_counts_once(tmp_path: Path) -> None:
    dataset, path = load(read_session(SAMPLE)), tmp_path / "looks.jsonl"
    tried = [Params(), Params(iou=0.3), Params(), Params(threshold_x=0.6)]
    assert [add_look(path, compare(dataset, of)) for of in tried] == [1, 2, 2, 3]
    path.write_text(path.read_text() + "{}\n")
    with pytest.raises(InputError, match=r"looks\.jsonl, line 4"):
        add_look(path, compare(dataset))


def test_p_is_multiplied_for_both_operating_points() -> None:
    result = compare(load(read_session(SAMPLE)))
    evidence, companions = judge_both(result, has_intervals=False)
    corrected, _ = correct_for_looks(evidence, companions, 3)
    before, after = (of["p_corrected"].dropna().to_numpy() for of in (evidence, corrected))
    assert after == pytest.approx((3 * before).clip(max=1))
    assert (corrected["p"].dropna() == evidence["p"].dropna()).all()


def test_the_verdict_says_how_many_were_tried() -> None:
    result = compare(load(read_session(SAMPLE)))
    assert "tried" not in " ".join(planned_verdict(result, plan_command="plan").sentences)
    sentences = planned_verdict(result, plan_command="plan", looks=3).sentences
    assert any("3 settings were tried" in sentence for sentence in sentences)


def test_the_command_line_keeps_looks(tmp_path: Path) -> None:
    path = str(tmp_path / "looks.jsonl")
    first = nvcore("compare", SAMPLE, "--looks", path, "--full")
    second = nvcore("compare", SAMPLE, "--looks", path, "--full", "--iou", "0.3")
    again = nvcore("compare", SAMPLE, "--looks", path, "--full", "--iou", "0.3")
    assert "were tried" not in first.stdout
    assert "2 settings were tried" in second.stdout
    assert again.stdout == second.stdout
    report = tmp_path / "night.html"
    nvcore("report", SAMPLE, "--looks", path, "--no-stability", "--out", report)
    assert "2 settings were tried" in report.read_text(encoding="utf-8")
