"""Inputs of a session other than truth and systems, such as files that subjects add."""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import pandas as pd

from nvcore.inputs.files.hashes import changed_input

if TYPE_CHECKING:
    from nvcore.common.findings import Finding
    from nvcore.dataset import Dataset
    from nvcore.inputs.session import Session


@dataclass(frozen=True)
class Input:
    """Kind of input files other than truth and systems, such as files of a subject.

    Attributes
    ----------
    name
        Name in `Dataset.inputs`. A system may not have this name if a session has such files.
    is_named
        Function that tells whether a session names such files.
    join
        Function that adds the content of the files to a dataset, if the session names them.
    may_be_found
        Whether the systems' own files may hold it, too. Then `join` looks there.

    Raises
    ------
    InputError
        By `join`, if a file cannot be used, with file and line.
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
    """Change fields of the dataset by files of a session, and list the files as its inputs.

    Parameters
    ----------
    subject, files, digests
        Common name of the files, their own names, and their sha256.
    says
        Content of the files as bytes, for the dataset's fingerprint.
    conversion, form
        Description of the conversion and format of the files, one for all or one for each.
    findings
        Findings about the files. One about changed files is added.
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
