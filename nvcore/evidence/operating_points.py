"""Operating points of X and Y, and the comparison at equal false alarms.

A lower threshold gives more detections and more false alarms. Therefore claims are never based on a
comparison at unequal operating points, but on the comparison at equal false alarms.
"""

from __future__ import annotations

import weakref
from collections.abc import Mapping
from dataclasses import replace
from typing import Any, Final, Literal

from nvcore.comparison.compare import Result, compare
from nvcore.comparison.measures.table import inference_of
from nvcore.comparison.scoring import SystemResult
from nvcore.metrics.detection.operating_point import (
    are_unequal_alarms,
    choose_moved,
    span_of_scores,
    threshold_with_alarms,
)
from nvcore.notes import Note
from nvcore.settings.defaults import DELIVERED, OperatingPoint

AS_SET: Final = "as set: at unequal operating points"
"""Label of numbers of X and Y from which nothing is claimed."""
SETTLED: Final = "score-floors"
"""Code of the finding that a comparison at equal false alarms resolves."""


def count_alarms(system: SystemResult) -> int:
    """Return the number of false alarms of a system, 0 is best."""
    return int(system.false_alarms.sum())


def are_delivered(result: Result) -> bool:
    """Return whether the thresholds are fixed, and claims are about these."""
    return result.dataset.settings.operating_point == DELIVERED


def are_unequal(result: Result) -> bool:
    """Return whether X and Y have different operating points, judged by their false alarms.

    Delivered thresholds are compared as they are.
    """
    if are_delivered(result):
        return False
    n_x, n_y = (count_alarms(system) for _, system in result.sides)
    return are_unequal_alarms(n_x, n_y)


def alarms_as_set(result: Result) -> Note:
    """Return a note on the false alarms per frame of X and Y, for use in other notes."""
    n_frames = max(len(result.dataset.frames), 1)
    x, y = (count_alarms(system) / n_frames for _, system in result.sides)
    return Note("verdict.unequal_alarms", x=x, y=y)


def point_note(result: Result) -> Note | None:
    """Return a heading for numbers at unequal or equalised operating points, or None."""
    if result.as_set is not None:
        return Note("verdict.equal_above", setting=equal_setting(result))
    if not are_unequal(result):
        return None
    return Note("verdict.unequal_above", alarms=alarms_as_set(result))


def is_undecided(result: Result, key: str) -> bool:
    """Return whether unequal operating points forbid conclusions from a measure of `EVIDENCE_KEYS`.

    Detection curves run over all thresholds, so their measures do not depend on those in use.
    """
    return inference_of(key).test != "curve" and are_unequal(result)


def has_scores(result: Result, letter: str) -> bool:
    """Return whether a system's scores differ, so that a threshold can change its detections."""
    return span_of_scores(result.dataset, result.system(letter).name) is not None


def find_equal_alarms(result: Result, previous: Result | None = None) -> Result | None:
    """Return the comparison with one threshold moved so that false alarms are equal, or None.

    The threshold is the lowest round one. `Result.as_set` is the original comparison.

    Parameters
    ----------
    previous
        Earlier result for other settings, to reuse its stages.
    """
    # not cached itself: it holds the result, so neither would ever be freed
    cache: dict[str, weakref.ref[Result] | None] = result.keep("equal_alarms", dict)
    if "found" in cache and cache["found"] is None:
        return None
    known = cache.get("found")
    equal = known() if known is not None else None
    if equal is None:
        equal = _find_equal_alarms(result, previous)
        cache["found"] = None if equal is None else weakref.ref(equal)
    return equal


def can_be_equal(result: Result) -> bool:
    """Return whether `find_equal_alarms` finds a comparison."""
    cache: dict[str, weakref.ref[Result] | None] = result.keep("equal_alarms", dict)
    if "found" not in cache:
        find_equal_alarms(result)
    return cache["found"] is not None


def _find_equal_alarms(result: Result, previous: Result | None) -> Result | None:
    moved = which_moves(result)
    if not moved:
        return None
    before = None if previous is None else previous.as_set
    if (
        previous is not None
        and before is not None
        and all(result.system(of).matches is before.system(of).matches for of in "xy")
    ):
        threshold = previous.system(moved).threshold
    else:
        n_target = count_alarms(result.y if moved == "x" else result.x)
        threshold = threshold_for(result, moved, n_target, "round")
    source = result
    if previous is not None:
        source = replace(result, stages={**previous.stages, **result.stages})
    equal = with_thresholds(source, {f"threshold_{moved}": threshold})
    if are_unequal(equal):
        return None
    return replace(equal, as_set=result, stages={**result.stages, **equal.stages})


def at_operating_point(
    result: Result, point: OperatingPoint, previous: Result | None = None
) -> Result:
    """Return the comparison as set, or at equal false alarms.

    It is as set if X and Y have equal operating points, or no threshold gives them equal ones.

    Parameters
    ----------
    previous
        See `find_equal_alarms`.
    """
    if point != "equal-alarms" or not are_unequal(result):
        return result
    return find_equal_alarms(result, previous) or result


def moved_of(equal: Result) -> str:
    """Return the system, ``x`` or ``y``, whose threshold `find_equal_alarms` moved."""
    assert equal.as_set is not None
    return which_moves(equal.as_set)


def equal_setting(equal: Result) -> Note:
    """Return a note on the threshold with which `find_equal_alarms` equalised X and Y."""
    moved = moved_of(equal)
    per_frame = count_alarms(equal.x) / max(len(equal.dataset.frames), 1)
    threshold = equal.system(moved).threshold
    return Note("verdict.equal_setting", moved=moved, threshold=threshold, per_frame=per_frame)


def which_moves(result: Result) -> str:
    """Return the system whose threshold is moved to equalise false alarms, or an empty text."""
    systems = [system for _, system in result.sides]
    index = choose_moved(
        [has_scores(result, letter) for letter, _ in result.sides],
        [count_alarms(system) for system in systems],
        [int(system.n_det.sum()) for system in systems],
    )
    return "" if index is None else "xy"[index]


def why_not_equal(result: Result) -> str:
    """Return why `find_equal_alarms` finds no comparison."""
    if not which_moves(result):
        return "neither has scores that differ, so that no threshold sets the two alike"
    return "no threshold gives the two equally many false alarms"


def threshold_for(
    result: Result, letter: str, n_alarms: int, end: Literal["round", "lowest", "highest"]
) -> float | None:
    """Return a threshold that gives `n_alarms` false alarms, see `threshold_with_alarms`."""
    name = result.system(letter).name
    return threshold_with_alarms(result.dataset, name, result.params, n_alarms, end=end)


def with_thresholds(result: Result, thresholds: Mapping[str, float | None]) -> Result:
    """Repeat a comparison with other thresholds, reusing its stages."""
    changed: dict[str, Any] = dict(thresholds)
    params = replace(result.params, **changed)
    return compare(result.dataset, params, x=result.x.name, y=result.y.name, previous=result)
