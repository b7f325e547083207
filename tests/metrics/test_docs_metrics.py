"""docs/metrics.md says what the code does: its tables and its examples."""

from __future__ import annotations

import doctest
import math
import re

import pytest
from places import ROOT

from nvcore.dataset.schema import Category, MissClass
from nvcore.inputs.evaluated_frames import MIN_SAMPLED
from nvcore.inputs.readers.meaning.values import PARTIAL_OCCLUSION
from nvcore.metrics.encounters import RELEVANT_K
from nvcore.metrics.kernels import ABSORB_SHARE
from nvcore.metrics.linking import LINK_GAP, LINK_IOU
from nvcore.metrics.proximity.borrowing import LENDING, LONGEST_GAP_S
from nvcore.settings.params import MIDPOINT_SHARE, SETTINGS, SPREAD_SHARE
from nvcore.subjects.time_left.kernels import EDGE_PX, LEAST_FRAMES

PAGE = (ROOT / "docs" / "metrics.md").read_text(encoding="utf-8")


def section(title: str) -> str:
    """Text below a heading, up to the next heading of any level."""
    body = re.search(rf"^#+ {re.escape(title)}\n(.*?)(?=^#+ |\Z)", PAGE, re.DOTALL | re.MULTILINE)
    assert body is not None, f"no section {title!r}"
    return body[1]


def rows_of(title: str) -> list[list[str]]:
    """Cells of the first table of a section, without its header."""
    lines = [line for line in section(title).splitlines() if line.startswith("|")]
    return [[cell.strip() for cell in line.strip("|").split("|")] for line in lines[2:]]


def documented_params() -> dict[str, list[str]]:
    return {row[0].strip("`"): row[1:] for row in rows_of("Parameters")}


def expected_default(value: object) -> str:
    if value is None:
        return "none"
    return value if isinstance(value, str) else f"{value:g}"


def test_every_parameter_has_a_row_in_the_order_of_the_code():
    assert list(documented_params()) == list(SETTINGS)


@pytest.mark.parametrize("name", SETTINGS)
def test_the_row_of_a_parameter_has_its_default_range_and_unit(name):
    default, span, unit, meaning = documented_params()[name]
    assert default == expected_default(SETTINGS[name].default)
    assert span == SETTINGS[name].range_text
    assert unit == (SETTINGS[name].unit or "–")
    assert meaning.endswith(".")


def test_the_fixed_numbers_are_those_of_the_code():
    values = [float(row[1]) for row in rows_of("Fixed numbers")]
    of_linking, of_inputs = [LINK_IOU, LINK_GAP], [MIN_SAMPLED, PARTIAL_OCCLUSION]
    code = [RELEVANT_K, ABSORB_SHARE, *of_linking, LEAST_FRAMES, EDGE_PX]
    code += [LONGEST_GAP_S, LENDING.iou, *of_inputs]
    assert values == code


def test_the_table_of_proximity_weights_is_right():
    lines = [line for line in section("Proximity weight k").splitlines() if line.startswith("|")]
    heights, weights = (
        [float(cell) for cell in line.strip("|").split("|")[1:]]
        for line in lines
        if re.match(r"\| (height, px|k) \|", line)
    )
    midpoint, spread = MIDPOINT_SHARE * 480, SPREAD_SHARE * 480
    assert weights == [round(1 / (1 + math.exp((midpoint - h) / spread)), 3) for h in heights]


def test_the_table_of_single_misses_is_right():
    rows = rows_of("The formula")
    assert [row[0] for row in rows] == ["30 px", "48 px", "96 px"]
    for height, *cells in rows:
        k = 1 / (1 + math.exp((48 - float(height.removesuffix(" px"))) / 9.6))
        borders = (320, 160, 32)
        assert [float(cell) for cell in cells] == [
            round(1 - 0.9 * k * border / 320, 3) for border in borders
        ]


@pytest.mark.parametrize(
    ("title", "kinds"), [("Categories and dominance", Category), ("Miss classes", MissClass)]
)
def test_kinds_stand_in_the_order_of_the_code(title, kinds):
    assert [row[0].strip("`") for row in rows_of(title)] == list(kinds)


def test_the_python_examples_run_as_shown():
    blocks = re.findall(r"^```python\n(.*?)^```", PAGE, re.DOTALL | re.MULTILINE)
    assert len(blocks) >= 7
    # one run: later examples use the helper of the first
    examples = doctest.DocTestParser().get_doctest("\n".join(blocks), {}, "metrics.md", None, 0)
    report: list[str] = []
    failed = doctest.DocTestRunner(verbose=False).run(examples, out=report.append).failed
    assert not failed, "".join(report)
