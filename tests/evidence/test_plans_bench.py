"""The simulation that checks plans from small pilots, at a small scale."""

from __future__ import annotations

from typing import Any

from places import ROOT

from bench.plans import BEGIN, END, HEAD, PLANS, SIZES, table_text

NAME, SIZE = next(iter(PLANS)), SIZES[0]


def row(*sizes: int | None, shown: tuple[int, int] = (0, 0)) -> dict[str, Any]:
    size, least, most = sizes
    ends = {"size": size, "least": least, "most": most}
    claims = {"shown_size": shown[0], "shown_most": shown[1]}
    return {"plan": NAME, "n": SIZE, "studies": 4, **ends, **claims}


def cells(*rows: dict[str, Any]) -> list[str]:
    head, _, line, of_all = table_text(rows).splitlines()
    assert head == f"| {' | '.join(HEAD)} |"
    assert line.split("|")[-3:] == of_all.split("|")[-3:]  # there is but one
    return [cell.strip() for cell in line.split("|")[1:-1]]


def test_ranges_are_held_against_the_plans_of_other_pilots():
    wide, far = row(10, 6, 20, shown=(2, 4)), row(20, 15, 40, shown=(3, 4))
    name, n, given, planned, most, others, middle, as_planned, at_most = cells(
        wide, far, row(None, None, None)
    )
    assert (name, n) == (NAME, str(SIZE))
    assert given.startswith("2 of 3, 67%")
    assert (planned, most) == ("10 (10 to 20)", "30")
    assert others == "50%"  # 20 is in 6 to 20, 10 is not in 15 to 40
    assert middle.startswith("1 of 2, 50%")
    assert as_planned.startswith("5 of 8, 62%")
    assert at_most.startswith("8 of 8, 100%")


def test_without_a_plan_only_that_is_known():
    assert cells(row(None, None, None))[2:] == ["0 of 1, 0% (0 to 79)", *["–"] * 6]


def test_the_documentation_has_a_place_for_the_table():
    page = (ROOT / "docs" / "significance.md").read_text(encoding="utf-8")
    assert page.index(BEGIN) < page.index(END)
