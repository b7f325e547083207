"""``nvcore gate``: exit codes, what is written and printed, and what is never written over."""

from __future__ import annotations

import os
from importlib import import_module
from pathlib import Path
from xml.etree import ElementTree

import pytest
from click.testing import CliRunner
from inputs import flags, nvcore, write
from places import SAMPLE

from nvcore.cli import main

HOLDS = ("--rule", "encounters == 2")
"""A rule that holds for `drive`: two pedestrians, FIR (X) detects both, NIR (Y) the urban one."""


def suite_of(file: Path) -> ElementTree.Element:
    return ElementTree.parse(file).getroot().find("testsuite")


def test_a_failed_rule_fails_the_command_and_names_the_pedestrians_everywhere(folder: Path):
    rules = write(folder / "rules.txt", "newly_missed == 0  # X alone detects one", "frames == 40")
    files = (folder / "ci" / "gate.xml", folder / "gate.md")
    ran = nvcore("gate", *flags(folder), "--rules", rules, *HOLDS,
                 "--junit", files[0], "--markdown", files[1])  # fmt: skip
    assert ran.exit_code == 1, ran.output
    judged = [line for line in ran.stdout.splitlines() if line[:6] in ("passed", "FAILED")]
    assert [line[:6] for line in judged] == ["passed", "FAILED", "passed", "passed"]
    whom = "rural, track 1, frames 0 to 19"
    assert f"FAILED  newly_missed == 0  (newly_missed is 1)\n        {whom}\n" in ran.stdout
    suite = suite_of(files[0])
    assert (suite.attrib["tests"], suite.attrib["failures"]) == ("4", "1")
    assert suite.find("testcase/failure").text.endswith(f"\n{whom}")
    assert "1 of 4 rules failed" in files[1].read_text()
    assert f"\n- {whom}\n" in files[1].read_text()


def test_an_error_of_the_audit_fails_the_gate_unless_a_rule_allows_it(folder: Path):
    with (folder / "nir.csv").open("a") as file:
        file.write("urban,3,10,10,0,5,0.9\n")  # a box without area
    files = (folder / "gate.xml", folder / "gate.md")
    ran = nvcore("gate", *flags(folder), *HOLDS, "--junit", files[0], "--markdown", files[1])
    assert ran.exit_code == 1
    assert ran.stdout.startswith("Audit: 1 error")
    assert "FAILED  audit_errors == 0  (audit_errors is 1)" in ran.stdout
    failed = suite_of(files[0]).find("testcase[@name='audit_errors == 0']/failure")
    assert "nir: 1 row is left out: the width or height is 0 or less." in failed.text
    assert "### Audit: 1 error" in files[1].read_text()
    assert nvcore("gate", *flags(folder), "--rule", "audit_errors <= 1").exit_code == 0


def test_a_warning_of_the_audit_is_shown_and_fails_a_strict_gate(folder: Path):
    same = [*flags(folder), *HOLDS, "--junit", folder / "gate.xml"]
    same[same.index(str(folder / "nir.csv"))] = folder / "fir.csv"
    ran = nvcore("gate", *same)
    assert ran.exit_code == 0, ran.output
    assert "have exactly the same 40 boxes" in ran.stdout
    assert "have exactly the same 40 boxes" in suite_of(folder / "gate.xml").find("system-out").text
    strict = nvcore("gate", *same, "--strict")
    assert strict.exit_code == 1
    assert "FAILED  audit_warnings == 0  (audit_warnings is 3)" in strict.stdout


def test_the_list_says_undefined_where_a_figure_is(folder: Path):
    ran = nvcore("gate", *flags(folder), "--list")
    assert ran.exit_code == 0
    values = dict(line.split() for line in ran.stdout.splitlines())
    assert values["longest_episode_s_x"] == "undefined"
    assert (values["newly_missed"], values["venn.both"], values["frames"]) == ("1", "1", "40")
    assert "nan" not in values.values()
    assert "Audit: " in ran.stderr


def test_the_protocol_changes_the_figures_of_the_curve(folder: Path):
    every = nvcore("gate", *flags(folder), "--list").stdout
    far = nvcore("gate", *flags(folder), "--list", "--protocol", "far").stdout
    differing = {
        line.split()[0] for line, far_line in zip(every.splitlines(), far.splitlines(), strict=True)
        if line != far_line
    }  # fmt: skip
    assert "lamr_x" in differing
    assert "mean_similarity_x" not in differing


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ([], "give a rule: --rule 'lamr_y <= 0.10'"),
        (["--rule", "lamr_x"], "expected a measure"),
        (["--rule", "nothing_x < 1"], "there is no measure 'nothing_x'"),
        (["--rule", "lamr_x < 1", "--protocol", "best"], "'best' is not one of"),
        (["--rules", "absent.txt"], "absent.txt: the rules cannot be read (No such file"),
        (["--rules", "empty.txt"], "the file of rules holds none"),
        (["--list", "--junit", "-"], "only one of --list, --junit - and --markdown - can be"),
        (["--junit", "a", "--markdown", "./a"], "expected two files, found the same twice"),
    ],
)
def test_what_cannot_be_judged_is_bad_input(arguments, words, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    write(tmp_path / "empty.txt", "# none")
    ran = nvcore("gate", SAMPLE, *arguments)
    assert ran.exit_code == 2
    assert words in ran.output


def test_the_hint_at_a_measure_that_does_not_exist_is_a_command_that_works(folder: Path):
    rule = ("--rule", "nothing_x < 1")
    ran = nvcore("gate", SAMPLE, *rule)
    assert f"nvcore gate {SAMPLE} --list shows all measures\n" in ran.stderr
    assert nvcore("gate", SAMPLE, "--list").exit_code == 0
    ran = nvcore("gate", "a night.toml", *rule)
    assert "nvcore gate 'a night.toml' --list shows all measures\n" in ran.stderr
    ran = nvcore("gate", *flags(folder), *rule)
    assert "nvcore gate SESSION_FILE --list shows all measures\n" in ran.stderr


def test_all_wrong_rules_are_told_at_once_with_file_and_line(tmp_path: Path):
    rules = write(
        tmp_path / "rules.txt", "# nightly", "newly_missed = 0", "encounters > 1", "lmr_y < 1"
    )
    ran = nvcore("gate", SAMPLE, "--rules", rules, "--rule", "saliency")
    assert ran.exit_code == 2
    told = ran.stderr.splitlines()
    assert "Error: --rule: 'saliency': expected a measure" in told[0]
    assert f"{rules}, line 2: 'newly_missed = 0'" in told[1]
    assert told[1].endswith("did you mean 'newly_missed == 0'?")
    assert f"{rules}, line 4: 'lmr_y < 1': there is no measure 'lmr_y'; did you mean" in told[2]
    assert told[3:] == [f"nvcore gate {SAMPLE} --list shows all measures"]


def test_rules_may_begin_with_a_byte_order_mark_and_must_be_utf_8(folder: Path):
    rules = folder / "rules.txt"
    rules.write_bytes(b"\xef\xbb\xbfencounters == 2\n")
    assert nvcore("gate", *flags(folder), "--rules", rules).exit_code == 0
    rules.write_bytes(b"encounters == 2 # \xe9\n")
    ran = nvcore("gate", *flags(folder), "--rules", rules)
    assert ran.exit_code == 2
    assert "expected UTF-8 text" in ran.stderr


@pytest.mark.parametrize(
    ("flag", "beginning"), [("--junit", "<?xml"), ("--markdown", "## Gate: all rules passed")]
)
def test_rules_and_results_go_through_the_standard_streams(folder: Path, flag: str, beginning: str):
    arguments = ["gate", *flags(folder), "--rules", "-", flag, "-"]
    ran = CliRunner().invoke(main, arguments, input="encounters == 2\n")
    assert ran.exit_code == 0
    assert ran.stdout.startswith(beginning)
    assert "passed  encounters == 2" not in ran.stdout
    assert "passed  encounters == 2" in ran.stderr
    failed = CliRunner().invoke(main, arguments, input="no rule\n")
    assert failed.exit_code == 2
    assert failed.stdout.startswith("<?xml" if flag == "--junit" else "## Gate: could not be run")
    assert "standard input, line 1: 'no rule'" in failed.stderr


@pytest.mark.parametrize(
    ("wrong", "words"),
    [
        (["--rule", "lmr_y < 1"], "there is no measure 'lmr_y'"),
        (["--y", "absent.csv"], "there is no such file"),
        (["--rul", "encounters > 0"], "No such option"),
    ],
)
def test_of_a_gate_that_cannot_be_run_nothing_green_stays(folder: Path, wrong, words):
    junit, text = folder / "gate.xml", folder / "gate.md"
    written = [*HOLDS, "--junit", junit, f"--markdown={text}"]
    assert nvcore("gate", *flags(folder), *written).exit_code == 0
    assert suite_of(junit).attrib["errors"] == "0"
    assert nvcore("gate", *flags(folder), *written, *wrong).exit_code == 2
    assert suite_of(junit).attrib["errors"] == "1"
    assert words in suite_of(junit).find("testcase/error").text
    assert text.read_text().startswith("## Gate: could not be run\n")


def test_a_gate_that_was_stopped_leaves_nothing_green(folder: Path, monkeypatch):
    def stop(*_: object) -> None:
        raise KeyboardInterrupt

    # the package has the command itself by the module's name
    monkeypatch.setattr(import_module("nvcore.cli.gate"), "compare_session", stop)
    nvcore("gate", *flags(folder), *HOLDS, "--junit", folder / "gate.xml")
    error = suite_of(folder / "gate.xml").find("testcase/error")
    assert error.text == "it was stopped before it ended"


def test_results_that_cannot_be_written_are_told(folder: Path):
    write(folder / "file", "")
    ran = nvcore("gate", *flags(folder), *HOLDS, "--junit", folder / "file" / "x.xml",
                 "--markdown", folder / "gate.md")  # fmt: skip
    assert ran.exit_code == 2
    assert "cannot be written" in ran.stderr
    assert "cannot be written" in (folder / "gate.md").read_text()


def contents(folder: Path) -> dict[str, bytes]:
    return {file.name: file.read_bytes() for file in folder.iterdir()}


def linked(folder: Path) -> Path:
    """The files of `drive` by other names, too, and a session file that names them all."""
    os.link(folder / "fir.csv", folder / "hard.csv")
    (folder / "soft.csv").symlink_to("nir.csv")
    write(folder / "frames.txt", *map(str, range(20)))
    write(folder / "0.png", "a picture")
    write(folder / "rules.txt", "encounters == 2")
    write(
        folder / "session.toml",
        '[defaults]\nsize = "640x480"\nfps = 20',
        '[truth]\npath = "truth.csv"',
        '[[recording]]\nname = "urban"\nframes = "frames.txt"\npictures = "."',
        '[[system]]\npath = "fi*.csv"',
        '[[system]]\npath = "nir.csv"',
    )
    return folder


@pytest.mark.parametrize(
    "name",
    ["truth.csv", "fir.csv", "hard.csv", "soft.csv", "missing/../truth.csv", "frames.txt", "0.png",
     "rules.txt", "session.toml"],
)  # fmt: skip
def test_no_input_is_written_over(folder: Path, name: str):
    before = contents(linked(folder))
    for flag in ("--junit", "--markdown"):
        given = [folder / "session.toml", "--rules", folder / "rules.txt", flag, f"{folder}/{name}"]
        ran = nvcore("gate", *given)
        assert ran.exit_code == 2
        assert f"{name}: is an input, and would be replaced; give another file" in ran.stderr
        assert contents(folder) == before


def test_an_input_that_only_a_broken_session_names_is_not_written_over(folder: Path):
    before = contents(linked(folder))
    broken = write(folder.parent / "broken.toml", '[truth]\npath = "drive/truth.csv')
    for given in ([broken], [*flags(folder), "--no-such-flag"]):
        ran = nvcore("gate", *given, *HOLDS, "--markdown", folder / "truth.csv")
        assert ran.exit_code == 2
        assert contents(folder) == before


def test_results_beside_the_inputs_may_be_written_again(folder: Path):
    given = [linked(folder) / "session.toml", *HOLDS, "--junit", folder / "gate.xml"]
    assert [nvcore("gate", *given).exit_code for _ in range(2)] == [0, 0]


def test_compare_and_report_write_over_no_input(folder: Path):
    text = (folder / "truth.csv").read_text()
    write(folder / "summary.json", text)
    write(folder / "truth.html", text)
    before = contents(folder)
    for command, truth, out in (
        ("compare", "summary.json", folder),
        ("report", "truth.html", folder / "truth.html"),
    ):
        given = [*flags(folder), "--format-truth", "csv", "--out", out]
        given[given.index(str(folder / "truth.csv"))] = folder / truth
        ran = nvcore(command, *given)
        assert ran.exit_code == 2, ran.output
        assert f"{truth}: is an input, and would be replaced" in ran.stderr
    assert contents(folder) == before
