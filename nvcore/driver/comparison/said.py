"""What there is to say of the driver: whom he sees, who warns of the others, how far one knows."""

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
from nvcore.driver.comparison.facts import (
    Adapted,
    Alerts,
    Caution,
    Counts,
    DetectabilitySource,
    InTime,
    Known,
    KnownExtent,
    LightUnknown,
    NoClaim,
    NothingKnown,
    Open,
    Outside,
    Region,
    SeenBy,
    SeenTooLate,
    Seldom,
    Weighting,
    Word,
)
from nvcore.driver.comparison.in_time import count_in_time, is_judged_in_time, is_seen_too_late
from nvcore.driver.comparison.judging import SELDOM, count_unknown
from nvcore.driver.comparison.kinds import DriverRegion
from nvcore.driver.comparison.steps import driver_in
from nvcore.sentences.facts import Fact
from nvcore.time_left.steps import time_left_in
from nvcore.wording import one_line, shortened

SMALL_SHARE: Final = 0.05
"""Share of the estimates up to which their doubts are not said (ours)."""
_MOST_NAMED: Final = 3
_SHOWN_NAME: Final = 40


def driver_facts(result: Result) -> tuple[Fact, ...]:
    """Whom the driver sees and whom each system warns of; none: nothing is known of that."""
    return (*no_claim(result), *view_facts(result))


def view_facts(result: Result) -> tuple[Fact, ...]:
    """`driver_facts` without why nothing is claimed."""
    if not driver_in(result).has_any:
        return (NothingKnown(),) if result.dataset.has_detectability else ()
    return (
        alerts(result),
        *_seldom(result),
        *_open(result),
        *_in_time(result),
        *_origin(result),
    )


def basis_facts(result: Result) -> tuple[Fact, ...]:
    """What is in doubt or open, where detectability comes from, and how far it can be trusted."""
    return (*no_claim(result), *_open(result), *_origin(result))


def weighting_facts(result: Result) -> tuple[Fact, ...]:
    """That misses weigh by what the driver does not see, and in doubt by whose word; none: no."""
    why = doubt_of_estimator(result) if is_weighted(result) else None
    return (*weighting(result), *([NoClaim("weighted", why)] if why else []))


def no_claim(result: Result) -> tuple[NoClaim, ...]:
    """Why nothing is claimed of whom the driver sees, whatever the counts; none: no reason."""
    why = doubt_of_seen(result) if driver_in(result).has_any else None
    return (NoClaim("seen", why),) if why else ()


def weighting(result: Result) -> tuple[Weighting, ...]:
    """That misses weigh by what the driver does not see; none: they weigh in full."""
    if result.params.driver_weighting == "off":
        return ()
    if not result.dataset.has_detectability:
        return (Weighting("none"),)
    n = count_unknown(result.dataset)
    return (Weighting("many" if n > 1 else "one" if n else "all", n),)


def _origin(result: Result) -> tuple[Fact, ...]:
    return (*source(result), *_outside(result), *_adapted(result))


def alerts(result: Result) -> Alerts:
    """How many the driver sees, and how many of the others each system detects."""
    venn = driver_in(result).venn
    count, of = venn.counts, (word(result), venn.n_seen, venn.n_known)
    if not venn.n_unseen:
        is_open = doubt_of_seen(result) or driver_in(result).is_within_sd.any()
        is_plain = not (is_open or is_seen_too_late(result).any())
        return Alerts("redundant" if is_plain else "all", *of)
    return Alerts(
        "unseen",
        *of,
        n_unseen=venn.n_unseen,
        useful_x=count[DriverRegion.X_Y] + count[DriverRegion.X],
        useful_y=count[DriverRegion.X_Y] + count[DriverRegion.Y],
        x=count[DriverRegion.X],
        y=count[DriverRegion.Y],
        neither=count[DriverRegion.NOBODY],
    )


def _seldom(result: Result) -> tuple[Fact, ...]:
    """How many the driver sees for a few frames only; none: none."""
    driver = driver_in(result)
    n = int(np.count_nonzero(driver.is_seldom_seen))
    return (Seldom(n, driver.venn.n_seen, SELDOM),) if n else ()


def counts(result: Result) -> Counts:
    """Where each encounter is counted, those too that no sentence is about."""
    venn = driver_in(result).venn
    unknown, distant = (
        venn.counts[region] for region in (DriverRegion.UNKNOWN, DriverRegion.DISTANT)
    )
    n = venn.n_known + unknown + distant
    return Counts(n, venn.n_seen, venn.n_unseen, unknown, distant)


def known(result: Result, *, of_urgent: bool = False) -> Known:
    """Of how many encounters it is known whether the driver sees them, and on whose word."""
    driver = driver_in(result)
    n_known, n, is_open = driver.venn.n_known, result.venn.n_near, driver.is_within_sd
    if of_urgent:
        is_judged = is_judged_in_time(result)
        n_known, is_open = int(np.count_nonzero(is_judged)), is_open & is_judged
        n = int(np.count_nonzero(time_left_in(result).is_urgent))
    return Known(n_known, n, of_urgent, int(np.count_nonzero(is_open)), word(result))


def word(result: Result) -> Word:
    """On whose word it rests what the driver sees."""
    estimate = result.dataset.of("driver")
    n_estimated, n_stated = count_origins(result)
    if estimate is None or is_stated(result):
        return Word("truth")
    caution = Caution(estimate.caution) if estimate.caution else None
    return Word("both" if n_stated else "estimates", caution, n_estimated, n_stated)


def _in_time(result: Result) -> tuple[Fact, ...]:
    """Who is in time for the urgent encounters; none: it is known of none."""
    parts = count_in_time(result)
    if not parts.n:
        return ()
    n_late = int(np.count_nonzero(is_seen_too_late(result)))
    in_time = InTime(parts.n, parts.driver, parts.both, parts.x, parts.y, parts.nobody)
    return (in_time, SeenTooLate(n_late)) if n_late else (in_time,)


def source(result: Result) -> tuple[Fact, ...]:
    """Where detectability comes from, and of how much it is known."""
    estimate, threshold = result.dataset.of("driver"), result.params.driver_threshold
    n_estimated, n_stated = count_origins(result)
    if estimate is None or is_stated(result):
        return (DetectabilitySource("truth", threshold), *_extent(result))
    made_by = tuple(filter(None, (estimate.made_by or "estimated", estimate.caution)))
    kind = DetectabilitySource(
        "both" if n_stated else "estimates", threshold, made_by, n_estimated, n_stated
    )
    return (kind, *_extent(result))


def _extent(result: Result) -> tuple[Fact, ...]:
    """Of how much it is known, where that is not nearly all."""
    values = result.dataset.detectability.value
    n_known = int(np.count_nonzero(~(np.isnan(values) | result.dataset.truth.ignore)))
    n_boxes = n_known + count_unknown(result.dataset)
    is_small = n_known < (1 - SMALL_SHARE) * n_boxes
    n_unknown = driver_in(result).venn.counts[DriverRegion.UNKNOWN]
    return (KnownExtent(n_known, n_boxes, is_small, n_unknown),) if is_small or n_unknown else ()


def _outside(result: Result) -> tuple[Fact, ...]:
    """How many values were estimated outside the training's range, and how many of them decide."""
    record, values = result.dataset.of("driver"), result.dataset.detectability
    is_known = ~(np.isnan(values.value) | result.dataset.truth.ignore)
    n_known, n = (int(np.count_nonzero(is_known & of)) for of in (True, values.is_outside))
    driver = driver_in(result)
    if not driver.n_outside and n <= SMALL_SHARE * n_known:
        return ()
    names = [shortened(one_line(name), _SHOWN_NAME) for name in (record.outside if record else ())]
    if (n_more := len(names) - _MOST_NAMED) > 1:  # in place of the last, "1 more" says less
        names = [*names[:_MOST_NAMED], f"{n_more} more"]
    return (Outside(n, n_known, driver.n_outside, driver.venn.n_known, tuple(names)),)


def _open(result: Result) -> tuple[Fact, ...]:
    """How many encounters may as well be on the other side of the threshold."""
    driver = driver_in(result)
    n, n_with_sd, n_open_unseen = (
        int(np.count_nonzero(which))
        for which in (driver.is_within_sd, driver.has_sd, driver.is_within_sd & driver.is_unseen)
    )
    is_said = are_all_open(result) and not doubt_of_estimator(result)  # by `no_claim`
    if not n or is_said:
        return ()
    return (
        Open(
            n=n,
            n_known=driver.venn.n_known,
            is_least=n_with_sd < driver.venn.n_known,
            n_open_unseen=n_open_unseen,
            n_unseen=driver.venn.n_unseen,
            threshold=result.params.driver_threshold,
        ),
    )


def _adapted(result: Result) -> tuple[Fact, ...]:
    """How many estimates take the eyes for adapted, where these are not few or decide."""
    record = result.dataset.of("driver")
    if record is None or is_stated(result):
        return ()
    facts: list[Fact] = []
    if record.n_light_unknown > SMALL_SHARE * record.n_estimates:
        facts.append(LightUnknown(record.n_light_unknown / record.n_estimates))
    if n_adapted := int(np.count_nonzero(driver_in(result).is_adapted)):
        facts.append(Adapted(n_adapted, driver_in(result).venn.n_known))
    return tuple(facts)


def seen_by(result: Result) -> SeenBy:
    """Encounters of each region."""
    n_of = driver_in(result).venn.counts
    return SeenBy(
        tuple(
            Region(who, n_of[region])
            for region, who in REGION_NAMES.items()
            if n_of[region] or region is not DriverRegion.UNKNOWN
        )
    )
