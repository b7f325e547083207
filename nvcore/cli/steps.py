"""Steps that several commands take: keeping the inputs, the comparison, the exit code."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING

import click

from nvcore.cli.options import sources_of
from nvcore.errors import InputError
from nvcore.inputs.session import Session, is_frame_range
from nvcore.wording import one_line

if TYPE_CHECKING:
    from nvcore.comparison import Result
    from nvcore.findings import Finding

# Nothing here imports numpy, pandas or numba before it is called.

EXIT_FINDINGS = 1


def refuse_to_replace(outputs: Iterable[Path], inputs: Iterable[Path]) -> None:
    """A usage error if one of the files to write is also one to read, by whatever name or link.

    Parameters
    ----------
    inputs
        Files; of a folder the pictures in it are meant.
    """
    by_path = {file.resolve(): file for file in outputs}
    if not by_path:  # then the inputs need not be looked for
        return
    by_identity = {_identity(path): file for path, file in by_path.items()}
    by_identity.pop(None, None)  # of those that do not exist
    for one in inputs:
        clash = by_path.get(one.resolve()) or by_identity.get(_identity(one))
        if clash is None and one.is_dir():
            clash = next((file for path, file in by_path.items() if _shows(path, one)), None)
        if clash is not None:
            raise click.UsageError(
                one_line(f"{clash} is an input, and would be replaced; give another file to write")
            )


def files_read(session: Session) -> Iterator[Path]:
    """The files that a session makes the program read; folders of pictures as such."""
    from nvcore.inputs.files import find_files

    for source, role in sources_of(session):
        with suppress(InputError):  # told when the files are read
            yield from (file.path for file in find_files(source, session.folder, role)[0])
    for frames in (session.frames, *(one.frames for one in session.recordings)):
        if frames is not None and not is_frame_range(frames):
            yield session.folder / frames
    for one in session.recordings:
        if one.pictures is not None:
            yield session.folder / one.pictures


def _identity(path: Path) -> tuple[int, int] | None:
    try:
        status = path.stat()
    except OSError:
        return None
    return status.st_dev, status.st_ino


def _shows(path: Path, folder: Path) -> bool:
    """Whether the path is a picture in the folder."""
    from nvcore.pictures import IMAGE_SUFFIXES

    return path.suffix.lower() in IMAGE_SUFFIXES and path.is_relative_to(folder.resolve())


def compare_session(
    session: Session, *, progress: Callable[[str], None] | None = None
) -> tuple[Result, tuple[Finding, ...]]:
    """The comparison that a session asks for, and what the audit found.

    Parameters
    ----------
    progress
        Told what is being read.
    """
    from nvcore.audit import audit
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
