"""The driver in words: whom he sees by himself, who warns him, and how far the data say so."""

from __future__ import annotations

from typing import Final

import numpy as np

from nvcore.comparison import Result
from nvcore.measures.of_driver import is_driver_in_time, is_in_time_alone, is_judged_in_time
from nvcore.metrics.driver import count_unknown
from nvcore.schema import DriverRegion
from nvcore.tables.encounters.driver import REGION_NAMES
from nvcore.wording import capitalised, count_text, listed, one_line, percent, shortened

SMALL_SHARE: Final = 0.05
"""Share of the estimates up to which their doubts are not said (ours)."""
_MOST_NAMED: Final = 3
_SHOWN_NAME: Final = 40


def describe_driver(result: Result) -> tuple[str, ...]:
    """Whom the driver sees and whom each system warns him of; empty: nothing is known of him."""
    if not result.driver.has_any:
        return ()
    sentences = (_alerts(result), _in_time(result), describe_source(result), weighting(result))
    return tuple(filter(None, sentences))


def _alerts(result: Result) -> str:
    venn = result.driver.venn
    count, n_unseen = venn.counts, venn.n_unseen
    by = capitalised(_by(result))
    of = f"{by}, the driver sees {venn.n_seen} of {count_text(venn.n_known, 'encounter')}"
    if not n_unseen:
        return f"{of} by himself: every alert is redundant."
    useful_x = count[DriverRegion.X_Y] + count[DriverRegion.X]
    useful_y = count[DriverRegion.X_Y] + count[DriverRegion.Y]
    return (
        f"{of} by himself; of the {n_unseen} that he does not see, X detects {useful_x} and Y "
        f"{useful_y} (X alone {count[DriverRegion.X]}, Y alone {count[DriverRegion.Y]}, neither "
        f"{count[DriverRegion.NOBODY]})."
    )


def describe_known(result: Result) -> str:
    """Of how many encounters it is known whether the driver sees them, and on whose word."""
    known, near = result.driver.venn.n_known, count_text(result.venn.n_near, "encounter")
    return f"whether the driver sees them is known of {known:,} of {near}, {_by(result)}"


def _by(result: Result) -> str:
    """On whose word it rests what the driver sees."""
    estimate = result.dataset.estimate
    n_estimated, n_stated = _origins(result)
    if estimate is None or (n_stated and not n_estimated):
        return "by the ground truth"
    caution = f" ({estimate.caution})" if estimate.caution else ""
    if not n_stated:
        return f"by the estimates{caution}"
    among = count_text(n_estimated, "recording")
    return f"by estimates in {among}{caution} and the ground truth in {n_stated}"


def _origins(result: Result) -> tuple[int, int]:
    """In how many recordings values are estimates, and in how many the ground truth's own."""
    estimate = result.dataset.estimate
    if estimate is None:
        return 0, 0
    names = frozenset(result.dataset.recordings["name"])
    return len(names & estimate.estimated_in), len(names & estimate.stated_in)


def _in_time(result: Result) -> str:
    """Of the urgent encounters, who alone was in time; empty: it is known of none."""
    n = int(np.count_nonzero(is_judged_in_time(result)))
    if not n:
        return ""
    n_driver = int(np.count_nonzero(is_driver_in_time(result)))
    x, y = (int(np.count_nonzero(is_in_time_alone(result, system))) for _, system in result.sides)
    return (
        f"Of the {count_text(n, 'urgent one')} among them he is in time by himself in {n_driver}; "
        f"neither he nor Y but X is in {x}, neither he nor X but Y in {y}."
    )


def describe_source(result: Result) -> str:
    """Where detectability comes from, and how far it can be trusted."""
    estimate, venn = result.dataset.estimate, result.driver.venn
    threshold = f"he is taken to see from {result.params.driver_threshold:g} on"
    n_estimated, n_stated = _origins(result)
    if estimate is None or (n_stated and not n_estimated):
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
    parts = _doubts(result)
    if n_unknown := venn.counts[DriverRegion.UNKNOWN]:
        parts.append(f"{count_text(n_unknown, 'encounter')} unknown, not counted here")
    return f"{text}{''.join(f'; {part}' for part in parts)}."


def _doubts(result: Result) -> list[str]:
    """Which share of the boxes has no value, or one that says little, where it is not small."""
    record, values = result.dataset.estimate, result.dataset.detectability
    is_known = ~(np.isnan(values.value) | result.dataset.truth.ignore)
    n_known = int(np.count_nonzero(is_known))
    n_outside = int(np.count_nonzero(values.is_outside & is_known))
    parts = []
    n_boxes = n_known + count_unknown(result.dataset)
    if n_known < (1 - SMALL_SHARE) * n_boxes:
        parts.append(f"known of {n_known:,} of {n_boxes:,} pedestrian boxes")
    if n_outside > SMALL_SHARE * n_known:
        outside = record.outside if record else {}
        names = [shortened(one_line(name), _SHOWN_NAME) for name in outside]
        which = f" ({listed(names, most=_MOST_NAMED)})" if names else ""
        share = percent(n_outside / n_known)
        parts.append(
            f"{share} of the values are estimated outside the range of the training{which}"
        )
    if result.driver.n_outside or n_outside > SMALL_SHARE * n_known:
        parts.append(_encounters_outside(result))
    if record and record.n_without_light > SMALL_SHARE * record.n_estimates > 0:
        share = percent(record.n_without_light / record.n_estimates)
        parts.append(
            f"in {share} of the estimates nothing is known of the light: as for adapted eyes"
        )
    return parts


def _encounters_outside(result: Result) -> str:
    """In how many encounters the value that decides was estimated outside the training's range."""
    among = count_text(result.driver.venn.n_known, "encounter")
    return (
        "the largest value of an encounter, which decides whether he sees it, is outside the "
        f"range of the training in {result.driver.n_outside or 'none'} of {among}"
    )


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
    boxes = count_text(n, "pedestrian box", "pedestrian boxes")
    return f"{text}; {boxes} {verb} in full." if n else f"{text}."


def regions_text(result: Result) -> str:
    """Encounters of each region, in one line: "driver, X and Y 3, driver and X 1, ..."."""
    counts = result.driver.venn.counts
    return ", ".join(
        f"{who} {counts[region]:,}"
        for region, who in REGION_NAMES.items()
        if counts[region] or region is not DriverRegion.UNKNOWN
    )
