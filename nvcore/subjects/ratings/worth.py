"""Answers on whether alerts were worth it, and their agreement with the kinds of alerts."""

from __future__ import annotations

from typing import Final, NamedTuple

import numpy as np
import pandas as pd

from nvcore.common.errors import FormatError
from nvcore.common.output.csv_text import to_csv_bytes
from nvcore.comparison.compare import Result
from nvcore.evidence.bootstrap import MIN_UNITS, SEED, count_units, expanded_tail
from nvcore.inputs.readers.parse.table import parse_table
from nvcore.subjects.alerts.episodes import UNWANTED, AlertKind
from nvcore.subjects.alerts.inputs import read_spans

ANSWERS: Final = {"yes": "Yes", "no": "No", "unsure": "Cannot say"}
"""Answers to "Was this alert worth it?", in words."""
EXPECTED: Final = {
    kind.value: "no" if kind in UNWANTED else "yes"
    for kind in AlertKind
    if kind is not AlertKind.IGNORED
}
"""Expected answer for each kind of alert."""
N_RESAMPLES: Final = 2_000


class Alert(NamedTuple):
    """Alert of a system, with times in s since the recording's first listed frame."""

    recording: str
    system: str
    start_s: float
    end_s: float
    kind: str


def read_alerts(table: pd.DataFrame | bytes, result: Result, *, name: str = "table") -> list[Alert]:
    """Read alerts of a comparison from a table such as ``alerts.csv`` (docs/alerts.md), or its CSV.

    Ignored alerts are left out. Alerts of one system that begin and end together reach the driver
    as one, so there is one question about them, with the last of their kinds in the order of
    `EXPECTED`.

    Parameters
    ----------
    table
        Table with recording, system (``x`` or ``y``, or its name), start_s, duration_s or end_s,
        kind. Other columns are ignored. With end_s, a system's name takes priority over a letter.

    Raises
    ------
    FormatError
        If a column or field is missing, a time is invalid, an alert ends before it begins, the kind
        is not an `AlertKind`, or the comparison has no such recording, system or time.
    """
    content = table if isinstance(table, bytes) else to_csv_bytes(table)
    required = ("recording", "system", "start_s", "kind")
    text = parse_table(content, name=name, what="alerts", required=required)
    last = next((column for column in ("end_s", "duration_s") if column in text), None)
    if last is None:
        raise FormatError("a table of alerts needs end_s or duration_s", file=name, line=1)
    letters = {letter: system.name for letter, system in result.sides}
    names = {system: system for system in letters.values()}
    spans = read_spans(text, result.dataset, end=last)
    alerts = spans.assign(
        recording=text.texts("recording"),
        system=pd.Series(text.texts("system"), dtype=object).map(
            letters | names if last == "end_s" else names | letters
        ),
        kind=text.texts("kind"),
    )[[*Alert._fields]]
    for is_right, column, expected in (
        (alerts["kind"].isin([*AlertKind]), "kind", ", ".join(AlertKind)),
        (alerts["system"].notna(), "system", f"x, y, {' or '.join(names)}"),
    ):
        if not is_right.all():
            at = int(np.argmin(is_right))
            found = f"expected {expected}; found {text.fields[column][at]!r}"
            raise text.fault(at, f"{column}: {found}")
    alerts = alerts[alerts["kind"] != AlertKind.IGNORED]
    by_kind = alerts["kind"].map([*EXPECTED].index).sort_values(kind="stable").index
    alerts = alerts.loc[by_kind].drop_duplicates([*Alert._fields[:-1]], keep="last").sort_index()
    return [Alert(*of) for of in alerts.itertuples(index=False, name=None)]


def agreement_of_kinds(answers: pd.DataFrame) -> pd.DataFrame:
    """Measure how far the kinds of alerts agree with people's answers.

    The ``share`` of a kind is over the answers to its alerts. Its kappa also uses the answers to
    all alerts with the other expected answer (`EXPECTED`): it measures how well people distinguish
    this kind from those. With alerts of only one kind there is nothing to distinguish.

    Parameters
    ----------
    answers
        ``recording``, ``kind`` and ``answer`` (of `ANSWERS`; unsure ones are counted, but left out
        of shares); ``alert`` identifies alerts.

    Returns
    -------
    First ``all`` kinds, then each existing kind: ``kind``, ``n_alerts``, ``n_answers``,
    ``n_unsure``, ``share`` of the answers that are as expected, Cohen's ``kappa`` of expected and
    given answers (1: the same, 0: as by chance; NaN where both are always the same), each with its
    95 % interval ``_low``, ``_high``.

    Notes
    -----
    Intervals are percentiles of 2,000 resamples of the recordings (fixed seed), moved outwards for
    few recordings; none with fewer than eight, or where the value is undefined in some resamples.

    References
    ----------
    Cohen (1960), A coefficient of agreement for nominal scales, Educational and Psychological
    Measurement 20:37.
    """
    kind = answers["kind"].to_numpy(dtype=object)
    recording, names = pd.factorize(answers["recording"])
    n, is_sure = len(names), (answers["answer"] != "unsure").to_numpy()
    is_yes = (answers["answer"] == "yes").to_numpy()
    expects_yes = (answers["kind"].map(EXPECTED) == "yes").to_numpy()
    drawn = np.empty((0, n))
    if n >= MIN_UNITS:
        rng = np.random.default_rng(SEED)
        drawn = count_units(rng.integers(0, n, (N_RESAMPLES, n)), n)
    rows = []
    for name in ["all", *(of for of in EXPECTED if (kind == of).any())]:
        is_kind = (kind == name) | (name == "all")
        is_compared = is_sure & (is_kind | (expects_yes != (EXPECTED.get(name) == "yes")))
        # answers of each recording: yes expected and given, expected alone, given alone, neither;
        # of the kind those as expected, and all
        counted = [
            *(is_compared & (expects_yes == a) & (is_yes == b) for a in (1, 0) for b in (1, 0)),
            *(is_kind & is_sure & (expects_yes == is_yes), is_kind & is_sure),
        ]
        sums = np.array([np.bincount(recording[of], minlength=n) for of in counted]).T
        row = {
            "kind": name,
            "n_alerts": answers.loc[is_kind, "alert"].nunique(),
            "n_answers": int((is_kind & is_sure).sum()),
            "n_unsure": int((is_kind & ~is_sure).sum()),
        }
        values, resampled = _agree(sums.sum(axis=0)), _agree(drawn @ sums)
        for of, value, draws in zip(("share", "kappa"), values, resampled, strict=True):
            ends = [np.nan, np.nan]
            if len(draws) and np.isfinite(draws).all():
                ends = np.quantile(draws, [tail := expanded_tail(n), 1 - tail]).tolist()
            row |= {of: float(value), f"{of}_low": ends[0], f"{of}_high": ends[1]}
        rows.append(row)
    return pd.DataFrame(rows)


def _agree(sums: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return share and kappa from the sums of `agreement_of_kinds`, shape (..., 6)."""
    both, first, second, neither, agreed, asked = np.moveaxis(np.asarray(sums, dtype=float), -1, 0)
    n = both + first + second + neither
    with np.errstate(invalid="ignore", divide="ignore"):
        by_chance = ((both + first) * (both + second) + (neither + first) * (neither + second)) / n
        kappa = (both + neither - by_chance) / (n - by_chance)
        share = agreed / asked
    return share, kappa
