"""Ways on as data, and as each medium words them."""

from __future__ import annotations

import ast
import pickle
import re
from collections.abc import Iterator
from pathlib import Path

import click
import pytest
from places import ROOT

from nvcore.cli import main
from nvcore.cli import remedies as command_line
from nvcore.common.errors import FormatError, MissingFactError
from nvcore.common.findings import Finding, Remedy, Severity, Step, steps_text
from nvcore.inputs.load import load
from nvcore.inputs.session import Session, Source, SystemSource
from nvcore.inputs.session.changes import applied
from ui.shell import remedies as pages
from ui.shell.messages import error_text

LIBRARY = [
    path
    for path in sorted((ROOT / "nvcore").rglob("*.py"))
    if not {"cli", "dashboard", "arguments", "arguments.py"} & {*path.relative_to(ROOT).parts}
    and "import click\n" not in path.read_text(encoding="utf-8")
]
"""The modules that know of no medium: all but those of the commands."""
OF_COMMANDS = ("boxes", "force", "frames_out", "recompute", "role", "truth")
"""Options of what no page does."""
CHILD = Step(Remedy.CLASSES, "pedestrian,child", "truth")
SESSION = Session(
    folder=Path(),
    truth=Source("gt.json"),
    systems=(SystemSource("a.json", name="A"), SystemSource("b.json", name="B")),
)


def texts_of(path: Path) -> Iterator[ast.Constant]:
    """Every text in a module that is no docstring."""
    tree = ast.parse(path.read_text(encoding="utf-8"))
    docs = {id(node.value) for node in ast.walk(tree) if isinstance(node, ast.Expr)}
    for node in ast.walk(tree):
        is_text = isinstance(node, ast.Constant) and isinstance(node.value, str)
        if is_text and id(node) not in docs:
            yield node


def options_of_steps() -> set[tuple[str, str]]:
    """Value and name of every option that the library says to give."""
    of_step = re.compile(r'Step\(Remedy\.OPTION, "([^"]*)", "(\w+)"\)')
    return {option for path in LIBRARY for option in of_step.findall(path.read_text("utf-8"))}


def test_the_library_names_no_flag():
    named = [
        f"{path.relative_to(ROOT)}, line {node.lineno}: {node.value}"
        for path in LIBRARY
        for node in texts_of(path)
        if re.search(r"(?<![\w-])--[a-z]", node.value)
    ]
    assert len(LIBRARY) > 300
    assert not named


@pytest.mark.parametrize("texts", [command_line.TEXTS, pages.TEXTS], ids=["flags", "fields"])
def test_each_medium_words_every_remedy_with_and_without_a_value(texts):
    for remedy in set(Remedy) - {Remedy.OPTION}:
        worded = steps_text([Step(remedy, "THE_VALUE")], texts)
        assert worded[0].isupper()
        assert worded.endswith(".")
        assert steps_text([Step(remedy)], texts) == worded.replace("THE_VALUE", texts[remedy][1])


def test_every_flag_that_is_named_exists():
    options = [option for command in commands(main) for option in command.params]
    flags = {flag for option in options for flag in option.opts}
    steps = [Step(remedy, "", "A") for remedy in set(Remedy) - {Remedy.OPTION}]
    steps += [Step(Remedy.OPTION, *option) for option in options_of_steps()]
    texts = [command_line.ways_text([step], {"A": "-x"}) for step in steps]
    named = {flag for text in texts for flag in re.findall(r"--[a-z-]+", text)}
    assert len(named) > 15
    assert named <= flags


def commands(command: click.Command) -> list[click.Command]:
    """A command with all below it."""
    below = command.commands.values() if isinstance(command, click.Group) else ()
    return [command, *(every for subcommand in below for every in commands(subcommand))]


def test_pages_word_every_option_without_flags():
    for value, name in options_of_steps():
        if name not in OF_COMMANDS:
            text = pages.ways_text([Step(Remedy.OPTION, value, name)])
            assert text.endswith(".")
            assert "--" not in text
    assert "--" not in "".join(text + unknown for text, unknown in pages.TEXTS.values())


def test_the_command_line_names_the_flag_of_the_source():
    marks = {"truth": "-truth", "A": "-x"}
    assert command_line.ways_text([CHILD], marks) == "Give --classes-truth pedestrian,child."
    step = Step(Remedy.THRESHOLD, "", "A")
    assert command_line.ways_text([step], marks) == "Give --threshold-x SCORE."
    assert pages.ways_text([step], ["A", "B"]) == "Set the threshold of X to such a score."


@pytest.mark.parametrize(
    ("suggestion", "by_flags", "by_keys"),
    [
        (
            (("scale_x", 2.0), ("scale_y", 1.5), ("offset_x_px", -6.0), ("offset_y_px", 3.0)),
            "Give --scale-x 2,1.5 --offset-px-x -6,3.",
            "scale = [2, 1.5] and offset_px = [-6, 3]",
        ),
        ((("offset_frames", -2.0),), "Give --offset-frames-x -2.", "offset_frames = -2"),
        ((("threshold", 0.25),), "Give --threshold-x 0.25.", "threshold = 0.25"),
    ],
)
def test_the_command_line_words_suggested_corrections(suggestion, by_flags, by_keys):
    finding = Finding(Severity.WARNING, "time-offset", "A", 1, "", "", suggestion=suggestion)
    assert command_line.suggestion_text(finding, {"A": "-x"}) == by_flags
    assert command_line.suggestion_text(finding, {}) == (
        f'Write {by_keys} under [[system]] "A" of the session file.'
    )


def test_facts_that_are_missing_are_all_needed():
    error = MissingFactError("not in the data", facts=("size", "fps"))
    assert command_line.error_text(error) == (
        "not in the data. Give --size WIDTHxHEIGHT and give --fps FPS."
    )
    assert error_text(error) == (
        "not in the data. Enter width and height as the size of the pictures and enter frames per "
        "second as the frame rate."
    )


def test_the_name_of_a_file_is_nobodys_flag(tmp_path: Path):
    path = tmp_path / "drive --fps 25.csv"
    path.write_text("frame,x,y,w,h\n0,1,1,5,tall\n")
    with pytest.raises(FormatError) as raised:
        load(Session(tmp_path, Source(path.name), (), size=(640, 480), fps=10))
    for told in (command_line.error_text(raised.value), error_text(raised.value)):
        assert told.endswith("drive --fps 25.csv, line 2: expected a number as h, found 'tall'")


def test_an_error_keeps_its_ways_on_in_another_process():
    error = FormatError("no names", file="a.txt", line=3, steps=(CHILD,))
    assert pickle.loads(pickle.dumps(error)).steps == (CHILD,)
    missing = MissingFactError("no size", facts=("size",), steps=(Step(Remedy.SIZE),))
    assert pickle.loads(pickle.dumps(missing)).steps == (Step(Remedy.SIZE),)


def test_an_error_is_shown_with_its_ways_on_in_each_medium():
    error = FormatError("several classes and no names.", file="a.txt", steps=(CHILD,))
    assert command_line.error_text(error) == (
        "a.txt: several classes and no names. Give --classes pedestrian,child."
    )
    assert error_text(error) == (
        "a.txt: several classes and no names. "
        "Enter pedestrian,child as “Classes that count” under “How to read”."
    )


def test_a_step_is_applied_to_the_source_that_it_is_about():
    session = applied(SESSION, CHILD, ["A", "B"])
    assert session is not None
    assert session.truth.classes == ("pedestrian", "child")
    assert [system.classes for system in session.systems] == [None, None]


def test_a_step_about_nobody_is_applied_to_all_sources():
    session = applied(SESSION, Step(Remedy.CLASSES, "3"), ["A", "B"])
    assert session is not None
    assert {source.classes for source, _ in session.sources} == {("3",)}


def test_size_rate_and_frames_are_applied_to_all_recordings():
    session = SESSION
    for step in (
        Step(Remedy.SIZE, "640x480"),
        Step(Remedy.RATE, "12.5"),
        Step(Remedy.FRAMES, "0:99:2"),
    ):
        session = applied(session, step, ["A", "B"]) or session
    assert (session.size, session.fps, session.frames) == ((640, 480), 12.5, "0:99:2")


@pytest.mark.parametrize("step", [Step(Remedy.SIZE), Step(Remedy.TABLE, "frame,x,y,w,h")])
def test_what_only_the_user_can_do_is_not_applied(step):
    assert applied(SESSION, step, ["A", "B"]) is None
