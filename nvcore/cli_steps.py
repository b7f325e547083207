"""Steps that several commands take: the protocol, the comparison, the exit code."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import TYPE_CHECKING

import click

from nvcore.session import Session

if TYPE_CHECKING:
    from nvcore.analysis import Result
    from nvcore.findings import Finding
    from nvcore.protocols import Protocol

# Nothing here imports numpy, pandas or numba before it is called.

EXIT_FINDINGS = 1


def protocol_named(name: str) -> Protocol:
    """The evaluation protocol of that name; else a usage error that names all."""
    from nvcore.protocols import PROTOCOLS

    if name not in PROTOCOLS:
        raise click.UsageError(f"there is no protocol {name!r}; there are: {', '.join(PROTOCOLS)}")
    return PROTOCOLS[name]


def compare_session(
    session: Session, *, progress: Callable[[str], None] | None = None
) -> tuple[Result, tuple[Finding, ...]]:
    """The comparison that a session asks for, and what the audit found.

    Parameters
    ----------
    progress
        Told what is being read.
    """
    from nvcore.analysis import analyse
    from nvcore.audit import audit
    from nvcore.loading import compared_systems, effective_params, load

    dataset = load(session, progress=progress)
    params = effective_params(session, dataset)
    x, y = compared_systems(session, dataset)
    findings = audit(dataset, params, x=x, y=y)
    return analyse(dataset, params, x=x, y=y), findings


def exit_on_findings(findings: Iterable[Finding], strict: bool) -> None:
    """Exit with 1 if there are errors; with `strict` also for warnings."""
    bad = {"error", "warning"} if strict else {"error"}
    if any(finding.severity.value in bad for finding in findings):
        raise SystemExit(EXIT_FINDINGS)
