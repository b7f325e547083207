"""The calls of Python users: compare, audit, gate, convert."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from nvcore import comparison
from nvcore.api.comparison import Comparison
from nvcore.api.inputs import (
    Input,
    load,
    objects_named,
    refuse_for_loaded,
    size_from,
    with_choices,
    with_params,
)
from nvcore.arguments import PathLike, Size
from nvcore.auditing import audit as audit_dataset
from nvcore.auditing import picture_findings
from nvcore.dataset import Dataset
from nvcore.errors import ParameterError
from nvcore.findings import Finding, worst_first
from nvcore.inputs.conversion import Conversion
from nvcore.inputs.conversion import convert as convert_input
from nvcore.inputs.pipes import pipes_kept
from nvcore.inputs.readers.base import Role
from nvcore.inputs.session import Session, Source
from nvcore.objects import PEDESTRIAN
from nvcore.protocols import Protocol
from nvcore.report.gate import run_gate
from nvcore.report.gate.measures import measure_names
from nvcore.report.gate.outcomes import Outcome
from nvcore.report.gate.results import terminal_lines
from nvcore.report.gate.rules import read_rules


def compare(
    source: PathLike | Session | Dataset | None = None,
    /,
    *,
    truth: Input | None = None,
    x: Input | None = None,
    y: Input | None = None,
    size: Size | None = None,
    fps: float | None = None,
    frames: str | range | None = None,
    recordings: PathLike | None = None,
    name_x: str | None = None,
    name_y: str | None = None,
    protocol: str | Protocol | None = None,
    objects: str | Sequence[str] | None = None,
    **params: float | str | None,
) -> Comparison:
    """Compare two systems against the ground truth.

    The thresholds, parameters, protocol and choice of X and Y are those of the session, unless
    they are given here.

    Parameters
    ----------
    source
        A session file, a session, or a dataset made by `load`.
    truth, x, y, size, fps, frames, recordings, name_x, name_y, protocol, objects
        See `load`.
    params
        Settings by name, such as ``alpha=0.8`` or ``threshold_x=0.5``: see `nvcore.Params`. A
        threshold of None counts every detection.

    Raises
    ------
    InputError
        If an input cannot be used, or there are fewer than two systems.
    ParameterError
        If there is no such setting, or a value is outside its range.

    Examples
    --------
    >>> result = compare("sample_data/session.toml", alpha=0.8)  # doctest: +SKIP
    >>> print(result)  # doctest: +SKIP
    >>> result = compare(truth=truth, x=x, y=y, size=(1280, 720), fps=30)  # doctest: +SKIP
    """
    facts: dict[str, Any] = {"size": size, "fps": fps, "frames": frames, "recordings": recordings}
    facts |= {"objects": objects}
    inputs = {"truth": truth, "x": x, "y": y, **facts}
    dataset = _dataset(source, inputs, name_x, name_y, protocol)
    return Comparison(comparison.compare(with_params(dataset, params)))


def audit(
    source: PathLike | Session | Dataset | None = None,
    /,
    *,
    truth: Input | None = None,
    x: Input | None = None,
    y: Input | None = None,
    size: Size | None = None,
    fps: float | None = None,
    frames: str | range | None = None,
    recordings: PathLike | None = None,
    name_x: str | None = None,
    name_y: str | None = None,
    objects: str | Sequence[str] | None = None,
    **params: float | str | None,
) -> tuple[Finding, ...]:
    """What is wrong or suspicious in the inputs and pictures, worst first; nothing is scored.

    Parameters
    ----------
    source, truth, x, y, size, fps, frames, recordings, name_x, name_y, objects, params
        See `compare`. One system is enough.

    Raises
    ------
    InputError
        If an input cannot be used.
    ParameterError
        If there is no such setting, or a value is outside its range.

    Examples
    --------
    >>> for finding in audit("sample_data/session.toml"):  # doctest: +SKIP
    ...     print(finding.severity, finding.subject, finding.message)
    """
    facts: dict[str, Any] = {"size": size, "fps": fps, "frames": frames, "recordings": recordings}
    facts |= {"objects": objects}
    inputs = {"truth": truth, "x": x, "y": y, **facts}
    dataset = _dataset(source, inputs, name_x, name_y, None)
    dataset = with_params(dataset, params)
    return worst_first([*audit_dataset(dataset), *picture_findings(dataset)])


def _dataset(
    source: PathLike | Session | Dataset | None,
    inputs: dict[str, Any],
    name_x: str | None,
    name_y: str | None,
    protocol: str | Protocol | None,
) -> Dataset:
    if not isinstance(source, Dataset):
        return load(source, **inputs, name_x=name_x, name_y=name_y, protocol=protocol)
    refuse_for_loaded([name for name, value in inputs.items() if value is not None])
    settings = with_choices(source.settings, name_x, name_y, protocol)
    return source if settings == source.settings else source.with_settings(settings)


@dataclass(frozen=True)
class GateOutcome:
    """Whether a comparison passes its rules; true if all of them hold.

    Attributes
    ----------
    outcomes
        What became of each rule, the audit's included.
    """

    outcomes: tuple[Outcome, ...]

    @property
    def passed(self) -> tuple[Outcome, ...]:
        """The rules that hold."""
        return tuple(outcome for outcome in self.outcomes if outcome.is_passed)

    @property
    def failed(self) -> tuple[Outcome, ...]:
        """The rules that do not."""
        return tuple(outcome for outcome in self.outcomes if not outcome.is_passed)

    @property
    def is_passed(self) -> bool:
        """Whether all rules hold."""
        return not self.failed

    def __bool__(self) -> bool:
        return self.is_passed

    def __str__(self) -> str:
        return "\n".join(terminal_lines(self.outcomes))


def gate(result: Comparison, rules: Iterable[str], *, strict: bool = False) -> GateOutcome:
    """Whether rules such as ``new_misses == 0`` hold, and the audit finds no errors.

    Parameters
    ----------
    rules
        A measure, a comparison and a number each, as of ``nvcore gate``: with the release in use as
        X and the candidate as Y, ``new_misses`` are the encounters that only the first detects.
    strict
        Whether warnings of the audit count as errors do.

    Raises
    ------
    ParameterError
        If a text is no rule, or there is no such measure.

    Examples
    --------
    >>> outcome = gate(result, ["new_misses == 0", "lamr_y <= 10%"])  # doctest: +SKIP
    >>> bool(outcome), outcome.failed[0].message  # doctest: +SKIP
    (False, 'new_misses is 8')
    """
    texts = [rules] if isinstance(rules, str) else list(rules)
    numbered = [(f"rule {number}", text) for number, text in enumerate(texts, 1)]
    parsed, problems = read_rules(numbered, measure_names())
    if problems:
        raise ParameterError("\n".join(problems))
    outcomes, _ = run_gate(parsed, result.result, result.input_findings, strict=strict)
    return GateOutcome(tuple(outcomes))


@pipes_kept()
def convert(
    source: PathLike | Source,
    target: PathLike,
    to: str | None = None,
    *,
    role: Role | None = None,
    truth: PathLike | Source | None = None,
    size: Size | None = None,
    objects: str | Sequence[str] | None = None,
    frames_out: PathLike | None = None,
    force: bool = False,
) -> Conversion:
    """Write any readable input as CSV, Parquet, COCO or MOTChallenge, as ``nvcore convert`` does.

    Parameters
    ----------
    source, truth
        A file, folder or glob, or a `Source` that says how to read it.
    target, to, role, size, objects, frames_out, force
        See `nvcore.inputs.conversion.convert`.

    Returns
    -------
    Conversion
        The files that were written, and in words what they cannot hold.

    Raises
    ------
    InputError
        If a file cannot be read or written, or what the input holds is unclear.

    Examples
    --------
    >>> convert("truth.json", "truth.csv", "csv").files  # doctest: +SKIP
    (PosixPath('truth.csv'),)
    """
    return convert_input(
        source if isinstance(source, Source) else Source(str(source)),
        Path(target),
        to,
        role=role,
        truth=truth if isinstance(truth, Source | None) else Source(str(truth)),
        size=size_from(size),
        objects=objects_named(objects) or PEDESTRIAN,
        frames_out=None if frames_out is None else Path(frames_out),
        force=force,
    )
