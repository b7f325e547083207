"""Whether alerts were worth it: what people say, and how far the kinds of alerts agree with it."""

from __future__ import annotations

from typing import Final, NamedTuple

import numpy as np
import pandas as pd

from nvcore.evidence.bootstrap import MIN_UNITS, SEED, count_units, expanded_tail
from nvcore.inputs.readers.parse.table import parse_table
from nvcore.output.csv_text import to_csv_bytes

ANSWERS: Final = {"yes": "Yes", "no": "No", "unsure": "Cannot say"}
"""Answers to "Was this alert worth it?", in words."""
KINDS: Final = {
    "false": "no",
    "nuisance": "no",
    "redundant": "no",
    "needed": "yes",
    "wanted": "yes",
}
"""Kinds of alerts, with the answer that each lets expect."""
COLUMNS: Final = ("recording", "system", "start_s", "end_s", "kind")
N_RESAMPLES: Final = 2_000


class Alert(NamedTuple):
    """An alert of a system, its times in s since the recording's first frame."""

    recording: str
    system: str
    start_s: float
    end_s: float
    kind: str


def read_alerts(table: pd.DataFrame | bytes, *, name: str = "table") -> list[Alert]:
    """Alerts from a table, or its CSV text, with the columns of `Alert`; others do not matter.

    Raises
    ------
    FormatError
        If a column or field is missing, a time is none, an alert ends before it begins, the kind
        is none of `KINDS`, or an alert is there twice.
    """
    content = table if isinstance(table, bytes) else to_csv_bytes(table)
    text = parse_table(content, name=name, what="alerts", required=COLUMNS)
    start_s, end_s = (text.numbers(column, low=0) for column in COLUMNS[2:4])
    if (is_wrong := end_s < start_s).any():
        row = int(np.argmax(is_wrong))
        raise text.fault(row, f"the alert ends at {end_s[row]:g} s, before {start_s[row]:g} s")
    kinds = text.texts("kind")
    if (is_unknown := ~np.isin(kinds, [*KINDS])).any():
        row = int(np.argmax(is_unknown))
        raise text.fault(row, f"kind: expected {', '.join(KINDS)}; found {kinds[row]!r}")
    text.unique(COLUMNS[:4], "this alert of {system} in {recording} is there a second time")
    columns = (text.texts("recording"), text.texts("system"), start_s.tolist(), end_s.tolist())
    return [Alert(*row) for row in zip(*columns, kinds, strict=True)]


def agreement_of_kinds(answers: pd.DataFrame) -> pd.DataFrame:
    """How far the kinds of alerts agree with what people say of them.

    A kind agrees with an answer that is the one it lets expect (`KINDS`). Its kappa compares two
    yes-or-no judgements of every alert: that it is of this kind, and that people answer what this
    kind lets expect; that of all kinds compares the answers expected and given.

    Parameters
    ----------
    answers
        ``recording``, ``kind`` and ``answer`` (of `ANSWERS`; unsure ones are counted, and left out
        of shares); ``alert`` tells alerts apart.

    Returns
    -------
    First ``all`` kinds, then each that there is: ``kind``, ``n_alerts``, ``n_answers``,
    ``n_unsure``, ``share`` of the answers that agree, Cohen's ``kappa`` (1: the same, 0: as by
    chance; NaN where both are always the same), each with its 95 % interval ``_low``, ``_high``.

    Notes
    -----
    Intervals are percentiles of 2,000 resamples of the recordings (fixed seed), moved outwards for
    few recordings; none with fewer than eight, or where the value is undefined in some resamples.

    References
    ----------
    Cohen (1960), A coefficient of agreement for nominal scales, Educational and Psychological
    Measurement 20:37.
    """
    kind, answer = (answers[name].to_numpy(dtype=object) for name in ("kind", "answer"))
    recording, names = pd.factorize(answers["recording"])
    n, is_sure = len(names), answer != "unsure"
    expected = np.array([KINDS[of] for of in kind], dtype=object)
    drawn = np.empty((0, n))
    if n >= MIN_UNITS:
        rng = np.random.default_rng(SEED)
        drawn = count_units(rng.integers(0, n, (N_RESAMPLES, n)), n)
    rows = []
    for name in ["all", *(of for of in KINDS if (kind == of).any())]:
        is_kind = np.ones(len(kind), dtype=bool) if name == "all" else kind == name
        says = expected == "yes" if name == "all" else is_kind
        agrees = answer == ("yes" if name == "all" else KINDS[name])
        # sums of each recording: said and answered, said alone, answered alone, neither; and of
        # the answers to this kind, those that agree
        cells = [says & agrees, says & ~agrees, ~says & agrees, ~says & ~agrees]
        cells = [*(cell & is_sure for cell in cells), is_kind & is_sure & (answer == expected)]
        counted = [*cells, is_kind & is_sure]
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
    """Share and kappa from the sums of `agreement_of_kinds`, shape (..., 6)."""
    both, first, second, neither, agreed, asked = np.moveaxis(np.asarray(sums, dtype=float), -1, 0)
    n = both + first + second + neither
    with np.errstate(invalid="ignore", divide="ignore"):
        by_chance = ((both + first) * (both + second) + (neither + first) * (neither + second)) / n
        kappa = (both + neither - by_chance) / (n - by_chance)
        share = agreed / asked
    return share, kappa
