"""Steps shared by commands: naming and protecting inputs, comparing, exit codes."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import AbstractContextManager, ExitStack, contextmanager, suppress
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

import click

from nvcore.cli.progress import TerminalProgress
from nvcore.cli.remedies import suggestion_text, ways_text
from nvcore.common.errors import InputError, MissingFactError
from nvcore.common.findings import TRUTH_NAME
from nvcore.common.progress import Progress, no_progress
from nvcore.common.wording import one_line
from nvcore.inputs.session import Session, Source

if TYPE_CHECKING:
    from nvcore.common.findings import Finding
    from nvcore.comparison.compare import Result
    from nvcore.dataset import Dataset
    from nvcore.inputs.readers.base import Role
    from nvcore.inputs.session.proposals import UsualInputs
    from nvcore.settings.defaults import OperatingPoint

# numpy, pandas and numba are imported by the functions only.

EXIT_FINDINGS = 1
Job = TypeVar("Job")


def compare_session(
    session: Session, otherwise: OperatingPoint = "as-set", *, progress: Progress = no_progress
) -> tuple[Result, tuple[Finding, ...]]:
    """Load and compare a session. Return the result and the audit's findings.

    Parameters
    ----------
    otherwise
        Operating point if the session sets none.
    progress
        Progress of reading the inputs.
    """
    from nvcore.auditing import audit
    from nvcore.comparison.compare import compare
    from nvcore.evidence.operating_points import at_operating_point
    from nvcore.inputs.load import load

    dataset = load(session, progress=progress)
    findings = audit(dataset)
    point = session.operating_point or otherwise
    return at_operating_point(compare(dataset), point), findings


def exit_on_findings(findings: Iterable[Finding], strict: bool) -> None:
    """Exit with code 1 if there are errors or, with `strict`, warnings."""
    bad = {"error", "warning"} if strict else {"error"}
    if any(finding.severity.value in bad for finding in findings):
        raise SystemExit(EXIT_FINDINGS)


def as_loaded(session: Session, dataset: Dataset) -> Session:
    """Return the session of the loaded dataset, in which recordings are chosen by their titles."""
    return dataset.settings if isinstance(dataset.settings, Session) else session


@contextmanager
def errors_of(session: Session) -> Iterator[None]:
    """Reword input errors for the terminal: pasteable paths, flags, and values to propose.

    Paths are those of `pasteable_errors`. Missing facts get a proposed value if there is one.
    """
    with pasteable_errors(session.folder, session.sources):
        try:
            yield
        except MissingFactError as error:
            proposal = _proposal(session, error.facts)
            if not proposal:
                raise
            ways = ways_text(error.steps, {}, are_all_needed=error.needs_all_steps)
            message = f"{error.message.rstrip('.')}. {ways} {proposal}"
            raise InputError(message, file=error.file, line=error.line) from error
        except InputError as error:
            from nvcore.inputs.files.find import system_names

            names = [
                source.name or by_path
                for source, by_path in zip(
                    session.systems, system_names(session.systems, ()), strict=True
                )
            ]
            ends = dict(zip([TRUTH_NAME, *names], ("-truth", "-x", "-y"), strict=False))
            ways = ways_text(error.steps, ends)
            if not ways:
                raise
            message = f"{error.message.rstrip('.')}. {ways}"
            worded = InputError(message, file=error.file, line=error.line)
            worded.path = error.path
            raise worded from error


@contextmanager
def job_on(
    session_file: Path | None,
    kind: Callable[..., Any],
    job_of: Callable[..., AbstractContextManager[Job]],
    options: Mapping[str, Any],
) -> Iterator[Job]:
    """Prepare a job over a session with the given flags, and show the progress of reading it.

    Parameters
    ----------
    session_file
        Session file, or None if the job needs no session.
    kind, job_of
        Class of the job's arguments, and the context manager that makes the job from them.
    """
    from nvcore.inputs.session.toml import read_session

    with ExitStack() as stack:
        session, n_steps = None, 2
        if session_file is not None:
            session = read_session(session_file, needs_system=False)
            n_steps += len(session.systems)
            stack.enter_context(errors_of(session))
        with TerminalProgress(n_steps) as steps:
            inputs = [] if session_file is None else [session_file]
            job = job_of(kind(session, **options), inputs=inputs, loading=steps)
            opened = stack.enter_context(job)
        yield opened


def _proposal(session: Session, facts: Iterable[str]) -> str:
    """Return flags for size and frame rate, by the pictures or else as usual in the truth's format.

    Empty if neither is known. The dashboard proposes the same.
    """
    wanted = {"size", "fps"} & set(facts)
    sizes_and_rates = _of_pictures(session) if wanted else None
    if sizes_and_rates is not None:
        name, size, fps = sizes_and_rates
        flags = [f"--size {size[0]}x{size[1]}"] * ("size" in wanted)
        if "fps" in wanted and fps is not None:
            flags.append(f"--fps {fps:g}")
        if flags:
            return one_line(f"The pictures {name} have {' and '.join(flags)}")
    usual = _usual(session) if wanted else None
    if usual is None:
        return ""
    width, height = usual.size
    others = f" (some of its recordings have {usual.others})" if usual.others else ""
    flags = [f"--size {width}x{height}{others}"] * ("size" in wanted)
    if "fps" in wanted and usual.fps is not None:
        flags.append(f"--fps {usual.fps:g}")
    return f"Usual in {usual.name}: {' and '.join(flags)}" if flags else ""


def _of_pictures(session: Session) -> tuple[str, tuple[int, int], float | None] | None:
    """Return path, size (px) and frame rate (1/s) of the first pictures that can be opened."""
    paths = [entry.pictures for entry in session.recordings if entry.pictures is not None]
    with suppress(ImportError):  # without the extra `report` no picture is opened
        from nvcore.pictures.open import open_pictures

        for path in paths:
            with suppress(InputError):
                pictures = open_pictures(session.folder / path)
                try:
                    return path, (pictures.width, pictures.height), pictures.fps
                finally:
                    pictures.close()
    return None


def _usual(session: Session) -> UsualInputs | None:
    """Return size and frame rate of most recordings in the truth's format, or None."""
    from nvcore.inputs.files.find import find_files
    from nvcore.inputs.session.proposals import USUAL_INPUTS

    with suppress(InputError):
        return USUAL_INPUTS.get(find_files(session.truth, session.folder, "truth")[1].name)
    return None


def shown_findings(
    session: Session, dataset: Dataset, findings: tuple[Finding, ...]
) -> tuple[Finding, ...]:
    """Return the findings on the dataset of a session as `findings_shown` words them."""
    path = shown_paths(session.folder, session.sources, dataset.systems)
    return findings_shown(findings, path, dataset.compared())


def check_output_folder(
    out: Path, names: Iterable[str], session: Session, *inputs: Path | None
) -> None:
    """Refuse to write files of these names into a folder of inputs, or over an input.

    An earlier session.toml may be replaced.

    Parameters
    ----------
    inputs
        Files that are read besides those of the session.

    Raises
    ------
    InputError
        If an input would be replaced, or the folder cannot be written to.
    """
    from nvcore.common.output.files import check_folder
    from nvcore.report.files import SESSION_FILE
    from nvcore.report.protect_inputs import files_read, refuse_among_inputs, refuse_to_replace

    names = [*names]
    refuse_among_inputs(out, session)
    check_folder(out, names)
    files = [path for path in inputs if path is not None]
    outputs = (out / name for name in names if name != SESSION_FILE)
    refuse_to_replace(outputs, [*files_read(session), *files])


def say_written(out: Path | None, what: str = "") -> None:
    """Print on the error stream where an output is, if it was written."""
    if out is not None:
        click.echo(one_line(f"{what}written to {out}"), err=True)


@contextmanager
def pasteable_errors(folder: Path, sources: Iterable[tuple[Source, Role]]) -> Iterator[None]:
    """Reword input errors to name a file by a path that can be pasted into the terminal."""
    try:
        yield
    except InputError as error:
        from nvcore.inputs.files.find import path_to_show, paths_to_show

        path = None if error.file is None else paths_to_show(folder, sources).get(error.file)
        if path is None and error.path is not None:  # two inputs have files of this name
            path = path_to_show(error.path)
        if path is None:
            raise
        raise InputError(error.message, file=path, line=error.line, steps=error.steps) from error


ShownPath = Callable[[str, str], str]
"""Function from (``truth`` or a system's name, file name) to a pasteable path, or else the name."""


def shown_paths(
    folder: Path, sources: Iterable[tuple[Source, Role]], systems: Iterable[str] = ()
) -> ShownPath:
    """Return a function that names input files for the terminal, even if two share a name."""
    from nvcore.inputs.files.find import paths_to_show

    of_sources = [paths_to_show(folder, [source]) for source in sources]
    by_subject = dict(zip((TRUTH_NAME, *systems), of_sources, strict=False))

    def shown(subject: str, name: str) -> str:
        of_one = [by_subject[subject]] if subject in by_subject else of_sources
        paths = {paths[name] for paths in of_one if name in paths}
        return paths.pop() if len(paths) == 1 else name

    return shown


def findings_shown(
    findings: tuple[Finding, ...], path: ShownPath, compared: Sequence[str | None] = ()
) -> tuple[Finding, ...]:
    """Reword findings for the terminal: files as in `shown_paths`, with suggested fixes.

    Parameters
    ----------
    compared
        Names of X and Y, whose flags the fixes name.
    """
    letters = reversed([*zip(compared, "xy", strict=False)])  # X wins if both are the same system
    ends = {name: f"-{letter}" for name, letter in letters if name}
    marks = {TRUTH_NAME: "-truth"} | ends if compared else {}
    return tuple(
        replace(
            finding,
            file=path(finding.subject, finding.file),
            advice=f"{finding.advice} {ways}".strip(),
        )
        for finding in findings
        for ways in [f"{ways_text(finding.steps, marks)} {suggestion_text(finding, marks)}".strip()]
    )
