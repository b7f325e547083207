"""Texts of notes, as their examples come out; run this file to write the golden files anew."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import pytest

from nvcore.notes import TEXT, Note, entries, say
from nvcore.settings.objects import PEDESTRIAN, SPEED_SIGN

ROOT = Path(__file__).resolve().parent.parent
GOLDEN = ROOT / "tests" / "golden"
TOPICS = sorted(
    {path.stem for path in (ROOT / "nvcore" / "notes").glob("*.toml")}
    | {path.parent.name for path in (ROOT / "nvcore" / "subjects").glob("*/notes.toml")}
)


def note_of(key: str, values: dict[str, Any]) -> Note:
    """A note with the values of an example, in which some are notes."""
    return Note(key, **{name: value_of(value) for name, value in values.items()})


def value_of(value: Any) -> Any:
    if isinstance(value, dict) and "note" in value:
        return note_of(value["note"], {name: of for name, of in value.items() if name != "note"})
    return [value_of(each) for each in value] if isinstance(value, list) else value


def texts_of(topic: str) -> str:
    """All entries of a topic, in all their forms, by their examples."""
    lines = []
    for name, entry in entries(topic).items():
        examples = entry.get("example", {})
        for example in examples if isinstance(examples, list) else [examples]:
            note = note_of(f"{topic}.{name}", example)
            lines += [
                f"{name}{f' ({form})' * (form != TEXT)}: {say(note, PEDESTRIAN, form)}"
                for form in entry
                if form != "example"
            ]
    return "\n".join([*lines, ""])


@pytest.mark.parametrize("topic", TOPICS)
def test_examples_are_worded_as_before(topic: str):
    assert texts_of(topic) == (GOLDEN / f"{topic}.txt").read_text("utf-8")


def test_every_note_has_a_text_and_every_text_a_note():
    files = [*(ROOT / "nvcore").rglob("*.py"), *(ROOT / "ui").rglob("*.py")]
    templates = [str(entry) for topic in TOPICS for entry in entries(topic).values()]
    source = "\n".join([*(path.read_text("utf-8") for path in files), *templates])
    keys = {f"{topic}.{name}" for topic in TOPICS for name in entries(topic)}
    used = {key for key in keys if f'"{key}"' in source}
    assert used == keys
    assert {*re.findall(r'\bNote\(\s*"([\w.]+)"', source)} <= keys


def test_what_users_named_is_never_a_template():
    name = "{{ one }} of --fps 25 who {one}"
    note = Note("verdict.worst_failure", system="x", track="7", recording=name, seconds=0.5)
    assert say(note, SPEED_SIGN) == (
        f"The worst single failure is X's: speed sign 7 in {name}, 0.5 s."
    )


if __name__ == "__main__":
    GOLDEN.mkdir(exist_ok=True)
    for of in TOPICS:
        (GOLDEN / f"{of}.txt").write_text(texts_of(of), "utf-8")
