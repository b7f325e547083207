"""Tables of ratings written down as a matrix."""

import pandas as pd


def table(values, system=""):
    """One row for each participant, one column for each clip; NaN is missing."""
    rows = [
        (f"P{i}", f"C{j:03d}", system, value)
        for i, row in enumerate(values)
        for j, value in enumerate(row)
    ]
    return pd.DataFrame(rows, columns=["participant", "clip", "system", "rating"])
