"""``nvcore plan``: what is printed, as text and as JSON, and what is bad input."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from inputs import flags, nvcore
from places import SAMPLE

from nvcore.evidence.planning import PLAN_KEYS

FOUND = ("--measure", "encounters_detected")


def test_the_plan_says_how_many_recordings_and_the_power_of_other_sizes():
    ran = nvcore("plan", SAMPLE, "--measure", "log_average_miss_rate", "--difference", "10%")
    assert ran.exit_code == 0, ran.output
    assert ran.stdout.startswith("Audit: 1 note.")
    assert "would show a difference of 10.0 pp in 80 % of studies" in ran.stdout
    assert "difference as found (-5.3 pp)\n  recordings  encounters" in ran.stdout


def test_too_few_recordings_to_plan_from_have_no_number():
    ran = nvcore("plan", SAMPLE)
    assert ran.exit_code == 0, ran.output
    assert "can be given (too few recordings to plan from: " in ran.stdout
    assert "power" not in ran.stdout


def test_by_itself_it_plans_for_the_primary_measure():
    for more, key in (((), "severity_s_per_encounter"), (("--primary", "saliency"), "saliency")):
        ran = nvcore("plan", SAMPLE, *more, "--json")
        assert json.loads(ran.stdout)["measure"] == key


def test_compare_names_the_command_and_plans_only_on_request(folder: Path):
    by_itself, planned, short = (
        " ".join(nvcore("compare", *given, "--full").stdout.split())
        for given in ((SAMPLE,), (SAMPLE, "--plan"), flags(folder))
    )
    assert f"To plan more recordings: nvcore plan {SAMPLE}" in by_itself
    assert "To plan" not in planned
    assert "More recordings:" in planned
    assert "To plan" not in short  # two recordings are no pilot


def test_a_percentage_of_a_share_is_a_hundredth_and_json_stands_alone():
    ran = nvcore("plan", SAMPLE, *FOUND, "--margin", "30%", "--json")
    assert ran.exit_code == 0, ran.output
    plan = json.loads(ran.stdout)
    assert "Audit: " in ran.stderr
    answer = plan["noninferiority"]
    assert (answer["margin"], answer["candidate"], answer["is_shown"]) == (0.3, "y", True)
    equal, as_found = plan["sizes"]
    assert (equal["assumption"], as_found["assumption"]) == ("equal", "as found")
    assert equal["n_encounters"] == pytest.approx(3.8 * equal["n_recordings"], abs=1)
    assert plan["sentences"][1].startswith("Y is shown to be at most 30.0 pp worse")


@pytest.mark.parametrize("more", [[], ["--json"], ["--margin", "5%"]])
def test_two_recordings_are_no_pilot(folder: Path, more: list[str]):
    ran = nvcore("plan", *flags(folder), *FOUND, *more)
    assert ran.exit_code == 2
    assert "a plan needs a pilot of 6 recordings or more, here are 2" in ran.output
    assert ran.stdout == ""


def test_the_help_names_every_measure_that_can_be_planned_for():
    text = nvcore("plan", "--help").output
    assert [name for name in PLAN_KEYS if name not in " ".join(text.split())] == []


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["--measure", "saliensy"], "did you mean 'saliency'?"),
        (["--measure", "saliency", "--margin", "5%"], "--margin: 5% of what?"),
        (["--difference", "some"], "--difference: expected a number, such as 0.5 or 3%"),
        ([*FOUND, "--margin", "5"], "such as 0.03 for 3 percentage points"),
        ([*FOUND, "--margin", "5%", "--difference", "5%"], "give one of the two"),
        (["--power", "80"], "expected a share from 0.5 to 0.99"),
    ],
)
def test_what_cannot_be_planned_is_bad_input(arguments: list[str], words: str, folder: Path):
    ran = nvcore("plan", *flags(folder), *arguments)
    assert ran.exit_code == 2
    assert words in ran.output
