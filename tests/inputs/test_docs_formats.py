"""docs/formats.md names what the code reads and writes."""

from __future__ import annotations

import re
from dataclasses import fields
from pathlib import Path

from inputs import write
from places import ROOT

from nvcore.inputs import writers
from nvcore.inputs.readers import FORMATS
from nvcore.inputs.session import RecordingEntry, SystemSource
from nvcore.inputs.session.toml import read_session

PAGE = (ROOT / "docs" / "formats.md").read_text(encoding="utf-8")


def rows_of(heading: str) -> list[list[str]]:
    """Cells of the first table below a heading, without its header."""
    text = PAGE.partition(f"\n{heading}\n")[2]
    table = re.search(r"(^\|.*\n)+", text, re.MULTILINE)
    assert table is not None, f"no table below {heading!r}"
    lines = table[0].splitlines()[2:]
    return [[cell.strip() for cell in line.strip("|").split(" | ")] for line in lines]


def test_the_table_lists_every_format_in_the_order_in_which_they_are_asked():
    rows = rows_of("## The formats")
    assert [re.sub(r"[\[\]`]|\(.*\)", "", row[0]) for row in rows] == [
        form.name for form in FORMATS
    ]
    assert [(row[1], row[2], row[4]) for row in rows] == [
        (form.title, ", ".join(form.roles), ", ".join(form.suffixes)) for form in FORMATS
    ]
    missing = [form.name for form in FORMATS if f"\n### `{form.name}`\n" not in PAGE]
    assert missing == [], "no section about these formats"


def test_every_finding_of_a_reader_that_the_page_names_exists():
    named = set(re.findall(r"(?:warning|error|[Ww]arnings:)\s+`([a-z-]+)`", PAGE))
    code = "".join(
        path.read_text(encoding="utf-8")
        for path in (ROOT / "nvcore" / "inputs" / "readers").rglob("*.py")
    )
    assert len(named) > 10
    assert {name for name in named if f'"{name}"' not in code} == set()


def test_every_format_to_write_has_a_row():
    named = {re.findall(r"`(\w+)`", row[0])[0] for row in rows_of("## What `convert` writes")}
    assert named == set(writers.FORMATS)


def test_the_example_of_a_session_file_can_be_read_and_shows_every_key(tmp_path: Path):
    example = re.search(r"^```toml\n(.*?)^```", PAGE, re.DOTALL | re.MULTILINE)
    assert example is not None
    session = read_session(write(tmp_path / "session.toml", example[1]))
    assert [system.name for system in session.systems] == ["FIR", "NIR", "NIR 2"]
    assert session.size == (640, 480)
    assert session.params.edge_weight == 0.2
    assert session.systems[1].offset_px == (0, 12)
    assert set(session.hashes) == {"truth", "FIR"}
    keys = {spec.name for kind in (RecordingEntry, SystemSource) for spec in fields(kind)}
    assert keys <= set(re.findall(r"^(\w+) = ", example[1], re.MULTILINE))
