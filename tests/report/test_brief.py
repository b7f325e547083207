"""The comparison on one screen; run this file to write the golden file anew."""

from __future__ import annotations

from pathlib import Path

import pytest
from builders import at, make_dataset, result_of
from inputs import drive, flags, nvcore, write
from places import ROOT, SAMPLE

from nvcore.report.brief import MOST_LINES, WIDTH, render_brief
from nvcore.report.decisive_moments import decisive_moments, main_moments

GOLDEN = ROOT / "tests" / "golden" / "compare.txt"
SIGNS = ROOT / "sample_data" / "speed_signs" / "session.toml"
LONG = "thermal camera of the second generation with the firmware of May " * 3
WORD = "B" * 150


def sample() -> str:
    return nvcore("compare", SAMPLE.relative_to(ROOT)).stdout


def faulty(folder: Path) -> list[str]:
    """Flags of two systems with long names, whose inputs have errors."""
    boxes = [f"{frame},{100 + frame},200,40,100" for frame in range(5)]
    write(folder / "truth.csv", "frame,x,y,w,h,track", *(f"{box},1" for box in boxes),
          "0,1,1,-40,100,1", "1,101,200,40,100,1", "3,5000,200,40,100,4")  # fmt: skip
    write(folder / "fir.csv", "frame,x,y,w,h", *boxes, "77,1,1,40,100")
    write(folder / "nir.csv", "frame,x,y,w,h", "77,1,1,40,100")
    return flags(folder, "--name-x", LONG, "--name-y", WORD)


def test_the_sample_in_short(monkeypatch: pytest.MonkeyPatch):
    monkeypatch.chdir(ROOT)
    assert sample() == GOLDEN.read_text(encoding="utf-8")


@pytest.mark.parametrize("scene", ["sample", "with alerts", "signs", "signs written", "faulty"])
def test_all_that_a_terminal_shows_fits_its_screen(tmp_path: Path, scene: str):
    given = {
        "sample": [SAMPLE],
        "with alerts": [SAMPLE, "--alerts", "policy"],
        "signs": [SIGNS],
        "signs written": [SIGNS, "--out", tmp_path / "out"],
        "faulty": faulty(tmp_path),
    }[scene]
    result = nvcore("compare", *given)
    assert len(result.output.splitlines()) <= MOST_LINES
    assert max(len(line) for line in result.stdout.splitlines()) <= WIDTH


def test_the_worst_error_comes_first_with_its_fix_and_others_follow(tmp_path: Path):
    result = nvcore("compare", *faulty(tmp_path))
    assert result.exit_code == 1
    first, worst, *_ = result.stdout.splitlines()
    assert first == "Audit: 4 errors, 3 warnings, 1 note."
    assert worst == "  error   truth: 1 row is left out: the width or height is 0 or less."
    assert "then correct or remove the rows." in result.stdout
    assert result.stdout.count("\n  error ") == 3
    assert "In short: Nothing is claimed: the audit found errors" in result.stdout


@pytest.mark.parametrize("is_written", [True, False])
def test_next_steps_name_a_session_file_that_says_all_that_was_given(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, is_written: bool
):
    monkeypatch.chdir(tmp_path)
    out = ["--out", "out"] if is_written else []
    steps = nvcore("compare", *flags(drive(tmp_path)), *out).stdout.split("Next:")[1]
    assert ("nvcore app out/session.toml " in steps) == is_written
    assert ("add --full" in steps) != is_written


def test_a_session_that_flags_change_is_not_what_the_next_steps_open():
    assert "nvcore app" in nvcore("compare", SIGNS).stdout.split("Next:")[1]
    changed = nvcore("compare", SIGNS, "--alpha", 0.7).stdout.split("Next:")[1]
    assert changed.startswith("\n  add --full ")


def test_what_does_not_fit_is_left_out_in_whole():
    truth = [at(f, c, track=t) for f in range(20) for t, c in ((1, 40), (2, 70))]
    result = result_of(make_dataset(truth, truth, truth[::2]))
    whole, less = (render_brief(result, most_lines=most).splitlines() for most in (99, 18))
    assert len(less) <= 18 < len(whole)
    assert {*less} < {*whole}
    assert any(line.startswith("In short: ") for line in less)
    assert "Moments to look at:" in whole


def test_a_moment_of_each_kind_comes_before_a_second_of_any():
    places = range(0, 200, 40)
    truth = [at(f + i, 50, track=i) for i in places for f in range(10)]
    x = [box for box in truth if box.track != 160]
    y = [box for box in truth if box.track == 160]
    result = result_of(make_dataset(truth, x, y, n_frames=200))
    titles = [moment.title for moment in decisive_moments(result)]
    assert titles[:2] == ["Only X detects"] * 2
    assert [moment.title for moment in main_moments(result)][:2] == [
        "Only X detects",
        "Only Y detects",
    ]


if __name__ == "__main__":
    import os

    os.chdir(ROOT)
    GOLDEN.write_text(sample(), encoding="utf-8")
