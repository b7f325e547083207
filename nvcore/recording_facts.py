"""Size, frame rate and horizon of every recording: from the data, the session, or flags."""

from __future__ import annotations

import numpy as np
import pandas as pd

from nvcore.errors import InputError, MissingFactError
from nvcore.findings import Finding, Severity
from nvcore.readers.base import Reading
from nvcore.session import Session


def contradicted_facts(truth: Reading, recordings: pd.DataFrame) -> list[Finding]:
    """Sizes and frame rates that were given although the data say something else."""
    stated = truth.recordings.set_index("name").reindex(recordings["name"])
    findings = []
    for columns, what, flag in (
        (["width", "height"], "image size", "--size"),
        (["fps"], "frame rate", "--fps"),
    ):
        ours, theirs = recordings[columns].to_numpy(), stated[columns].to_numpy(dtype=float)
        differs = (np.isfinite(theirs) & (ours != theirs)).any(axis=1)
        if not differs.any():
            continue
        first = int(np.argmax(differs))
        given, said = ("x".join(f"{v:g}" for v in row[first]) for row in (ours, theirs))
        findings.append(
            Finding(
                Severity.WARNING, "contradicted-fact", "truth", int(np.count_nonzero(differs)),
                f"The {what} given ({given}) is not that of the data ({said}).",
                f"Leave {flag} away (or the value in the session file) where the data hold it.",
                example=f"recording {recordings['name'].iloc[first]}",
            )
        )  # fmt: skip
    return findings


def describe_recordings(session: Session, truth: Reading) -> pd.DataFrame:
    """Name, width, height, fps, horizon of every recording; what is unknown is an error."""
    table = truth.recordings.copy()
    facts = {one.name: one for one in session.recordings}
    if len(table) == 1 and len(facts) == 1 and table["name"][0] not in facts:
        # one recording here and there: the session names it
        facts = {table["name"][0]: next(iter(facts.values()))}
    known = set(table["name"])
    more = [name for name in facts if name not in known]
    if more:
        extra = pd.DataFrame({"name": more, "width": np.nan, "height": np.nan, "fps": np.nan})
        table = pd.concat([table, extra], ignore_index=True)
    if table.empty:
        raise InputError("the ground truth holds no recording", file=session.truth.path[0])
    table["horizon"] = np.nan
    for row, name in enumerate(table["name"]):  # a loop over recordings: hundreds at the most
        one = facts.get(name)
        for column in ("width", "height", "fps", "horizon"):
            value = None if one is None else getattr(one, column)
            if value is not None:
                table.loc[row, column] = value
    width, height = session.size or (None, None)
    for column, common in (("width", width), ("height", height), ("fps", session.fps)):
        if common is not None:
            own = {name for name, one in facts.items() if getattr(one, column) is not None}
            table.loc[~table["name"].isin(own), column] = common
    for column, what, flag in (
        ("width", "image size", "--size WIDTHxHEIGHT"),
        ("height", "image size", "--size WIDTHxHEIGHT"),
        ("fps", "frame rate", "--fps"),
    ):
        unknown = table["name"][~(table[column] > 0)]
        if len(unknown):
            others = f" (nor that of {len(unknown) - 1} more)" if len(unknown) > 1 else ""
            raise MissingFactError(
                f"the {what} of recording {unknown.iloc[0]!r} is not in the data{others}; give "
                f"{flag}, or {column} in the session file"
            )
    return table
