"""The pairs of KAIST systems as docs/validation.md has them."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from places import ROOT

from nvcore.comparison import compare
from nvcore.evidence.miss_rate import judge_miss_rate
from nvcore.evidence.units import find_units
from nvcore.inputs.load import load
from nvcore.inputs.session import RecordingFacts, Session, Source, SystemSource
from nvcore.params import Params
from nvcore.protocols import PROTOCOLS

SETS = {"set06": 5, "set07": 3, "set08": 3, "set09": 1, "set10": 2, "set11": 2}
ROW = re.compile(
    r"^\| ([\w-]+) \| ([\w-]+) \| ([+-][\d.]+) \| ([+-][\d.]+) to ([+-][\d.]+) \| (\S+) \|"
)
PAGE = ROOT / "docs" / "validation.md"


@pytest.mark.realdata
@pytest.mark.parametrize("pair", [("MBNet", "GAFF"), ("TCDet-thermal", "YOLOv3-visible")])
def test_the_table_of_pairs_is_what_the_program_gives(realdata: Path, pair: tuple[str, str]):
    session = Session(
        folder=realdata / "kaist",
        truth=Source(("KAIST_annotation.json",)),
        systems=tuple(SystemSource((f"results/{name}_result.txt",), name=name) for name in pair),
        recordings=tuple(RecordingFacts(f"{s}/V{i:03}") for s, n in SETS.items() for i in range(n)),
        fps=20.0,
    )
    result = compare(load(session), Params())
    found = judge_miss_rate(result, find_units(result), PROTOCOLS["kaist-reasonable"])
    rows = {(row[1], row[2]): row for row in map(ROW.match, PAGE.read_text().splitlines()) if row}
    shown = rows[pair]
    assert [float(shown[i]) for i in (3, 4, 5)] == pytest.approx(
        [100 * found.difference, 100 * found.low, 100 * found.high], abs=0.006
    )
    assert float(shown[6]) == pytest.approx(found.p, rel=0.05)
