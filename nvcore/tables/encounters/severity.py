"""Encounters by the weight of their failures."""

from __future__ import annotations

import numpy as np
import pandas as pd

from nvcore.comparison.compare import Result
from nvcore.dataset.schema import Category
from nvcore.tables.moments import encounter_moments
from nvcore.tables.result import encounters_table


def weighed_encounters(result: Result) -> pd.DataFrame:
    """Return the encounters that count, those with the heaviest failure first.

    Returns
    -------
    `nvcore.tables.result.encounters_table` without the distant ones, its index being the row in
    ``result.encounters``, and: severity_s, the larger of X's and Y's; shown_row, the row in the
    frames table that is worth opening (from `nvcore.tables.moments.encounter_moments`). Equal
    severities, such as 0, are in the order of the table.
    """
    table = encounters_table(result)
    of_both = table[["severity_s_x", "severity_s_y"]]
    table = table.assign(
        severity_s=of_both.max(axis=1), shown_row=encounter_moments(result)["shown_row"]
    )
    table = table[table["category"] != Category.DISTANT.value]
    return table.iloc[np.argsort(-table["severity_s"].to_numpy(), kind="stable")]
