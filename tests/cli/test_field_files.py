"""Files as other tools write them, by the command line: right values, or what is wrong."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from click.testing import CliRunner
from field_cases import CASES, Case

from nvcore.cli import main


@pytest.mark.parametrize("case", CASES.values(), ids=CASES.keys())
def test_files_give_the_right_values_or_say_what_is_wrong(case: Case, tmp_path: Path):
    run = CliRunner().invoke(main, ["compare", *case.write(tmp_path), "--json"])
    assert run.exit_code == case.exit_code, run.stderr
    for words in case.says:
        assert words in run.stderr
    if case.right is not None:
        summary = json.loads(run.stdout)
        keys = {
            "matched": "boxes_matched",
            "false_alarms": "false_alarms",
            "encounters": "encounters_detected",
        }
        counts = {
            name: tuple(summary[letter][key] for letter in "xy") for name, key in keys.items()
        }
        assert counts == case.right


def test_numbers_given_for_results_are_those_of_the_results(tmp_path: Path):
    flags = ("--classes-truth", "person", "--classes-x", "2", "--classes-y", "2", "--json")
    written = CASES["coco-ids-less-by-one"].write(tmp_path)
    run = CliRunner().invoke(main, ["compare", *written, *flags])
    assert run.exit_code == 0, run.stderr
    assert [json.loads(run.stdout)[letter]["boxes_matched"] for letter in "xy"] == [60, 102]
