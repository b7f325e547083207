"""Every two systems in words, for the terminal and as files."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest
from drives import at_thresholds, drives

from nvcore.common.errors import InputError
from nvcore.evidence.pairwise import COLUMNS, pairwise_table
from nvcore.report.matrix import (
    MATRIX_FILES,
    PAIR_MEASURES,
    matrix_json,
    pair_cells,
    pair_notes,
    pair_text,
    render_matrix,
    winner_of,
    write_matrix,
)
from nvcore.settings.params import Params

OF_NUMBERS = [name for name in COLUMNS if name not in ("x", "y", "unit")]


def pair(**values: Any) -> dict[str, Any]:
    """A pair FIR and NIR over 10 recordings, of which nothing is claimed."""
    notes = ("mcnemar_note", "detected_by_unit_note", "similarity_note")
    texts = ("detects_more", "higher_similarity", "withheld", *notes)
    return {
        **dict.fromkeys(OF_NUMBERS, np.nan),
        **dict.fromkeys(texts, ""),
        "x": "FIR",
        "y": "NIR",
        "unit": "recordings",
        "is_unequal": False,
        **values,
    }


def test_both_claims_are_named_with_the_better_value_first():
    text = pair_text(
        pair(
            detects_more="NIR",
            detected_x=0.5,
            detected_y=0.75,
            detected_by_unit_p_holm=0.0123,
            higher_similarity="FIR",
            similarity_x=0.9,
            similarity_y=0.8,
            similarity_p_holm=0.04,
        )
    )
    assert text == (
        "NIR detects more encounters (75 % against 50 %, p = 0.012 corrected); FIR has the higher "
        "mean similarity (0.900 against 0.800, p = 0.04 corrected)."
    )


def test_at_unequal_operating_points_no_value_as_set_stands_beside_the_claim():
    values = {"detected_x": 0.5, "detected_y": 0.75, "detected_by_unit_p": 0.01}
    row = pair(is_unequal=True, detects_more="NIR", detected_by_unit_p_holm=0.02, **values)
    assert pair_text(row) == (
        "At equal false alarms, NIR detects more encounters (p = 0.02 corrected)."
    )


@pytest.mark.parametrize(
    ("values", "text"),
    [
        ({}, "No difference is shown to be more than chance."),
        ({"unit": "blocks"}, "Nothing is claimed: 6 recordings are needed for a p."),
        (
            {
                "is_unequal": True,
                "false_alarms_per_frame_x": 0.05,
                "false_alarms_per_frame_y": 0.3,
                "detected_by_unit_note": "too few false alarms; few pedestrians",
                "similarity_note": "too few false alarms",
            },
            "Nothing is claimed. The operating points are unequal (0.05 and 0.3 false alarms per "
            "frame), and there is no p at equal false alarms: too few false alarms; few "
            "pedestrians.",
        ),
        (
            {"is_unequal": True, "detected_by_unit_p": 0.2},
            "At equal false alarms, no difference is shown to be more than chance.",
        ),
    ],
)
def test_where_nothing_is_claimed_it_says_why(values: dict[str, Any], text: str):
    assert pair_text(pair(**values)) == text


def test_at_unequal_operating_points_the_real_reason_is_given():
    cases = {
        "the two differ in too few recordings for a test: 0, at least 6": at_thresholds(),
        "neither has scores that differ, so that no threshold sets": at_thresholds(scores=False),
        "6 recordings are needed for a p": at_thresholds(n=3),
    }
    for reason, result in cases.items():
        (row,) = pairwise_table(result.dataset).to_dict("records")
        assert f"and there is no p at equal false alarms: {reason}" in pair_text(row)


def test_undefined_cells_are_dashes_and_get_a_footnote_where_p_is_missing():
    encounters, similarity = PAIR_MEASURES
    of_both = {"detected_by_unit_note": "too few", "similarity_note": "too few"}
    table = pd.DataFrame([pair(**of_both), pair(similarity_p=0.5, **of_both)])
    assert pair_cells(table.iloc[0].to_dict(), encounters) == ("–",) * 6
    assert pair_notes(table, encounters) == (["a", "a"], {"too few": "a"})
    assert pair_notes(table, similarity) == (["a", ""], {"too few": "a"})


def test_a_footnote_stands_at_its_own_measure():
    encounters, similarity = PAIR_MEASURES
    table = pd.DataFrame([pair(detected_by_unit_note="the two are the same; one recording only")])
    same, only = "the two are the same", "one recording only"
    assert pair_notes(table, encounters) == (["a b"], {same: "a", only: "b"})
    assert pair_notes(table, similarity) == ([""], {})


def test_the_winner_is_a_letter_of_the_pair():
    encounters, similarity = PAIR_MEASURES
    better = pair(detects_more="NIR")
    assert (winner_of(better, encounters), winner_of(better, similarity)) == ("y", "")


def test_the_terminal_has_systems_pairs_and_numbers_and_no_line_of_a_name_s_own():
    table = pairwise_table(drives(12)).assign(x="FI\nR")
    lines = render_matrix(table).splitlines()
    assert lines[0] == "2 systems, 1 pair, 60 encounters; each system at its own threshold"
    assert "all scores" in lines[3]
    assert sum(r"FI\nR" in line for line in lines) == 4
    assert [line.split("  ")[0] for line in lines if "p (Holm)" in line] == [
        "encounters detected",
        "mean similarity",
    ]


def test_the_files_hold_the_table_and_null_where_it_is_undefined(tmp_path: Path):
    dataset = drives(3)
    table = pairwise_table(dataset)
    write_matrix(tmp_path, dataset, Params(alpha=0.8), table)
    names = {path.name for path in tmp_path.iterdir() if not path.name.startswith(".")}
    assert names == {*MATRIX_FILES, "SHA256SUMS"}
    content = json.loads((tmp_path / "matrix.json").read_text())
    assert content == json.loads(matrix_json(dataset, Params(alpha=0.8), table))
    assert content["parameters"]["alpha"] == 0.8
    assert [system["system"] for system in content["systems"]] == ["x", "y"]
    (row,) = content["pairs"]
    assert row["similarity_p"] is None  # of 3 recordings there is no p
    assert row["similarity_x"] == pytest.approx(table["similarity_x"].iloc[0])
    assert row["text"] == pair_text(table.iloc[0].to_dict())
    written = pd.read_csv(tmp_path / "matrix.csv")
    assert tuple(written) == COLUMNS


def test_the_report_of_a_comparison_stays_whole(tmp_path: Path):
    (tmp_path / "summary.json").write_text("{}")
    with pytest.raises(InputError, match="holds the report of a comparison"):
        write_matrix(tmp_path, drives(3), Params(), pairwise_table(drives(3)))
