"""docs/formats.md names what the code reads and writes."""

from __future__ import annotations

import re
from dataclasses import fields
from pathlib import Path

import pytest
from places import ROOT

from nvcore.inputs import convert
from nvcore.inputs.readers import FORMATS
from nvcore.inputs.session import RecordingFacts, SystemSource
from nvcore.inputs.session_toml import read_session

PAGE = (ROOT / "docs" / "formats.md").read_text(encoding="utf-8")


def rows_of(heading: str) -> list[list[str]]:
    """Cells of the first table below a heading, without its header."""
    text = PAGE.partition(f"\n{heading}\n")[2]
    table = re.search(r"(^\|.*\n)+", text, re.MULTILINE)
    assert table is not None, f"no table below {heading!r}"
    lines = table[0].splitlines()[2:]
    return [[cell.strip() for cell in line.strip("|").split(" | ")] for line in lines]


def test_the_table_lists_every_format_in_the_order_in_which_they_are_asked():
    names = [re.sub(r"[\[\]`]|\(.*\)", "", row[0]) for row in rows_of("## The formats")]
    assert names == [one.name for one in FORMATS]


@pytest.mark.parametrize("one", FORMATS, ids=lambda one: one.name)
def test_the_row_of_a_format_has_its_title_roles_and_endings(one):
    rows = {re.sub(r"[\[\]`]|\(.*\)", "", row[0]): row for row in rows_of("## The formats")}
    _, title, roles, _, endings = rows[one.name]
    assert title == one.title
    assert roles.split(", ") == list(one.roles)
    assert endings.split(", ") == list(one.suffixes)


@pytest.mark.parametrize("one", FORMATS, ids=lambda one: one.name)
def test_every_format_has_a_section(one):
    assert f"\n### `{one.name}`\n" in PAGE


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
    assert named == set(convert.FORMATS)


@pytest.fixture
def example(tmp_path: Path) -> Path:
    """The page's example of a session file."""
    found = re.search(r"^```toml\n(.*?)^```", PAGE, re.DOTALL | re.MULTILINE)
    assert found is not None
    path = tmp_path / "session.toml"
    path.write_text(found[1], encoding="utf-8")
    return path


def test_the_example_of_a_session_file_can_be_read(example):
    session = read_session(example)
    assert [system.name for system in session.systems] == ["FIR", "NIR"]
    assert session.size == (640, 480)
    assert session.params.edge_weight == 0.2
    assert session.systems[1].offset_px == (0, 12)
    assert set(session.hashes) == {"truth", "FIR"}


@pytest.mark.parametrize(
    "key", sorted({spec.name for kind in (RecordingFacts, SystemSource) for spec in fields(kind)})
)
def test_the_example_of_a_session_file_shows_every_key(example, key):
    assert re.search(rf"^{key} = ", example.read_text(encoding="utf-8"), re.MULTILINE)
