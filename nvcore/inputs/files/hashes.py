"""Hashes of the inputs, which reveal that an input has changed."""

from __future__ import annotations

import hashlib
from collections.abc import Iterable, Mapping, Sequence

from nvcore.common.findings import Finding
from nvcore.dataset import Dataset
from nvcore.inputs.readers.base import warning


def source_hashes(dataset: Dataset) -> dict[str, str]:
    """Return the SHA-256 of each source (truth or system), over the hashes of its files."""
    return {
        str(subject): source_hash(group)
        for subject, group in dataset.inputs.groupby("subject", sort=False)["sha256"]
    }


def source_hash(digests: Iterable[str]) -> str:
    """Return the SHA-256 over the hashes of files."""
    return hashlib.sha256("\n".join(digests).encode()).hexdigest()


def changed_input(
    subject: str, files: Sequence[str], digests: list[str], hashes: Mapping[str, str]
) -> list[Finding]:
    """Warn if a source has changed since the session was written.

    Parameters
    ----------
    files
        Names of the source's files.
    digests
        Hashes of the files.
    hashes
        Hashes of all sources at that time, by subject (see `source_hashes`).
    """
    before = hashes.get(subject)
    if before is None or before == source_hash(digests):
        return []
    which = "" if len(files) == 1 else f": one or more of its {len(files):,} files"
    return [
        warning(
            "input-changed",
            len(digests),
            f"The input has changed since the session file was written{which}.",
            "The results will differ from those of then; find out which files are meant.",
            role=subject,
            file=files[0] if len(files) == 1 else "",
        )
    ]
