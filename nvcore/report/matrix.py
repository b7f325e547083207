"""Pairwise comparison of all systems in a session: who is better in what, as text and files."""

from __future__ import annotations

import json
import math
from collections.abc import Hashable, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any, Final, NamedTuple

import pandas as pd

from nvcore import __version__
from nvcore.common.errors import InputError
from nvcore.common.output.csv_text import to_csv_bytes
from nvcore.common.output.files import refuse_other_run, write_run
from nvcore.common.wording import aligned, count_text, difference, interval_text, number, one_line
from nvcore.common.wording.footnotes import Footnotes
from nvcore.comparison.measures.table import evidence_form
from nvcore.dataset import Dataset
from nvcore.evidence.pairwise import systems_of
from nvcore.evidence.units import MIN_RECORDINGS, WHOLE
from nvcore.notes import Note, phrase
from nvcore.settings.objects import PEDESTRIAN
from nvcore.settings.params import Params
from nvcore.tables.summary import without_nan

MATRIX_FILES: Final = ("matrix.csv", "matrix.json")
HEAD: Final = ("first", "second", "first - second", "95 % interval", "p", "p (Holm)")
SYSTEM_HEAD: Final = (
    "threshold",
    "false alarms per frame",
    "encounters detected",
    "mean similarity",
)


class PairMeasure(NamedTuple):
    """A measure of each pair: title, template of the claim, and names of its columns."""

    key: str
    title: str
    claim: str
    value: str
    evidence: str
    winner: str


PAIR_MEASURES: Final = (
    PairMeasure(
        "encounters_detected_by_unit",
        "encounters detected",
        "matrix.detects_more",
        *("detected", "detected_by_unit", "detects_more"),
    ),
    PairMeasure(
        "mean_similarity",
        "mean similarity",
        "matrix.higher_similarity",
        *("similarity", "similarity", "higher_similarity"),
    ),
)


def pair_name(pair: Mapping[Hashable, Any], *, between: str = " - ") -> str:
    """Return both names in a row of `nvcore.evidence.pairwise.pairwise_table`, X first."""
    return f"{pair['x']}{between}{pair['y']}"


def winner_of(pair: Mapping[Hashable, Any], measure: PairMeasure) -> str:
    """Return ``x`` or ``y``, the system that is claimed to be better, or "" without a claim."""
    name = pair[measure.winner]
    return "" if not name else "x" if name == pair["x"] else "y"


def pair_cells(pair: Mapping[Hashable, Any], measure: PairMeasure) -> tuple[str, ...]:
    """Format the values of a pair, their difference, interval and p-values. Dashes if undefined."""
    form, of_measure = evidence_form(measure.key), measure.evidence
    x, y = pair[f"{measure.value}_x"], pair[f"{measure.value}_y"]
    return (
        number(x, form),
        number(y, form),
        difference(x, y, form),
        interval_text(pair[f"{of_measure}_low"], pair[f"{of_measure}_high"], form),
        number(pair[f"{of_measure}_p"], ".2g"),
        number(pair[f"{of_measure}_p_holm"], ".2g"),
    )


def system_cells(system: Mapping[Hashable, Any]) -> tuple[str, ...]:
    """Format a row of `systems_of` as cells below `SYSTEM_HEAD`."""
    threshold = system["threshold"]
    return (
        "all scores" if math.isnan(threshold) else f"{threshold:g}",
        number(system["false_alarms_per_frame"], ".3g"),
        number(system["detected"], ".1%"),
        number(system["similarity"], ".4f"),
    )


def pair_text(pair: Mapping[Hashable, Any]) -> str:
    """Say in which measures one system of a pair is better, claiming only what the data support."""
    is_unequal, claims = bool(pair["is_unequal"]), []
    for measure in PAIR_MEASURES:
        if winner := winner_of(pair, measure):
            order = (winner, "y" if winner == "x" else "x")
            best, other = (pair[f"{measure.value}_{letter}"] for letter in order)
            # values are as set, whereas the claim about an unequal pair is at equal false alarms
            values = {} if is_unequal else {"best": best, "other": other}
            p = pair[f"{measure.evidence}_p_holm"]
            claims.append(Note(measure.claim, winner=pair[winner], p=p, **values))
    reasons = dict.fromkeys(note for of in PAIR_MEASURES for note in notes_without_p(pair, of))
    if pair["unit"] not in WHOLE:
        reasons = {f"{MIN_RECORDINGS} recordings are needed for a p": None}
    has_p = any(math.isfinite(pair[f"{of.evidence}_p"]) for of in PAIR_MEASURES)
    note = Note(
        "matrix.pair",
        is_unequal=is_unequal,
        claims=claims,
        withheld=pair["withheld"],
        reasons=[] if has_p else list(reasons),
        alarms=[pair[f"false_alarms_per_frame_{letter}"] for letter in "xy"],
    )
    return phrase(note, PEDESTRIAN)


def notes_without_p(pair: Mapping[Hashable, Any], measure: PairMeasure) -> list[str]:
    """Return why a pair has no p-value in a measure, or an empty list if it has one."""
    is_undefined = math.isnan(pair[f"{measure.evidence}_p"])
    return [note for note in pair[f"{measure.evidence}_note"].split("; ") if note and is_undefined]


def pair_notes(table: pd.DataFrame, measure: PairMeasure) -> tuple[list[str], dict[str, str]]:
    """Return the footnote letters of each pair, and the letter of each note.

    Footnotes say why a pair has no p-value.
    """
    footnotes = Footnotes()
    rows = table.to_dict("records")
    of_pairs = [footnotes.of_row(notes_without_p(row, measure)) for row in rows]
    return of_pairs, footnotes.marks


def render_matrix(table: pd.DataFrame) -> str:
    """Return the systems, a sentence on each pair, and tables of numbers, for the terminal."""
    pairs = table.to_dict("records")
    systems = systems_of(table).to_dict("records")
    lines = [
        f"{count_text(len(systems), 'system')}, {count_text(len(pairs), 'pair')}, "
        f"{count_text(int(table['n_encounters'].iloc[0]), 'encounter')}; "
        "each system at its own threshold",
        "",
        *aligned(
            [("system", *SYSTEM_HEAD), *((row["system"], *system_cells(row)) for row in systems)]
        ),
        "",
        *(f"{pair_name(pair)}: {pair_text(pair)}" for pair in pairs),
    ]
    for measure in PAIR_MEASURES:
        of_pairs, notes = pair_notes(table, measure)
        rows = [
            (
                pair_name(pair),
                *pair_cells(pair, measure),
                "p: at equal false alarms" if pair["is_unequal"] else "",
                marks,
            )
            for pair, marks in zip(pairs, of_pairs, strict=True)
        ]
        lines += ["", *aligned([(measure.title, *HEAD, "", ""), *rows])]
        lines += [f"{mark}: {note}" for note, mark in notes.items()]
    return "\n".join(one_line(line) for line in lines)


def matrix_json(dataset: Dataset, params: Params, table: pd.DataFrame) -> str:
    """Return systems and pairs as JSON text, with null for undefined values.

    Parameters
    ----------
    params
        Settings of the comparison.
    table
        `nvcore.evidence.pairwise.pairwise_table` of the dataset.
    """
    content = {
        "version": __version__,
        "fingerprint": dataset.fingerprint,
        "parameters": replace(params, threshold_x=None, threshold_y=None).stated(dataset),
        "systems": systems_of(table).to_dict("records"),
        "pairs": [{**pair, "text": pair_text(pair)} for pair in table.to_dict("records")],
    }
    return json.dumps(without_nan(content), indent=2, ensure_ascii=False, allow_nan=False) + "\n"


def write_matrix(folder: Path, dataset: Dataset, params: Params, table: pd.DataFrame) -> None:
    """Write `MATRIX_FILES` into a folder, as `nvcore.report.files.write_report` does.

    Raises
    ------
    InputError
        If the folder cannot be written to, or holds the report of a comparison.
    """
    if (folder / "summary.json").exists():  # of which only a part would be replaced
        raise InputError("holds the report of a comparison; give another folder", file=folder)
    refuse_other_run(folder, MATRIX_FILES)
    finite = table.replace([math.inf, -math.inf], math.nan)  # CSV has no infinity
    contents = zip(
        MATRIX_FILES,
        (to_csv_bytes(finite), matrix_json(dataset, params, table).encode()),
        strict=True,
    )
    write_run(folder, contents, known=MATRIX_FILES)
