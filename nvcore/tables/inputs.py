"""Tables of the inputs: one row per source, and the rows that could not be placed."""

from __future__ import annotations

import numpy as np
import pandas as pd

from nvcore.dataset import Dataset


def inputs_table(dataset: Dataset) -> pd.DataFrame:
    """From what each source was read, and how.

    Returns
    -------
    One row per source, in the order of ``boxes.source``: the truth, then the systems. Columns:
    subject ("truth" or the system's name), first_file (its name), n_files, format, conversion (in
    words), n_boxes (placed boxes, those to be ignored too). No rows for data made in memory.
    """
    source, subjects = pd.factorize(dataset.inputs["subject"])
    first = dataset.inputs.drop_duplicates("subject", ignore_index=True)
    n_boxes = np.bincount(dataset.boxes["source"], minlength=len(subjects))
    return pd.DataFrame(
        {
            "subject": first["subject"],
            "first_file": first["file"],
            "n_files": np.bincount(source, minlength=len(subjects)),
            "format": first["format"],
            "conversion": first["conversion"],
            "n_boxes": n_boxes[: len(subjects)],
        }
    )


def left_out_table(dataset: Dataset) -> pd.DataFrame:
    """How many rows of which source could not be placed: columns subject, reason, n_rows."""
    counts = dataset.left_out.groupby(["subject", "reason"], sort=False).size()
    return counts.rename("n_rows").reset_index()
