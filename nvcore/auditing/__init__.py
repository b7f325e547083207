"""Audit of the inputs: errors and suspicious data, found before scoring."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from functools import partial
from itertools import chain
from typing import TYPE_CHECKING, Any

import numpy as np

from nvcore.auditing.agreement import (
    audit_same_as_truth,
    audit_same_systems,
    find_disagreement,
    find_ignored,
    find_loose,
    find_repeated,
    find_unlisted,
)
from nvcore.auditing.boxes import audit_doubles, audit_geometry, audit_tracks
from nvcore.auditing.cases import BoxSource, system_source, truth_source
from nvcore.auditing.closing import audit_closing_speed
from nvcore.auditing.comparability import (
    audit_borrowing,
    audit_encounter_lengths,
    audit_operating_points,
    audit_weighting,
)
from nvcore.auditing.copies import audit_copies, audit_pieces
from nvcore.auditing.coverage import audit_system_coverage, audit_truth_coverage
from nvcore.auditing.perspective import audit_foot_spread
from nvcore.auditing.recordings import (
    audit_fps,
    audit_frame_list,
    audit_frame_steps,
    audit_kitti_size,
    audit_size,
)
from nvcore.auditing.rows import audit_left_out
from nvcore.auditing.scores import audit_scores, audit_threshold
from nvcore.auditing.transform_findings import (
    EXPLAINED,
    audit_no_match,
    audit_transform,
    audit_truth_layout,
)
from nvcore.auditing.transforms import above_threshold
from nvcore.common.errors import MissingExtraError
from nvcore.common.findings import OF_PICTURES, Finding, Severity, accepted, worst_first
from nvcore.common.subject import subjects
from nvcore.dataset import Dataset
from nvcore.inputs.session import Session
from nvcore.metrics.matching import match_system
from nvcore.settings.params import Params
from nvcore.settings.stages import MATCH, PROXIMITY, THRESHOLD

if TYPE_CHECKING:
    from nvcore.pictures import RecordingPictures


def audit(
    dataset: Dataset, params: Params | None = None, *, x: str | None = None, y: str | None = None
) -> tuple[Finding, ...]:
    """Find everything that is wrong or suspicious in the inputs, worst first.

    All systems are checked. Disagreement with the truth is only checked for X and Y, with their
    thresholds.

    Parameters
    ----------
    dataset
        Recordings, ground truth, systems.
    params
        Settings; None: those of the dataset. Only thresholds, matching, proximity, distance and the
        assumed speed matter here.
    x, y
        Names of the compared systems; None: those of the dataset, or else the first other system.

    Returns
    -------
    findings
        Findings of readers and loader, and of this audit.

    Raises
    ------
    InputError
        If there is no system of a given name.

    Notes
    -----
    Missing truth or detections give an error finding, not an exception.

    Examples
    --------
    >>> [finding.code for finding in audit(dataset)]  # doctest: +SKIP
    ['duplicate-track', 'time-offset']
    """
    params = dataset.params_of(x, y) if params is None else params
    return audit_in_parts(dataset, params, x, y, lambda _kind, _key, make, **_: make())


def audit_in_parts(
    dataset: Dataset, params: Params, x: str | None, y: str | None, cached: Callable[..., Any]
) -> tuple[Finding, ...]:
    """Run `audit` in parts that each depend on few settings, worst findings first.

    Parameters
    ----------
    cached
        Called with the name of a part, the values it depends on, the function that computes it, and
        `most`, the number of results to keep. It returns that function's result, new or cached.
    """
    names = _compared(dataset, x, y)
    findings = [*cached("audit_inputs", (), lambda: audit_inputs(dataset))]
    for system in dataset.systems:
        key = system, threshold_of(system, names, params)
        n_kept = 2 * len(dataset.systems)
        findings += cached("audit_system", key, partial(audit_system, dataset, *key), most=n_kept)
    of_pair = params.only_for(THRESHOLD, MATCH, PROXIMITY)
    findings += cached(
        "audit_pair", (of_pair, x, y), lambda: audit_pair(dataset, of_pair, x=x, y=y)
    )
    findings += audit_view(dataset, params)
    findings = accepted(findings, dataset.settings.accept)
    # an error about a system's frame numbers explains that its rows have no place
    misnumbered = {
        finding.subject
        for finding in findings
        if finding.severity is Severity.ERROR and finding.code in ("frame-rate", "time-offset")
    }
    return worst_first(
        finding
        for finding in findings
        if finding.subject not in misnumbered or finding.code not in EXPLAINED
    )


def audit_inputs(dataset: Dataset) -> tuple[Finding, ...]:
    """Run the part of `audit` that depends on no setting.

    It covers readers' findings, frames, boxes and scores.
    """
    truth = truth_source(dataset)
    findings = [*audit_left_out(dataset)]
    findings += [*audit_truth_coverage(dataset), *_audit_boxes(truth), *audit_tracks(truth)]
    findings += [*audit_size(dataset), *audit_kitti_size(dataset), *audit_fps(dataset)]
    findings += [
        *audit_frame_list(dataset),
        *audit_frame_steps(dataset),
        *audit_truth_layout(dataset),
    ]
    findings += [*audit_copies(dataset), *audit_pieces(dataset)]
    for system in (system_source(dataset, name) for name in dataset.systems):
        findings += [*audit_system_coverage(system), *_audit_boxes(system), *audit_scores(system)]
        findings += audit_same_as_truth(system)
    for subject in subjects():
        findings += chain(*(check(dataset) for check in subject.checks().inputs))
    return *dataset.findings, *findings


def audit_system(dataset: Dataset, name: str, threshold: float | None) -> tuple[Finding, ...]:
    """Run the part of `audit` that depends on one system's threshold: its effect, and the fit.

    Parameters
    ----------
    name
        Name of the system.
    threshold
        Lowest score that counts; None: every detection counts.
    """
    system = system_source(dataset, name)
    return *audit_threshold(system, threshold), *audit_transform(system, threshold)


def audit_pair(
    dataset: Dataset, params: Params, *, x: str | None = None, y: str | None = None
) -> tuple[Finding, ...]:
    """Run the part of `audit` that depends on both systems, their matching and proximity."""
    names = _compared(dataset, x, y)
    findings = [*audit_encounter_lengths(dataset, params), *audit_borrowing(dataset, params)]
    systems = [system_source(dataset, name) for name in dict.fromkeys(names)]
    thresholds = (params.threshold_x, params.threshold_y)[: len(systems)]
    counting = tuple(
        above_threshold(system.boxes, threshold)
        for system, threshold in zip(systems, thresholds, strict=True)
    )
    of_each = [
        match_system(dataset, system.name, threshold, params)
        for system, threshold in zip(systems, thresholds, strict=True)
    ]
    misread = audit_no_match(dataset, systems, counting, of_each, thresholds)
    findings += misread
    is_blind = bool(misread)  # nothing can be compared with the matches
    for system, matched in zip(systems, of_each, strict=True):
        findings += find_repeated(system, matched)
        findings += [] if is_blind else find_ignored(system, matched)
    if len(systems) < 2:
        return tuple(findings)
    system_x, system_y = systems
    matches = of_each[0], of_each[1]
    findings += audit_same_systems(system_x, system_y, counting)
    findings += audit_weighting(truth_source(dataset), system_x, system_y, matches, params)
    misread += audit_truth_layout(dataset)
    misread += chain(*map(audit_transform, systems, thresholds))
    # misread boxes would all seem to be drawn elsewhere
    is_misread = any(finding.severity is Severity.ERROR for finding in misread)
    if np.any(~dataset.truth.ignore) and not is_misread:
        for system, matched in zip((system_x, system_y), matches, strict=True):
            findings += find_loose(system, matched, params)
        findings += [] if is_blind else find_disagreement(dataset, system_x, system_y, matches)
        findings += [] if is_blind else find_unlisted(system_x, system_y, matches)
        findings += audit_operating_points(system_x, system_y, matches, params)
    return tuple(findings)


def audit_view(dataset: Dataset, params: Params) -> tuple[Finding, ...]:
    """Run the part of `audit` about the drive as seen by the camera, which is always fast."""
    findings = [*audit_foot_spread(dataset, params), *audit_closing_speed(dataset, params)]
    for subject in subjects():
        findings += chain(*(check(dataset, params) for check in subject.checks().view))
    return tuple(findings)


@contextmanager
def opened_pictures(
    dataset: Dataset,
) -> Iterator[tuple[RecordingPictures | None, tuple[Finding, ...]]]:
    """Open the pictures that the dataset's session names, and yield them with the findings on them.

    They are None if the session names none, or if the extra ``report`` is not installed, which is a
    note.
    """
    session = dataset.settings
    has_some = isinstance(session, Session) and any(entry.pictures for entry in session.recordings)
    if not isinstance(session, Session) or not has_some:
        yield None, ()
        return
    try:
        from nvcore.auditing.pictures import audit_pictures
        from nvcore.pictures.recordings import session_pictures
    except MissingExtraError as error:
        message = f"Which picture shows which frame was not looked at: {error}."
        code = f"{OF_PICTURES}not-opened"
        advice = "There is nothing to do for the numbers: no measure depends on pictures."
        yield None, (Finding(Severity.NOTE, code, "pictures", 1, message, advice),)
        return
    opened = session_pictures(session, dataset)
    try:
        yield opened, audit_pictures(dataset, opened)
    finally:
        opened.close()


def picture_findings(dataset: Dataset) -> tuple[Finding, ...]:
    """Open the pictures that the session names, and return the findings on them."""
    with opened_pictures(dataset) as (_, findings):
        return findings


def _audit_boxes(source: BoxSource) -> list[Finding]:
    return [*audit_geometry(source), *audit_doubles(source)]


def threshold_of(system: str, names: Sequence[str | None], params: Params) -> float | None:
    """Return the threshold of a system (that of X if a system is compared with itself)."""
    thresholds = (params.threshold_x, params.threshold_y)
    of_names = zip(names, thresholds, strict=False)
    return next((threshold for name, threshold in of_names if name == system), None)


def _compared(dataset: Dataset, x: str | None, y: str | None) -> list[str]:
    """Return the names of X and Y, fewer if there are not two systems."""
    names = [name for name in dataset.compared(x, y) if name is not None]
    for name in names:
        dataset.system(name)
    return names
