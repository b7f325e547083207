"""Steps that several commands take: naming and keeping the inputs, comparing, the exit code."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import click

from nvcore.errors import InputError
from nvcore.inputs.session import Session, Source
from nvcore.progress import Progress, no_progress
from nvcore.wording import one_line

if TYPE_CHECKING:
    from nvcore.comparison import Result
    from nvcore.findings import Finding
    from nvcore.inputs.readers.base import Role

# Nothing here imports numpy, pandas or numba before it is called.

EXIT_FINDINGS = 1


def refuse_to_replace(outputs: Iterable[Path], inputs: Iterable[Path]) -> None:
    """A usage error if one of the files to write is also one to read, by whatever name or link.

    Parameters
    ----------
    inputs
        Files; of a folder the pictures in it are meant.
    """
    from nvcore.report.keep_inputs import replaced_input

    clash = replaced_input(outputs, inputs)
    if clash is not None:
        raise click.UsageError(
            one_line(f"{clash} is an input, and would be replaced; give another file to write")
        )


def compare_session(
    session: Session, *, progress: Progress = no_progress
) -> tuple[Result, tuple[Finding, ...]]:
    """The comparison that a session asks for, and what the audit found.

    Parameters
    ----------
    progress
        Of the reading.
    """
    from nvcore.auditing import audit
    from nvcore.comparison import compare
    from nvcore.inputs.load import load

    dataset = load(session, progress=progress)
    findings = audit(dataset)
    return compare(dataset), findings


def exit_on_findings(findings: Iterable[Finding], strict: bool) -> None:
    """Exit with 1 if there are errors; with `strict` also for warnings."""
    bad = {"error", "warning"} if strict else {"error"}
    if any(finding.severity.value in bad for finding in findings):
        raise SystemExit(EXIT_FINDINGS)


@contextmanager
def pasteable_errors(folder: Path, sources: Iterable[tuple[Source, Role]]) -> Iterator[None]:
    """Within it, errors name a file by a path that can be pasted into the terminal."""
    try:
        yield
    except InputError as error:
        from nvcore.inputs.files import path_to_show, paths_to_show

        path = None if error.file is None else paths_to_show(folder, sources).get(error.file)
        if path is None and error.path is not None:  # two inputs have files of this name
            path = path_to_show(error.path)
        if path is None:
            raise
        raise InputError(error.message, file=path, line=error.line) from error


def findings_at_paths(findings: tuple[Finding, ...], paths: dict[str, str]) -> tuple[Finding, ...]:
    """Findings that name their files as `nvcore.inputs.files.paths_to_show` says."""
    return tuple(
        replace(finding, file=paths.get(finding.file, finding.file)) for finding in findings
    )
