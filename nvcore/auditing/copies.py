"""Findings on recordings that are not independent: copies, or pieces of one drive."""

from __future__ import annotations

import re
from collections import defaultdict
from collections.abc import Iterator, Sequence
from typing import Final

from nvcore.common.findings import TRUTH_NAME, Finding, Remedy, Severity, Step
from nvcore.common.wording import count_text, listed, percent
from nvcore.dataset import Dataset
from nvcore.dataset.copies import Copy, open_copies

MOST_NAMED: Final = 3
"""Most pairs or recordings that a message lists."""
_PIECE: Final = re.compile(
    r"(.+?)[ _.-]*(?:part|seq|clip|chunk|split|segment)?[ _.-]*\d{1,4}", re.IGNORECASE
)
LEAST_PIECES: Final = 2


def audit_copies(dataset: Dataset) -> Iterator[Finding]:
    """Report recordings with the same truth, and with nearly the same."""
    copies = open_copies(dataset)
    for severity, code, message, advice, found in (
        (
            Severity.ERROR,
            "copied-recording",
            "Recordings hold the same boxes of the truth",
            "One drive counted twice is no evidence of two: leave one out. If both are meant,",
            [copy for copy in copies if not copy.relation],
        ),
        (
            Severity.WARNING,
            "nearly-copied-recording",
            "Recordings hold nearly the same boxes of the truth",
            "They look like one drive, exported or annotated twice: leave one out. Else",
            [copy for copy in copies if copy.relation],
        ),
    ):
        if found:
            yield Finding(
                severity,
                code,
                TRUTH_NAME,
                len(found),
                f"{message}: {listed(_described(dataset, found))}.",
                f"{advice} give each a unit (the same for two cameras of one drive). Until then "
                "they count as one recording in every test.",
                example=f"recording {dataset.recordings['name'].iloc[found[0].second]}",
                steps=(Step(Remedy.ACCEPT, code, TRUTH_NAME),),
            )


def _described(dataset: Dataset, copies: Sequence[Copy]) -> list[str]:
    """Name the first few pairs of recordings and their relation, and count the others."""
    names = dataset.recordings["name"].to_numpy()
    pairs = []
    for copy in copies[:MOST_NAMED]:
        shift = f", {copy.shift_frames:+,} frames apart" if copy.shift_frames else ""
        relation = f", {copy.relation}" if copy.relation else ""
        n_shared = count_text(copy.n_shared, "box", "boxes")
        extent = f"{n_shared}, {percent(copy.share)} of the smaller"
        pairs.append(f"{names[copy.first]} and {names[copy.second]} ({extent}{relation}{shift})")
    more = len(copies) - len(pairs)
    return [*pairs, count_text(more, "other pair")] if more else pairs


def audit_pieces(dataset: Dataset) -> Iterator[Finding]:
    """Report recordings that look like pieces of one drive by name, if no unit is known."""
    names = dataset.recordings["name"].to_numpy()
    has_unit = dataset.recordings["unit"].to_numpy() != ""
    pieces: dict[str, list[str]] = defaultdict(list)
    for name in names[~has_unit].tolist():  # a loop over recordings: at most thousands
        if piece := _PIECE.fullmatch(name):
            pieces[piece[1]].append(name)
    drives = {stem: parts for stem, parts in pieces.items() if len(parts) >= LEAST_PIECES}
    n = sum(map(len, drives.values()))
    if not drives or (len(drives) == 1 and n == len(names)):
        return  # a consecutively numbered set says nothing about drives
    first = next(iter(drives.values()))
    yield Finding(
        Severity.NOTE,
        "pieces-of-a-drive",
        TRUTH_NAME,
        n,
        f"{count_text(n, 'recording')} may be pieces of {count_text(len(drives), 'drive')}, by "
        f"their names, such as {listed(first, most=MOST_NAMED)}.",
        "Pieces of one drive are not independent. If they are, give them one unit each drive; if "
        "not, there is nothing to do.",
        example=f"recording {first[0]}",
    )
