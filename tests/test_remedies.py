"""Ways on as data, and as each medium words them."""

from __future__ import annotations

import pickle
from pathlib import Path

import pytest

from nvcore.cli import remedies as command_line
from nvcore.errors import FormatError, MissingFactError
from nvcore.findings import Remedy, Step, steps_text
from nvcore.inputs.remedies import applied
from nvcore.inputs.session import Session, Source, SystemSource
from ui.shell import remedies as pages
from ui.shell.page_words import page_text

CHILD = Step(Remedy.CLASSES, "pedestrian,child", "truth")
SESSION = Session(
    folder=Path(),
    truth=Source("gt.json"),
    systems=(SystemSource("a.json", name="A"), SystemSource("b.json", name="B")),
)


@pytest.mark.parametrize("texts", [command_line.TEXTS, pages.TEXTS], ids=["flags", "fields"])
def test_each_medium_words_every_remedy_with_and_without_a_value(texts):
    for remedy in Remedy:
        worded = steps_text([Step(remedy, "THE_VALUE")], texts)
        assert worded[0].isupper()
        assert worded.endswith(".")
        assert steps_text([Step(remedy)], texts) == worded.replace("THE_VALUE", texts[remedy][1])


def test_pages_name_no_flag():
    assert "--" not in "".join(text + unknown for text, unknown in pages.TEXTS.values())


def test_the_command_line_names_the_flag_of_the_source():
    marks = {"truth": "-truth", "A": "-x"}
    assert steps_text([CHILD], command_line.TEXTS, marks) == (
        "Give --classes-truth pedestrian,child."
    )


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
    assert page_text(error) == (
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
