"""The driver in words: whom the driver sees, who warns of the others, how far the data say so."""

from __future__ import annotations

from typing import Final

import numpy as np

from nvcore.comparison import Result
from nvcore.driver.comparison.doubts import (
    are_all_open,
    count_origins,
    doubt_of_estimator,
    doubt_of_seen,
    is_stated,
    is_weighted,
)
from nvcore.driver.comparison.encounters import REGION_NAMES
from nvcore.driver.comparison.in_time import count_in_time, is_judged_in_time, is_seen_too_late
from nvcore.driver.comparison.judging import SELDOM, count_unknown
from nvcore.driver.comparison.kinds import DriverRegion
from nvcore.driver.comparison.steps import driver_in
from nvcore.time_left.steps import time_left_in
from nvcore.wording import capitalised, count_text, listed, one_line, percent, shortened

SMALL_SHARE: Final = 0.05
"""Share of the estimates up to which their doubts are not said (ours)."""
NOTHING_KNOWN: Final = (
    "Detectability is known in some frames, but for no encounter in a frame up to the first that "
    "counts: {what} the driver sees is not known."
)
_MOST_NAMED: Final = 3
_SHOWN_NAME: Final = 40


def describe_driver(result: Result) -> tuple[str, ...]:
    """Whom the driver sees and whom each system warns of; empty: nothing is known of that."""
    return tuple(filter(None, (describe_doubt(result), *describe_view(result))))


def describe_weighting(result: Result) -> tuple[str, ...]:
    """That misses weigh by what the driver does not see, and in doubt by whose word; empty: no."""
    text = weighting(result)
    why = doubt_of_estimator(result) if is_weighted(result) else ""
    doubt = f"Nothing is claimed of what is weighted: {why}." if why else ""
    return tuple(filter(None, (text, doubt)))


def describe_doubt(result: Result) -> str:
    """Why nothing is claimed of whom the driver sees, whatever the counts; empty: no reason."""
    why = doubt_of_seen(result) if driver_in(result).has_any else ""
    if not why:
        return ""
    return result.objects.say("Nothing is claimed of {what} the driver sees: {why}.", why=why)


def describe_view(result: Result) -> tuple[str, ...]:
    """`describe_driver` without its doubt."""
    if not driver_in(result).has_any:
        known = result.dataset.has_detectability
        return (result.objects.say(NOTHING_KNOWN),) if known else ()
    sentences = (
        _alerts(result),
        _seldom(result),
        _undecided(result),
        _in_time(result),
        *_basis(result),
    )
    return tuple(filter(None, sentences))


def describe_basis(result: Result) -> str:
    """What is in doubt or open, where detectability comes from, and how far it can be trusted."""
    parts = describe_doubt(result), _undecided(result), *_basis(result)
    return " ".join(filter(None, parts))


def _basis(result: Result) -> tuple[str, str, str]:
    return describe_source(result), _outside(result), _adapted(result)


def _alerts(result: Result) -> str:
    venn = driver_in(result).venn
    count, n_unseen = venn.counts, venn.n_unseen
    by = capitalised(_by(result))
    of = f"{by}, the driver sees {venn.n_seen} of {count_text(venn.n_known, 'encounter')}"
    if not n_unseen:
        is_open = doubt_of_seen(result) or driver_in(result).is_within_sd.any()
        is_plain = not (is_open or is_seen_too_late(result).any())
        redundant = ": every alert about these is redundant" if is_plain else ""
        return f"{of} unaided{redundant}."
    useful_x = count[DriverRegion.X_Y] + count[DriverRegion.X]
    useful_y = count[DriverRegion.X_Y] + count[DriverRegion.Y]
    return (
        f"{of} unaided; of the {n_unseen} not seen, X detects {useful_x} and Y "
        f"{useful_y} (X alone {count[DriverRegion.X]}, Y alone {count[DriverRegion.Y]}, neither "
        f"{count[DriverRegion.NOBODY]})."
    )


def _seldom(result: Result) -> str:
    """How many the driver sees for a few frames only; empty: none."""
    n = int(np.count_nonzero(driver_in(result).is_seldom_seen))
    if not n:
        return ""
    n_seen = driver_in(result).venn.n_seen
    return (
        f"One frame is enough to count as seen: {n:,} of the {n_seen:,} reach "
        f"the threshold in fewer than {percent(SELDOM)} of the frames up to the first that counts."
    )


def describe_counts(result: Result) -> str:
    """Where each encounter is counted, those too that no sentence is about."""
    venn = driver_in(result).venn
    n_unknown, n_distant = (
        venn.counts[region] for region in (DriverRegion.UNKNOWN, DriverRegion.DISTANT)
    )
    n = venn.n_known + n_unknown + n_distant
    parts = [f"{venn.n_seen:,} seen by the driver, {venn.n_unseen:,} not seen"]
    if n_unknown:
        parts.append(f"{n_unknown:,} unknown")
    if n_distant:
        parts.append(f"{n_distant:,} distant (never near enough to count)")
    return f"{count_text(n, 'encounter')} in all: {', '.join(parts)}."


def describe_known(result: Result, *, of_urgent: bool = False) -> str:
    """Of how many encounters it is known whether the driver sees them, and on whose word."""
    known, near = driver_in(result).venn.n_known, count_text(result.venn.n_near, "encounter")
    is_open = driver_in(result).is_within_sd
    if of_urgent:
        is_judged = is_judged_in_time(result)
        known, is_open = int(np.count_nonzero(is_judged)), is_open & is_judged
        near = count_text(int(np.count_nonzero(time_left_in(result).is_urgent)), "urgent encounter")
    n_open = int(np.count_nonzero(is_open))
    return f"whether the driver sees them is known of {known:,} of {near}, {_by(result)}" + (
        f"; open in {n_open:,} of these, within one standard deviation" if n_open else ""
    )


def _by(result: Result) -> str:
    """On whose word it rests what the driver sees."""
    estimate = result.dataset.of("driver")
    n_estimated, n_stated = count_origins(result)
    if estimate is None or is_stated(result):
        return "by the ground truth"
    caution = f" ({estimate.caution})" if estimate.caution else ""
    if not n_stated:
        return f"by the estimates{caution}"
    among = count_text(n_estimated, "recording")
    return f"by estimates in {among}{caution} and the ground truth in {n_stated}"


def _in_time(result: Result) -> str:
    """Who is in time for the urgent encounters; empty: it is known of none."""
    parts = count_in_time(result)
    if not parts.n:
        return ""
    n_late = int(np.count_nonzero(is_seen_too_late(result)))
    late = f" {n_late:,} that the driver sees are seen too late to stop." if n_late else ""
    return (
        f"Of {count_text(parts.n, 'urgent encounter')} of which it is known, the driver is in time "
        f"unaided in {parts.driver:,}; of the others, both systems are in {parts.both:,}, X "
        f"alone in {parts.x:,}, Y alone in {parts.y:,}, none of them in {parts.nobody:,}.{late}"
    )


def describe_source(result: Result) -> str:
    """Where detectability comes from, and of how much it is known."""
    estimate = result.dataset.of("driver")
    share = percent(result.params.driver_threshold)
    threshold = (
        f"seen means that at least {share} of drivers would see the {result.objects.singular}"
    )
    n_estimated, n_stated = count_origins(result)
    if estimate is None or is_stated(result):
        text = f"Detectability is as the ground truth states it; {threshold}"
    else:
        by = estimate.made_by or "estimated"
        words = ", ".join(filter(None, (by, estimate.caution)))
        if n_stated:
            words = (
                f"{words}, in {count_text(n_estimated, 'recording')}, and as the ground truth "
                f"states it in {n_stated}"
            )
        text = f"Detectability is {words}; {threshold}"
    return " ".join(filter(None, (f"{text}.", _known(result))))


def _known(result: Result) -> str:
    """Of how much it is known, where that is not nearly all."""
    values = result.dataset.detectability.value
    n_known = int(np.count_nonzero(~(np.isnan(values) | result.dataset.truth.ignore)))
    n_boxes = n_known + count_unknown(result.dataset)
    parts = []
    if n_known < (1 - SMALL_SHARE) * n_boxes:
        parts.append(f"it is known of {n_known:,} of {n_boxes:,} {result.objects.singular} boxes")
    if n_unknown := driver_in(result).venn.counts[DriverRegion.UNKNOWN]:
        are = "is" if n_unknown == 1 else "are"
        encounters = count_text(n_unknown, "encounter")
        parts.append(f"{encounters} of which it is unknown {are} not counted here")
    return f"{capitalised('; '.join(parts))}." if parts else ""


def _outside(result: Result) -> str:
    """How many values were estimated outside the training's range, and how many of them decide."""
    record, values = result.dataset.of("driver"), result.dataset.detectability
    is_known = ~(np.isnan(values.value) | result.dataset.truth.ignore)
    n_known, n = (int(np.count_nonzero(is_known & of)) for of in (True, values.is_outside))
    n_encounters = driver_in(result).n_outside
    if not n_encounters and n <= SMALL_SHARE * n_known:
        return ""
    names = [shortened(one_line(name), _SHOWN_NAME) for name in (record.outside if record else ())]
    which = f" (in that run by {listed(names, most=_MOST_NAMED)})" if names else ""
    return (
        f"Outside the range of the training{which} are {n:,} of {n_known:,} values; such values "
        f"decide {n_encounters or 'none'} of "
        f"{count_text(driver_in(result).venn.n_known, 'encounter')}."
    )


def _undecided(result: Result) -> str:
    """How many encounters may as well be on the other side of the threshold."""
    driver = driver_in(result)
    n, n_with_sd, n_unseen = (
        int(np.count_nonzero(which))
        for which in (driver.is_within_sd, driver.has_sd, driver.is_within_sd & driver.is_unseen)
    )
    is_said = are_all_open(result) and not doubt_of_estimator(result)  # by `describe_doubt`
    if not n or is_said:
        return ""
    unseen = (
        f", {n_unseen:,} of the {driver.venn.n_unseen:,} not seen among them" if n_unseen else ""
    )
    known = count_text(driver.venn.n_known, "encounter")
    at_least = "at least " if n_with_sd < driver.venn.n_known else ""  # of others it is not known
    return (
        f"Whether the driver sees the {result.objects.singular} is open in {at_least}{n:,} of "
        f"{known}{unseen}: the value that decides is within one standard deviation of "
        f"{result.params.driver_threshold:g}."
    )


def _adapted(result: Result) -> str:
    """How many estimates take the eyes for adapted, where these are not few or decide."""
    record = result.dataset.of("driver")
    if record is None or is_stated(result):
        return ""
    n, n_unknown = record.n_estimates, record.n_light_unknown
    sentences = []
    if n_unknown > SMALL_SHARE * n:
        sentences.append(
            f"In {percent(n_unknown / n)} of all estimates of that run it is not known when the "
            "light last changed: the eyes are taken for adapted."
        )
    if n_adapted := int(np.count_nonzero(driver_in(result).is_adapted)):
        sentences.append(
            f"Estimates for adapted eyes, as no change from bright to dark is known before, decide "
            f"{n_adapted:,} of "
            f"{count_text(driver_in(result).venn.n_known, 'encounter')}."
        )
    return " ".join(sentences)


def weighting(result: Result) -> str:
    """That misses weigh by what the driver does not see; empty: they weigh in full."""
    if result.params.driver_weighting == "off":
        return ""
    if not result.dataset.has_detectability:
        return "driver_weighting has no effect: no detectability is known."
    text = (
        "Similarity, saliency and severity are weighted by (1 - detectability): this weighting is "
        "ours, not the papers'"
    )
    n = count_unknown(result.dataset)
    verb = "has none and weighs" if n == 1 else "have none and weigh"
    boxes = count_text(n, f"{result.objects.singular} box", f"{result.objects.singular} boxes")
    more = "a miss of these weighs more than the same miss where a value is known"
    return f"{text}; {boxes} {verb} in full: {more}." if n else f"{text}."


def regions_text(result: Result) -> str:
    """Encounters of each region, in one line: "driver, X and Y 3, driver and X 1, ..."."""
    counts = driver_in(result).venn.counts
    return ", ".join(
        f"{who} {counts[region]:,}"
        for region, who in REGION_NAMES.items()
        if counts[region] or region is not DriverRegion.UNKNOWN
    )
