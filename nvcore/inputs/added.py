"""What is read of a session beside truth and systems, by the core and by subjects."""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import pandas as pd

from nvcore.inputs.hashes import changed_input

if TYPE_CHECKING:
    from nvcore.dataset import Dataset
    from nvcore.findings import Finding
    from nvcore.inputs.session import Session


@dataclass(frozen=True)
class Input:
    """Files beside those of the truth and the systems, such as those of a subject.

    Attributes
    ----------
    name
        What they are called in `Dataset.inputs`; no system is called so where a session names them.
    is_named
        Whether a session names them.
    join
        The dataset with what they say of it, where the session names them.
    may_be_found
        Whether the systems' own files may hold it, too: `join` looks there.

    Raises
    ------
    InputError
        By `join`, if a file cannot be used; with file and line.
    """

    name: str
    is_named: Callable[[Session], bool]
    join: Callable[[Dataset, Session], Dataset]
    may_be_found: bool = False


def with_files(
    dataset: Dataset,
    session: Session,
    subject: str,
    files: Sequence[str],
    digests: list[str],
    *,
    says: bytes,
    conversion: str | Sequence[str],
    form: str | Sequence[str] = "csv",
    findings: Iterable[Finding] = (),
    **changes: Any,
) -> Dataset:
    """The dataset with changes that files of a session make, and with these among its inputs.

    Parameters
    ----------
    subject, files, digests
        What the files are called together, their names and their sha256.
    says
        What they say of the dataset, for its fingerprint.
    conversion, form
        What was read of the files, and their format; of all or of each.
    findings
        In the files, beside that they have changed since the session was written.
    changes
        Fields of the dataset.
    """
    rows = pd.DataFrame({"file": files, "sha256": digests})
    rows = rows.assign(subject=subject, format=form, conversion=conversion)[list(dataset.inputs)]
    return replace(
        dataset,
        inputs=pd.concat([dataset.inputs, rows], ignore_index=True),
        findings=(
            *dataset.findings,
            *changed_input(subject, files, digests, session.hashes),
            *findings,
        ),
        fingerprint=hashlib.sha256(f"{dataset.fingerprint}\n".encode() + says).hexdigest(),
        **changes,
    )
