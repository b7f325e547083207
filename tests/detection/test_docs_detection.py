"""The pages on detection curves and on validation say what the code does."""

from __future__ import annotations

import math
import re

import pytest
from places import ROOT
from published import MEASURED, PUBLISHED

from nvcore.settings.protocols import OCCLUSION_WORDS, PROTOCOLS, Protocol

DOCS = ROOT / "docs"


def table_rows(page: str, header: str) -> list[list[str]]:
    """Cells of the table that starts with this header."""
    text = (DOCS / page).read_text(encoding="utf-8")
    _, _, rest = text.partition(f"\n{header}\n")
    assert rest, f"{page} has no table {header!r}"
    lines = rest.split("\n\n")[0].strip().splitlines()[1:]
    return [[cell.strip() for cell in line.strip("|").split("|")] for line in lines]


def limits(low: float, high: float) -> str:
    if (low, high) == (0, math.inf):
        return "any"
    return f"{low:g} or more" if high == math.inf else f"{low:g} to {high:g}"


def row_of(protocol: Protocol) -> list[str]:
    low, high = protocol.height_px
    border = "any" if protocol.border_px is None else f"{protocol.border_px[0]:g}"
    levels = ", ".join(OCCLUSION_WORDS[i] for i in protocol.occlusion)
    expand = protocol.expand
    detections = "all" if expand is None else limits(low / expand, high * expand)
    return [
        f"`{protocol.name}`", limits(low, high), "any" if len(protocol.occlusion) == 3 else levels,
        border, detections,
    ]  # fmt: skip


def test_the_table_of_protocols_is_that_of_the_code():
    rows = table_rows("detection.md", "| Protocol | Height | Occlusion | Border | Detections |")
    assert rows == [row_of(protocol) for protocol in PROTOCOLS.values()]


@pytest.mark.parametrize("system", [*PUBLISHED, *MEASURED])
def test_the_table_of_kaist_is_what_the_tests_hold(system):
    header = "| System | All | published | Day | published | Night | published |"
    row = next(row for row in table_rows("validation.md", header) if row[0] == system)
    figures = (PUBLISHED | MEASURED)[system]
    assert [float(cell) for cell in row[1::2]] == pytest.approx(figures, abs=0.005)
    published = ["–"] * 3 if system in MEASURED else [f"{value:.2f}" for value in figures]
    assert row[2::2] == published


@pytest.mark.realdata
def test_the_example_of_the_validation_page_gives_gaff_s_figures(realdata, monkeypatch, capsys):
    text = (DOCS / "validation.md").read_text(encoding="utf-8")
    example = re.search(r"^```python\n(.*?)^```", text, re.DOTALL | re.MULTILINE)
    assert example is not None
    monkeypatch.chdir(realdata)
    exec(compile(example[1], "validation.md", "exec"), {})
    assert capsys.readouterr().out.split() == ["6.48", "8.35", "3.46"]
