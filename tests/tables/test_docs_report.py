"""docs/report.md describes the files of a report as they are.

``make docs`` writes the tables of the page anew.
"""

from __future__ import annotations

import io
import json
import re
from dataclasses import replace
from itertools import chain
from typing import Any

import numpy as np
import pandas as pd
import pytest
from inputs import drive, session_of
from limits import limits_read
from places import ROOT

from nvcore.common.findings import Cases, Finding, Severity
from nvcore.common.output.csv_text import to_csv_bytes
from nvcore.common.subject import subjects
from nvcore.comparison.compare import compare
from nvcore.dataset.schema import CATEGORY_TEXT, MISS_CLASS_TEXT
from nvcore.evidence.pairwise import pairwise_table
from nvcore.inputs.load import load
from nvcore.report.files import export_files
from nvcore.settings.codes import CodedInterval
from nvcore.settings.objects import PEDESTRIAN
from nvcore.settings.params import Params
from nvcore.subjects.driver.comparison.judging import DRIVER_REGION_TEXT
from nvcore.tables.boxes.matches import MATCH_COLUMNS, MATCHES
from nvcore.tables.classes import classes_table
from nvcore.tables.column import CellKind, Column, added_columns
from nvcore.tables.columns import report_columns
from nvcore.tables.columns.evidence import MATRIX_COLUMNS
from nvcore.tables.encounters.changes import CHANGE_COLUMNS, changes_table
from nvcore.tables.result import codes_table
from nvcore.tables.summary import SYSTEM_KEYS, summary_keys

PAGE = ROOT / "docs" / "report.md"
SECTION = re.compile(r"^(#+) (.*?)\n(.*?)(?=^#+ |\Z)", re.DOTALL | re.MULTILINE)
TABLE = re.compile(r"(?:^\|.*\n)+", re.MULTILINE)
MATRIX = "matrix.csv"
CHANGES = "changes.csv"
OF_OTHERS = {MATRIX: MATRIX_COLUMNS, CHANGES: CHANGE_COLUMNS}
"""Files of other commands."""
TABLES = {**report_columns(), MATCHES: MATCH_COLUMNS, **OF_OTHERS}
COLUMNS = {**TABLES, "summary.json": summary_keys(), "Each system": SYSTEM_KEYS}
VALUES = {
    "The column category": CATEGORY_TEXT,
    "The column miss_class": MISS_CLASS_TEXT,
    "The column driver_region": DRIVER_REGION_TEXT,
}
SYSTEMS = ("x", "y", "fusion.x_or_y", "fusion.x_and_y")
FINDINGS = (
    Finding(
        Severity.ERROR,
        "no-area",
        "truth",
        3,
        "What.",
        "Do.",
        "gt.txt",
        "line 4",
        cases=Cases("boxes", np.arange(3)),
    ),
    Finding(Severity.NOTE, "constant-score", "fir", 1, "What.", "Do."),
)


@pytest.fixture(scope="module")
def report(tmp_path_factory: pytest.TempPathFactory) -> dict[str, bytes]:
    """The files of a small comparison: FIR sees both pedestrians, NIR only one."""
    session = session_of(drive(tmp_path_factory.mktemp("drive")))
    truth = session.folder / "truth.csv"
    # a box of 2 px: a distant pedestrian; and the driver sees every second one
    head, *lines = [*truth.read_text(encoding="utf-8").splitlines(), "rural,3,50,200,1,2,9"]
    seen = [f"{line},0.{i % 2}5" for i, line in enumerate(lines)]
    truth.write_text("\n".join([f"{head},detectability", *seen, ""]), encoding="utf-8")
    session = replace(session, params=Params(alerts="policy"))
    dataset = load(session)
    files = {
        name: make()
        for name, make in export_files(compare(dataset), session, FINDINGS, matches=True).items()
    }
    place = [*files].index(MATCHES)  # the drive is of pedestrians, who have no classes
    files = {
        **dict([*files.items()][:place]),
        "classes.csv": to_csv_bytes(classes_table(limits_read())),
        "codes.csv": to_csv_bytes(codes_table([CodedInterval("rural", 0.0, 0.5, "glare")])),
        **dict([*files.items()][place:]),
    }
    return files | {
        MATRIX: to_csv_bytes(pairwise_table(dataset).replace(np.inf, np.nan)),
        CHANGES: to_csv_bytes(changes_table(compare(dataset))),
    }


def table_of(report: dict[str, bytes], file: str) -> pd.DataFrame:
    """The file's cells as text."""
    content = report[file]
    if file == MATCHES:
        content = to_csv_bytes(pd.read_parquet(io.BytesIO(content), dtype_backend="numpy_nullable"))
    return pd.read_csv(io.BytesIO(content), dtype=str, keep_default_na=False)


def shown(column: Column, *, name: str = "") -> str:
    cells = (
        name or f"`{column.name}`",
        column.unit or "–",
        column.kind.value,
        column.better or "–",
        PEDESTRIAN.say(column.meaning),
        PEDESTRIAN.say(column.empty or "never")
        + (f"; left out {column.only_if.otherwise}" if column.only_if else ""),
    )
    return "| " + " | ".join(cells) + " |\n"


def expected_table(title: str) -> str:
    """The section's table; the columns of X and Y in one row, as their sentences are the same."""
    if title in VALUES:
        head = "| Value | Meaning |\n|---|---|\n"
        rows = VALUES[title].items()
        return head + "".join(f"| `{value}` | {PEDESTRIAN.say(text)} |\n" for value, text in rows)
    is_json = title not in TABLES
    text = f"| {'Key' if is_json else 'Column'} | Unit | Type | Better | Meaning | "
    text += f"{'Null' if is_json else 'Empty'} |\n|---|---|---|---|---|---|\n"
    names = {column.name for column in COLUMNS[title]}
    for column in COLUMNS[title]:
        stem, _, letter = column.name.rpartition("_")
        if letter == "x" and f"{stem}_y" in names and not is_json:
            text += shown(column, name=f"`{stem}_x`, `{stem}_y`")
        elif not (letter == "y" and f"{stem}_x" in names and not is_json):
            text += shown(column)
    return text


def written_anew() -> str:
    """The page with the tables of today."""

    def section(match: re.Match[str]) -> str:
        hashes, title, body = match.groups()
        if title in COLUMNS or title in VALUES:
            body = TABLE.sub(lambda _: expected_table(title), body, count=1)
        return f"{hashes} {title}\n{body}"

    return SECTION.sub(section, PAGE.read_text(encoding="utf-8"))


def flat(content: dict[str, Any], before: str = "") -> list[str]:
    """Keys in order, nested ones with dots; the parameters and the systems as one key each."""
    keys: list[str] = []
    for key, value in content.items():
        name = f"{before}{key}"
        is_branch = isinstance(value, dict) and name not in ("parameters", *SYSTEMS)
        keys += flat(value, f"{name}.") if is_branch else [name]
    return keys


@pytest.mark.parametrize("title", [*COLUMNS, *VALUES])
def test_the_page_has_the_table_of_the_code(title: str):
    bodies = {match[2]: match[3] for match in SECTION.finditer(PAGE.read_text(encoding="utf-8"))}
    assert TABLE.findall(bodies[title])[0] == expected_table(title)


def test_every_file_of_a_report_has_its_section_in_order(report):
    page = PAGE.read_text(encoding="utf-8")
    files = [name for name in report if name not in OF_OTHERS]
    assert re.findall(r"^## (\w+\.\w+)$", page, re.MULTILINE) == files


@pytest.mark.parametrize("file", TABLES)
def test_a_file_has_exactly_the_documented_columns(report, file: str):
    assert list(table_of(report, file)) == [column.name for column in TABLES[file]]


@pytest.mark.parametrize("file", TABLES)
def test_only_columns_documented_so_have_empty_cells(report, file: str):
    table = table_of(report, file)
    assert len(table)
    may_be_empty = {column.name for column in TABLES[file] if column.empty}
    assert {name for name in table if (table[name] == "").any()} <= may_be_empty


@pytest.mark.parametrize("file", TABLES)
def test_the_cells_are_of_the_documented_type(report, file: str):
    patterns = {
        CellKind.TEXT: r".+",
        CellKind.INTEGER: r"-?\d+",
        CellKind.NUMBER: r"-?\d+(\.\d+)?(e[-+]?\d+)?",
        CellKind.TRUTH_VALUE: r"[01]",
    }
    table = table_of(report, file)
    for column in TABLES[file]:
        cells = table[column.name]
        assert cells[cells != ""].str.fullmatch(patterns[column.kind]).all(), column.name


def test_the_summary_has_exactly_the_documented_keys(report):
    assert flat(json.loads(report["summary.json"])) == [key.name for key in summary_keys()]


@pytest.mark.parametrize("place", SYSTEMS)
def test_each_system_of_the_summary_has_exactly_the_documented_keys(report, place: str):
    system = json.loads(report["summary.json"])
    for key in place.split("."):
        system = system[key]
    assert flat(system) == [key.name for key in SYSTEM_KEYS]


def test_without_detectability_files_are_as_if_there_were_no_driver(tmp_path):
    session = session_of(drive(tmp_path))
    files = export_files(compare(load(session)), session)
    for file, columns in report_columns().items():
        if file in files:
            names = [column.name for column in columns if not column.only_if]
            assert list(table_of({file: files[file]()}, file)) == names
    content = json.loads(files["summary.json"]())
    assert flat(content) == [key.name for key in summary_keys() if not key.only_if]
    assert flat(content["x"]) == [key.name for key in SYSTEM_KEYS if not key.only_if]


def test_only_keys_documented_so_are_null(report):
    content = json.loads(report["summary.json"])
    system = pd.json_normalize(content["fusion"]["x_and_y"]).iloc[0]
    null = {name for name, value in system.items() if value is None}
    assert null <= {key.name for key in SYSTEM_KEYS if key.empty}
    assert {"threshold", "mean_episode_s"} <= null


def test_pandas_keeps_the_miss_class_none_apart_from_an_empty_cell(report):
    table = pd.read_csv(io.BytesIO(report["encounters.csv"])).set_index(["recording", "track"])
    assert table["miss_class_x"].isna().tolist() == [False, False, True]


def test_the_shown_columns_of_systems_are_all_of_x_before_all_of_y():
    added = list(chain(*(subject.tables().columns for subject in subjects())))
    own = [
        columns[: len(columns) - len(added_columns(file))]
        for file, columns in report_columns().items()
    ]
    for columns in (*own, *(part.columns for part in added)):
        letters = [column.name[-1] for column in columns if column.name.endswith(("_x", "_y"))]
        assert letters == sorted(letters)


def test_every_column_is_described_by_a_sentence():
    for column in (column for columns in COLUMNS.values() for column in columns):
        assert column.meaning.endswith("."), column.name
        assert column.better in ("", "high", "low"), column.name
        assert "|" not in column.meaning + column.empty, column.name


if __name__ == "__main__":
    PAGE.write_text(written_anew(), encoding="utf-8")
