"""Notes on whom the driver sees and whom each system warns of."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any, Final

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from nvcore.common.wording import listed, one_line, shortened
from nvcore.comparison.compare import Result
from nvcore.comparison.measures.entry import Measure
from nvcore.notes import Note, phrase
from nvcore.subjects.driver.comparison.in_time import (
    count_in_time,
    is_judged_in_time,
    is_seen_too_late,
)
from nvcore.subjects.driver.comparison.judging import SELDOM, DriverRegion, is_unknown
from nvcore.subjects.driver.comparison.settings import DRIVER
from nvcore.subjects.driver.comparison.steps import driver_in
from nvcore.subjects.driver.inputs.record import EstimateRecord
from nvcore.subjects.time_left.steps import time_left_in

MOST_OUTSIDE: Final = 0.5
"""No claims are made if at least this share of encounters is decided outside the training range.

(Our choice.)
"""
SMALL_SHARE: Final = 0.05
"""Doubts about at most this share of the estimates are not mentioned. (Our choice.)"""
_MOST_NAMED: Final = 3
_SHOWN_NAME: Final = 40


def driver_notes(result: Result) -> tuple[Note, ...]:
    """Return notes on whom the driver sees and whom each system warns of."""
    return (*no_claim(result), *view_notes(result))


def view_notes(result: Result) -> tuple[Note, ...]:
    """Return `driver_notes` without the note that nothing is claimed."""
    if driver_in(result).has_any:
        return (*_seen(result), *source(result), *_estimated(result))
    return (Note("driver.nothing_known"),) if result.dataset.has_detectability else ()


def _seen(result: Result) -> Iterator[Note]:
    """Yield notes on which encounters the driver sees, and when."""
    driver = driver_in(result)
    yield seen_unaided(result)
    if n_seldom := _n(driver.is_seldom_seen):
        yield Note("driver.seldom", n=n_seldom, n_seen=driver.n_seen, share=SELDOM)
    n_open = _n(driver.is_within_sd)
    # `no_claim` covers these cases
    is_said = are_all_open(result) and not doubt_of_estimator(result)
    if n_open and not is_said:
        yield Note(
            "driver.open",
            n=n_open,
            n_known=driver.n_known,
            is_least=_n(driver.has_sd) < driver.n_known,
            n_open_unseen=_n(driver.is_within_sd & driver.is_unseen),
            n_unseen=driver.n_unseen,
            threshold=result.params.driver_threshold,
        )
    if (parts := count_in_time(result)).n:
        yield Note("driver.in_time", n=parts.n, **parts._asdict())
        if n_late := _n(is_seen_too_late(result)):
            yield Note("driver.too_late", n=n_late)


def _estimated(result: Result) -> Iterator[Note]:
    """Yield notes on estimates outside the training range or for adapted eyes.

    They are worth a note only if they are many or decide encounters.
    """
    record, values = result.dataset.of("driver"), result.dataset.detectability
    is_known = ~(np.isnan(values.value) | result.dataset.truth.ignore)
    n_known, n = _n(is_known), _n(is_known & values.is_outside)
    driver = driver_in(result)
    n_deciding = _n(driver.is_outside)
    if n_deciding or n > SMALL_SHARE * n_known:
        outside = record.outside if record else ()
        names = [shortened(one_line(name), _SHOWN_NAME) for name in outside]
        yield Note(
            "driver.outside",
            n=n,
            n_known=n_known,
            n_deciding=n_deciding,
            n_encounters=driver.n_known,
            features=listed(names, most=_MOST_NAMED) or None,
        )
    if (record := estimates_in(result)) is None:
        return
    if record.n_light_unknown > SMALL_SHARE * record.n_estimates:
        yield Note("driver.light_unknown", share=record.n_light_unknown / record.n_estimates)
    if n_adapted := _n(driver.is_adapted):
        yield Note("driver.adapted", n=n_adapted, n_known=driver.n_known)


def no_claim(result: Result) -> tuple[Note, ...]:
    """Explain why nothing is claimed about whom the driver sees, or return no note."""
    why = doubt_of_seen(result) if driver_in(result).has_any else None
    return (Note("driver.no_claim", why=why),) if why else ()


def weighting(result: Result) -> tuple[Note, ...]:
    """Return a note on the weighting of misses by detectability, if it is on."""
    if result.params.driver_weighting == "off":
        return ()
    if not result.dataset.has_detectability:
        return (Note("driver.no_weighting"),)
    return (Note("driver.weighting", n_unknown=_n(is_unknown(result.dataset))),)


def weighting_notes(result: Result) -> tuple[Note, ...]:
    """Return notes on weighting misses, and why nothing is claimed about weighted measures."""
    return (*weighting(result), *no_claim_of_weighted(result))


def no_claim_of_weighted(result: Result) -> tuple[Note, ...]:
    """Explain why nothing is claimed about weighted measures, or return no note."""
    why = doubt_of_estimator(result) if is_weighted(result) else None
    return (Note("driver.no_claim_of_weighted", why=why),) if why else ()


def weighted_claims(result: Result, measures: Sequence[Measure]) -> Note | None:
    """Return a remark that claims about these measures are weighted by detectability, or None."""
    is_any = any(measure.depends_on("driver_weighting") for measure in measures)
    return Note("driver.weighted_claims") if is_any and is_weighted(result) else None


def limits(result: Result) -> tuple[Note, ...]:
    """Return notes on doubts about what the driver sees, then on the weighting of misses."""
    notes = no_claim(result)
    caution = origin_of(result).get("caution")
    if not notes and driver_in(result).has_any and caution:
        notes = (Note("driver.estimated", caution=caution),)
    return (*notes, *weighting_notes(result))


def seen_unaided(result: Result) -> Note:
    """Return a note on how many encounters the driver sees, and how many others X and Y detect."""
    driver = driver_in(result)
    of: dict[str, Any] = {"by": by(result), "n_seen": driver.n_seen, "n_known": driver.n_known}
    if not driver.n_unseen:
        is_open = doubt_of_seen(result) or driver.is_within_sd.any()
        is_redundant = not (is_open or is_seen_too_late(result).any())
        return Note("driver.seen_unaided", **of, is_redundant=is_redundant)
    x, y, both = (driver.counts[of] for of in (DriverRegion.X, DriverRegion.Y, DriverRegion.X_Y))
    return Note(
        "driver.seen_unaided",
        **of,
        n_unseen=driver.n_unseen,
        useful_x=both + x,
        useful_y=both + y,
        x=x,
        y=y,
        neither=driver.counts[DriverRegion.NOBODY],
    )


def counts(result: Result) -> Note:
    """Return a note on how many encounters are seen, unseen, unknown and distant."""
    driver = driver_in(result)
    unknown, distant = (driver.counts[of] for of in (DriverRegion.UNKNOWN, DriverRegion.DISTANT))
    return Note(
        "driver.counts",
        n=driver.n_known + unknown + distant,
        n_seen=driver.n_seen,
        n_unseen=driver.n_unseen,
        n_unknown=unknown,
        n_distant=distant,
    )


def known(result: Result, *, of_urgent: bool = False) -> Note:
    """Return a note on how many encounters have known detectability, and where it comes from."""
    driver = driver_in(result)
    n, is_counted = result.venn.n_near, driver.is_known
    if of_urgent:
        n, is_counted = _n(time_left_in(result).is_urgent), is_judged_in_time(result)
    return Note(
        "driver.known",
        n_known=_n(is_counted),
        n=n,
        is_of_urgent=of_urgent,
        n_open=_n(driver.is_within_sd & is_counted),
        by=by(result),
    )


def by(result: Result) -> Note:
    """Return a note on where detectability comes from, for use in other notes."""
    return Note("driver.by", **origin_of(result))


def origin_of(result: Result) -> dict[str, Any]:
    """Return where detectability comes from, as values for the templates of notes.

    Returns
    -------
    origin (``truth``, ``estimates`` or ``both``). For estimates also n_estimated and n_stated
    (numbers of recordings with estimates and with values of the ground truth), and made_by and
    caution (None if unknown).
    """
    estimate = estimates_in(result)
    if estimate is None:
        return {"origin": "truth"}
    n_estimated, n_stated = count_origins(result)
    return {
        "origin": "both" if n_stated else "estimates",
        "n_estimated": n_estimated,
        "n_stated": n_stated,
        "made_by": estimate.made_by or None,
        "caution": estimate.caution or None,
    }


def source(result: Result) -> tuple[Note, ...]:
    """Return notes on where detectability comes from, and how much is known if not nearly all."""
    threshold = result.params.driver_threshold
    note = Note("driver.source", threshold=threshold, **origin_of(result))
    values = result.dataset.detectability.value
    n_known = _n(~(np.isnan(values) | result.dataset.truth.ignore))
    n_boxes = n_known + _n(is_unknown(result.dataset))
    is_small = n_known < (1 - SMALL_SHARE) * n_boxes
    n_unknown = driver_in(result).counts[DriverRegion.UNKNOWN]
    if not (is_small or n_unknown):
        return (note,)
    of_boxes = {"n_known": n_known, "n_boxes": n_boxes} if is_small else {}
    return (note, Note("driver.known_extent", n_unknown=n_unknown, **of_boxes))


def doubt_of_estimator(result: Result) -> Note | None:
    """Return why no estimate can be trusted, None if there is no estimate or no reason."""
    estimate = estimates_in(result)
    if estimate is not None and estimate.of_no_use:
        return Note("driver.useless")
    is_simulated = estimate is not None and estimate.simulated == "all"
    return Note("driver.simulated_subjects") if is_simulated else None


def doubt_of_seen(result: Result) -> Note | None:
    """Return why nothing is claimed about whom the driver sees, or None."""
    if why := doubt_of_estimator(result):
        return why
    driver, threshold = driver_in(result), result.params.driver_threshold
    n_known, is_unseen, n_outside = driver.n_known, driver.is_unseen, _n(driver.is_outside)
    if n_outside and n_outside >= MOST_OUTSIDE * n_known:
        return Note("driver.out_of_range", n=n_outside, n_known=n_known)
    if are_all_open(result):
        return Note("driver.all_open", n=n_known, is_of_unseen=False, threshold=threshold)
    if is_unseen.any() and bool(driver.is_within_sd[is_unseen].all()):
        return Note("driver.all_open", n=_n(is_unseen), is_of_unseen=True, threshold=threshold)
    return None


def doubt_of(result: Result, measure: Measure) -> str:
    """Return why no claim or comparison can rest on a measure, or an empty string."""
    why = None
    if DRIVER in measure.stages:
        why = doubt_of_seen(result)
    elif measure.depends_on("driver_weighting") and is_weighted(result):
        why = doubt_of_estimator(result)
    return phrase(why, result.objects) if why else ""


def estimates_in(result: Result) -> EstimateRecord | None:
    """Return the record of estimates, or None if all detectability is the ground truth's."""
    estimate: EstimateRecord | None = result.dataset.of("driver")
    n_estimated, n_stated = count_origins(result)
    return None if n_stated and not n_estimated else estimate


def count_origins(result: Result) -> tuple[int, int]:
    """Count recordings with estimated detectability, and those with values of the ground truth."""
    estimate = result.dataset.of("driver")
    if estimate is None:
        return 0, 0
    names = frozenset(result.dataset.recordings["name"])
    return len(names & estimate.estimated_in), len(names & estimate.stated_in)


def is_weighted(result: Result) -> bool:
    """Whether misses are weighted by detectability."""
    return result.params.driver_weighting != "off" and result.dataset.has_detectability


def are_all_open(result: Result) -> bool:
    """Whether every known detectability is within one standard deviation of the threshold."""
    driver = driver_in(result)
    n_known = driver.n_known
    return n_known > 0 and _n(driver.is_within_sd) == n_known


def simulated_change(
    course: pd.DataFrame,
    simulated: pd.DataFrame,
    *,
    threshold: float,
    change_s: float,
    caution: str = "",
) -> Note:
    """Return a note on when the driver would see the pedestrian if it became dark at `change_s`.

    The note also says when the driver sees the pedestrian without the change.

    Parameters
    ----------
    course
        Table of `nvcore.subjects.driver.comparison.encounters.detectability_course`.
    simulated
        The same rows after `nvcore.subjects.driver.running.estimate.simulate_change`.
    threshold
        Detectability (0..1) from which the driver is assumed to see the pedestrian.
    change_s
        Time in seconds from the recording's first frame, as in the course.
    caution
        Doubts about the estimates, such as simulated subjects
        (`nvcore.subjects.driver.inputs.record.EstimateRecord.caution`).
    """
    is_after = simulated["is_simulated"].to_numpy(bool)
    if not is_after.any():
        return Note("driver.simulated_after_all", change_s=change_s)
    time_s, is_up_to = course["time_s"].to_numpy(float), course["is_up_to_relevant"].to_numpy(bool)
    was, would = (table["detectability"].to_numpy(float) for table in (course, simulated))
    seen = np.flatnonzero(was[: np.argmax(is_after)] >= threshold)
    later_s = time_s[is_after] - change_s
    before, soon = (
        _first_seen(
            share[is_after],
            threshold,
            later_s,
            is_there=not is_after[0] or round(later_s[0], 6) <= 0,
            is_until_change=not is_after[-1],
        )
        for share in (was, would)
    )
    saw, would_see = (
        bool((share[is_up_to] >= threshold).any()) if np.isfinite(share[is_up_to]).any() else None
        for share in (was, would)
    )
    return Note(
        "driver.simulated",
        change_s=change_s,
        caution=caution or None,
        seen_before_s=time_s[seen[0]] if len(seen) and is_up_to[seen[0]] else None,
        soon=soon,
        before=before,
        is_again=len(seen) > 0,
        relevant_s=time_s[is_up_to][-1] if is_up_to.any() else None,
        saw=saw,
        would_see=would_see,
    )


def _first_seen(
    share: NDArray[np.float64],
    threshold: float,
    later_s: NDArray[np.float64],
    *,
    is_there: bool,
    is_until_change: bool,
) -> Note | None:
    """Return a note on the first frame in which the driver sees the pedestrian, or None if unknown.

    Parameters
    ----------
    later_s
        Times of the pedestrian's frames since the change, s.
    is_there
        Whether the pedestrian was there before the change. If not, frames count from the first one.
    is_until_change
        Whether these frames end at the next real change of light, not with the pedestrian.
    """
    is_known, sees = np.isfinite(share), share >= threshold  # comparisons with NaN are False
    if not is_known.any():
        return None
    if not sees.any():
        of = {"n_known": _n(is_known), "n": len(share)}
        return Note("driver.never_seen", **of, is_until_change=is_until_change)
    n = int(np.argmax(sees))
    is_certain = bool(is_known[:n].all())
    return Note(
        "driver.first_seen", n=n, later_s=later_s[n], is_there=is_there, is_certain=is_certain
    )


def _n(is_member: NDArray[np.bool_]) -> int:
    return int(np.count_nonzero(is_member))
