"""Render a comparison of groups as terminal text, as JSON, and as files."""

from __future__ import annotations

import json
import math
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import numpy as np
import pandas as pd

from nvcore import __version__
from nvcore.common.output.csv_text import to_csv_bytes
from nvcore.common.output.files import write_run
from nvcore.common.wording import UNDEFINED, aligned, number, one_line, p_value

if TYPE_CHECKING:
    from nvcore.evidence.groups.comparison import GroupComparison

TABLES: Final = ("groups", "tests", "pairs", "assumptions", "sizes")
FILES: Final = (*(f"{name}.csv" for name in TABLES), "groups.json")
"""Names of the files that `write_groups` writes."""
FITS: Final = ("*", " ")
"""Marks of suitable tests and of other ones."""
TESTS: Final = {
    "anova": "one-way ANOVA",
    "welch": "Welch's ANOVA",
    "kruskal": "Kruskal–Wallis",
    "permutation": "permutation of Welch's F",
    "permutation_ranks": "permutation of ranks",
    "repeated": "repeated measures",
    "repeated_gg": "repeated measures, Greenhouse–Geisser",
    "friedman": "Friedman",
    "within": "exchange within persons, F",
    "within_ranks": "exchange within persons, ranks",
}
"""Overall tests by key."""
PAIR_TESTS: Final = {
    "tukey": "Tukey",
    "games_howell": "Games–Howell",
    "permutation": "permutation of Welch's t",
    "paired": "paired t",
    "exchanged": "exchange within persons",
    "assumed": "paired t, as assumed",
}
"""Comparisons of pairs by key."""
CHECKS: Final = {
    "variance_ratio": "largest variance / smallest",
    "levene": "equal variances (Brown–Forsythe)",
    "shapiro": "normal residuals (Shapiro–Wilk)",
    "sphericity": "sphericity (Greenhouse–Geisser's epsilon)",
}
"""Checks of assumptions by key."""
DESIGNS: Final = {
    "same": "the same persons in all conditions",
    "different": "independent groups",
    "mixed": "some persons in several conditions",
    "unknown": "whether the persons are the same is not known",
}


def amount_form(values: np.ndarray) -> str:
    """Return a number format that shows values of this size with about four digits."""
    largest = float(np.nanmax(np.abs(values), initial=0.0))
    return f".{min(max(0, 3 - math.floor(math.log10(largest))), 9) if largest else 0}f"


def render_groups(comparison: GroupComparison) -> str:
    """Render conclusions and all tables as text, with a star for suitable tests."""
    tables = [aligned(rows) for rows in cells_of(comparison).values()]
    parts = [comparison.sentences, *tables]
    return "\n\n".join("\n".join(map(one_line, lines)) for lines in parts if lines)


def cells_of(comparison: GroupComparison) -> dict[str, list[tuple[str, ...]]]:
    """Return each non-empty table as rows of text. A star marks the tests that suit the data."""
    rows = (_group_rows, _test_rows, _pair_rows, _check_rows, _size_rows)
    return {
        name: [*rows_of(comparison)]
        for name, rows_of in zip(TABLES, rows, strict=True)
        if len(getattr(comparison, name))
    }


def _group_rows(comparison: GroupComparison) -> Iterator[tuple[str, ...]]:
    form = amount_form(comparison.groups["mean"].to_numpy())
    shown = comparison.groups.dropna(axis=1, how="all")
    more = [name for name in ("median", "geometric_mean") if name in shown]
    heads = [name.replace("_", " ") for name in more]
    yield (comparison.measure or "condition", "n", "mean", "SD", "95 % interval", *heads)
    for row in comparison.groups.to_dict("records"):
        amounts = [number(row[name], form) for name in ("mean", "sd", *more)]
        ends = _ends(row["low"], row["high"], form)
        yield (row["condition"], str(row["n"]), *amounts[:2], ends, *amounts[2:])


def _test_rows(comparison: GroupComparison) -> Iterator[tuple[str, ...]]:
    yield ("  test of all", "value", "df", "p", "eta²", "omega²", "f", "ways", "note")
    for row in comparison.tests.to_dict("records"):
        df = [f"{row[name]:.4g}" for name in ("df_between", "df_within") if row[name] > 0]
        ways = f"{row['n_reached']:,} of {row['n_ways']:,}" if row["n_ways"] else ""
        yield (
            f"{FITS[not row['fits']]} {TESTS[row['test']]}",
            f"{row['statistic']} = {row['value']:.4g}" if row["statistic"] else "",
            ", ".join(df),
            _p(row["p"]),
            *(number(row[name], ".3f") for name in ("eta2", "omega2")),
            number(row["f"], ".2f"),
            ways if row["is_exact"] or not ways else f"{ways} random",
            row["reason"],
        )


def _pair_rows(comparison: GroupComparison) -> Iterator[tuple[str, ...]]:
    form = "+" + amount_form(comparison.groups["mean"].to_numpy())
    yield ("  pair", "by", "difference", "95 % interval", "q, t", "df", "p", "p corrected", "d")
    for row in comparison.pairs.to_dict("records"):
        amount = [number(row["difference"], form), _ends(row["low"], row["high"], form)]
        if row["ratio"] > 0:
            ends = _ends(row["ratio_low"], row["ratio_high"], ".2f")
            amount = [f"× {row['ratio']:.2f}", ends]
        yield (
            f"{FITS[not row['fits']]} {row['first']} - {row['second']}",
            PAIR_TESTS[row["test"]],
            *amount,
            *(number(row[name], ".4g") for name in ("value", "df")),
            *(_p(row[name]) for name in ("p", "p_corrected")),
            number(row["d"], ".2f"),
        )


def _check_rows(comparison: GroupComparison) -> Iterator[tuple[str, ...]]:
    yield ("  assumption", "value", "p", "it is")
    for row in comparison.assumptions.to_dict("records"):
        holds = "" if math.isnan(row["holds"]) else "not rejected" if row["holds"] else "rejected"
        yield (f"  {CHECKS[row['check']]}", number(row["value"], ".3g"), _p(row["p"]), holds)


def _size_rows(comparison: GroupComparison) -> Iterator[tuple[str, ...]]:
    where = "persons" if comparison.design == "same" else "n in each group"
    yield ("  a further study of", "effect", "shown at p", where)
    for row in comparison.sizes.to_dict("records"):
        what, letter = ("two conditions", "d") if row["test"] == "t" else ("all conditions", "f")
        effect = f"{letter} = {number(row['effect'], '.2f')}"
        yield f"  {what}", effect, f"{row['level']:.2g}", number(row["n"], ".0f")


def _ends(low: float, high: float, form: str) -> str:
    return UNDEFINED if math.isnan(low) else f"{number(low, form)} to {number(high, form)}"


def _p(p: float) -> str:
    return UNDEFINED if math.isnan(p) else p_value(p)


def groups_json(comparison: GroupComparison) -> str:
    """Serialize sentences and tables as JSON text. null is undefined."""
    content: dict[str, Any] = {
        "version": __version__,
        **{name: getattr(comparison, name) for name in ("measure", "scale", "design")},
        "design_text": DESIGNS[comparison.design],
        **{name: getattr(comparison, name) for name in ("fits", "fits_pairs", "sentences")},
    }
    for name in TABLES:
        table: pd.DataFrame = getattr(comparison, name)
        defined = table.astype(object).where(table.notna(), None)
        content[name] = defined.to_dict("records")
    return json.dumps(content, indent=2, ensure_ascii=False, allow_nan=False) + "\n"


def write_groups(folder: Path, comparison: GroupComparison) -> None:
    """Write `FILES` into a folder, replacing all older ones.

    Raises
    ------
    InputError
        If the folder cannot be written to.
    """
    files = [(f"{name}.csv", to_csv_bytes(getattr(comparison, name))) for name in TABLES]
    files.append(("groups.json", groups_json(comparison).encode()))
    write_run(folder, files, FILES)
