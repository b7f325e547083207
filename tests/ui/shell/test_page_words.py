"""No flag of the command line is shown in the browser."""

from __future__ import annotations

import ast
import re

import pytest
from places import ROOT

from ui.shell.page_words import page_text

ROOMS = ("auditing", "inputs", "metrics", "detection", "pictures")
COMMANDS_ONLY = ("conversion.py", "writers")
"""Files and folders."""
FLAG = re.compile(r"(?<![\w-])--[a-z]")


def messages() -> list[tuple[str, str]]:
    """Every text of the library with a flag, and where it stands; docstrings left out."""
    texts = []
    for room in ROOMS:
        for path in sorted((ROOT / "nvcore" / room).rglob("*.py")):
            if {path.name, path.parent.name} & {*COMMANDS_ONLY}:
                continue
            tree = ast.parse(path.read_text(encoding="utf-8"))
            docs = {
                node.value
                for node in ast.walk(tree)
                if isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant)
            }
            texts += [
                (path.name, node.value)
                for node in ast.walk(tree)
                if isinstance(node, ast.Constant)
                and isinstance(node.value, str)
                and node not in docs
                and FLAG.search(node.value)
            ]
    return texts


def test_there_are_messages_to_look_at():
    assert len(messages()) > 20


@pytest.mark.parametrize(("where", "text"), messages())
def test_a_page_words_every_message_without_flags(where: str, text: str):
    assert not FLAG.search(page_text(text)), where


@pytest.mark.parametrize(
    ("text", "page"),
    [
        (
            "Compare with --proximity height, which",
            "Compare with “What tells how near” set to height, which",
        ),
        (
            "Compare with --distance ground, too: x",
            "Compare with “Distance” set to foot points, under “Advanced”, too: x",
        ),
        ("Check the image size (--size): x", "Check the image size: x"),
        (
            "for this system ([[system]] in the session file, or --scale-x 2,3).",
            "for this system (the button does it).",
        ),
        (
            "give the list (--frames first:last:step): in",
            "give the list (under “Evaluated frames”): in",
        ),
        ("say so with --box-base 0.", "say so under “How to read”: “the first pixel is 0”."),
        ("Give --threshold-x a value within", "Give the threshold of X a value within"),
        ("a file called a--size.csv stays", "a file called a--size.csv stays"),
    ],
)
def test_what_is_done_on_the_page_stands_in_place_of_the_flag(text: str, page: str):
    assert page_text(text) == page
