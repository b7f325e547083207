"""The fuzzer: its targets pass what they begin with, and a fault is kept by its smallest input."""

from __future__ import annotations

import importlib
import json
import sys
import tomllib
from contextlib import nullcontext
from dataclasses import replace
from pathlib import Path
from random import Random
from types import ModuleType

import numpy as np
import pytest

from nvcore.common.errors import InputError, NvcoreError
from scripts.fuzz.__main__ import fuzz, prepare
from scripts.fuzz.target import mutated_text, without_bad_lines
from scripts.fuzz.targets import TARGETS
from scripts.fuzz.trial import Trial


@pytest.mark.parametrize("name", TARGETS)
def test_what_a_target_begins_with_is_read_or_refused_most_of_it_read(name: str, tmp_path: Path):
    n_read, seeds = 0, list(TARGETS[name].first_inputs())
    for number, content in enumerate(seeds):
        assert len(content) <= TARGETS[name].most_bytes
        folder = tmp_path / str(number)
        folder.mkdir()
        try:
            TARGETS[name].run(content, folder)
        except NvcoreError:
            continue
        n_read += 1
    assert n_read > 0.7 * len(seeds)


def test_seeds_are_files_and_their_words_a_dictionary(tmp_path: Path):
    prepare("recordings", tmp_path)
    files = list((tmp_path / "seeds" / "recordings").iterdir())
    assert {file.read_bytes() for file in files} == set(TARGETS["recordings"].first_inputs())
    words = (tmp_path / "seeds" / "recordings.dict").read_text("ascii").splitlines()
    spelled = "".join(f"\\x{letter:02x}" for letter in b"pictures")
    assert f'"{spelled}"' in words


def test_lines_that_are_no_toml_are_left_out():
    text = b'[truth]\npath = "a"\n<<<\nfps = = 3\n\xff[[system]]\nname = "x"'
    assert tomllib.loads(without_bad_lines(text).decode()) == {
        "truth": {"path": "a"},
        "system": [{"name": "x"}],
    }


@pytest.fixture
def trial_of(monkeypatch: pytest.MonkeyPatch, tmp_path: Path):
    """A trial of a function."""
    (tmp_path / "work").mkdir()

    def make(run):
        monkeypatch.setitem(TARGETS, "rules", replace(TARGETS["rules"], run=run))
        return Trial("rules", tmp_path, tmp_path / "work")

    return make


def test_a_fault_is_kept_once_for_its_place_by_its_smallest_input(trial_of, tmp_path: Path):
    def run(content: bytes, folder: Path) -> None:
        (folder / "left").mkdir()
        if content.startswith(b"no"):
            raise InputError("refused")
        if content.startswith(b"bad"):
            raise KeyError(content)
        assert not content.startswith(b"worse")

    trial = trial_of(run)
    for content in (b"fine", b"no", b"bad and long", b"bad", b"bad again", b"worse"):
        trial(content)
        assert list((tmp_path / "work").iterdir()) == []
    trial.note()
    counts = json.loads((tmp_path / "rules.json").read_text("utf-8"))
    assert [counts[name] for name in ("read", "refused", "faults")] == [1, 1, 4]
    contents = {file.read_bytes() for file in (tmp_path / "faults" / "rules").glob("*[!t]")}
    assert contents == {b"bad", b"worse"}
    notes = [file.read_text("utf-8") for file in (tmp_path / "faults" / "rules").glob("*.txt")]
    assert sorted(note.split()[0] for note in notes) == ["AssertionError", "KeyError"]


def test_counts_go_on_where_the_process_before_ended(trial_of, tmp_path: Path):
    (tmp_path / "rules.json").write_text('{"read": 7, "refused": 1}', "utf-8")
    trial = trial_of(lambda _content, _folder: None)
    trial(b"")
    assert (trial.counts["read"], trial.counts["refused"], trial.counts["faults"]) == (8, 1, 0)


def test_a_target_whose_seeds_have_no_words_is_fuzzed_without(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
):
    fuzzer = ModuleType("atheris")
    fuzzer.instrument_imports = lambda **_: nullcontext()
    monkeypatch.setitem(sys.modules, "atheris", fuzzer)
    worker = importlib.import_module("scripts.fuzz.worker")
    monkeypatch.delitem(sys.modules, "scripts.fuzz.worker")
    for name, n_flags in (("rules", 1), ("frames", 0)):
        prepare(name, tmp_path)
        assert len(worker.dictionary(tmp_path / "seeds" / f"{name}.dict")) == n_flags


def test_many_inputs_are_tried_by_chance_alone_until_there_are_as_many(tmp_path: Path):
    counts = fuzz("frames", 0, 300, tmp_path)
    assert counts["read"] + counts["refused"] == 300
    assert min(counts["read"], counts["refused"]) > 10
    assert (counts["faults"], counts["ends"]) == (0, 0)


def test_a_warning_a_slow_input_and_an_error_without_a_message_are_faults(trial_of, monkeypatch):
    def run(content: bytes, _folder: Path) -> None:
        if content == b"warning":
            np.float64(1) / np.float64(0)
        if content == b"silent":
            raise InputError("")

    trial = trial_of(run)
    assert [trial(content) for content in (b"", b"warning", b"silent")] == ["read", *["faults"] * 2]
    monkeypatch.setattr("scripts.fuzz.trial.SLOW_S", -1.0)
    assert trial(b"") == "faults"


@pytest.mark.parametrize("name", ["detectors", "estimators"])
def test_a_changed_model_is_often_refused_and_often_read(name: str, tmp_path: Path):
    target, rng = TARGETS[name], Random(1)
    n_read = n_refused = 0
    for _ in range(150):
        content = mutated_text(rng.choice(target.first_inputs()), rng)[: target.most_bytes]
        try:
            target.run(content, tmp_path)
            n_read += 1
        except NvcoreError:
            n_refused += 1
    assert min(n_read, n_refused) > 10
