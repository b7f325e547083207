"""KAIST, and the log-average miss rates of systems on it, as published and as measured."""

from __future__ import annotations

from pathlib import Path

from nvcore.dataset import Dataset
from nvcore.inputs.load import load
from nvcore.inputs.session import RecordingEntry, Session, Source, SystemSource

PUBLISHED = {"MBNet": (8.13, 8.28, 7.86), "MLPD": (7.58, 7.95, 6.95), "GAFF": (6.48, 8.35, 3.46)}


MEASURED = {  # not published under this protocol: they hold what we found
    "TCDet-thermal": (21.50, 27.65, 9.34),
    "YOLOv3-visible": (27.46, 20.33, 42.13),
}

SETS = {"day": (("set06", 5), ("set07", 3), ("set08", 3)),
        "night": (("set09", 1), ("set10", 2), ("set11", 2))}  # fmt: skip
"""Sets and their number of recordings."""


def load_kaist(realdata: Path) -> Dataset:
    """The test set with the five systems, its recordings tagged day or night."""
    facts = tuple(
        RecordingEntry(f"{name}/V{number:03}", tags=(tag,))
        for tag, sets in SETS.items()
        for name, n in sets
        for number in range(n)
    )
    systems = tuple(
        SystemSource((f"results/{name}_result.txt",), name=name) for name in PUBLISHED | MEASURED
    )
    truth = Source(("KAIST_annotation.json",))
    return load(Session(realdata / "kaist", truth, systems, facts, fps=20.0))
