"""What the driver adds to the verdict, the terminal's report and the first page."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

from nvcore.comparison import Result
from nvcore.dataset import Dataset
from nvcore.driver.comparison.columns import driver_views
from nvcore.driver.comparison.doubts import is_stated, is_weighted
from nvcore.driver.comparison.facts import Estimated, WeightedClaims
from nvcore.driver.comparison.said import (
    basis_facts,
    driver_facts,
    no_claim,
    seen_by,
    weighting,
    weighting_facts,
)
from nvcore.driver.comparison.steps import driver_in
from nvcore.measures.entry import Measure
from nvcore.report.remarks import Remarks
from nvcore.report.verdict import PointOf
from nvcore.sentences import phrase, say
from nvcore.sentences.facts import Fact
from nvcore.wording import capitalised

POINTS: Final = (
    PointOf("Weighting", weighting_facts, after="Operating points", is_warning=True),
    PointOf("The driver", driver_facts, after="Time left"),
)


def lines(result: Result) -> list[str]:
    """Who sees the encounters, and on whose word, for the terminal."""
    if not driver_in(result).has_any:
        return []
    first, *others = basis_facts(result)
    texts = [phrase(first, result.objects), *(say(fact, result.objects) for fact in others)]
    return [phrase(seen_by(result), result.objects), f"the driver: {' '.join(texts)}"]


def _limits(result: Result) -> tuple[Fact, ...]:
    return (*(no_claim(result) or _estimated(result)), *weighting_facts(result))


def _estimated(result: Result) -> tuple[Fact, ...]:
    """Why what is said of the driver is to be doubted; none: nothing is known, or nothing said."""
    estimate = result.dataset.of("driver")
    if not driver_in(result).has_any or estimate is None or is_stated(result):
        return ()
    return (Estimated(estimate.caution),) if estimate.caution else ()


def _of_claims(result: Result, measures: Sequence[Measure]) -> WeightedClaims | None:
    """That claims are of measures weighted by what the driver does not see; None: none is."""
    is_any = any(measure.depends_on("driver_weighting") for measure in measures)
    return WeightedClaims() if is_any and is_weighted(result) else None


def _views(dataset: Dataset) -> list[str]:
    """What is known of the driver's view of each recording, in words; empty: nothing."""
    views = driver_views(dataset)
    words_of = {
        "pictures of visible light": views["has_visible"],
        "light meter": views["light_by"] == "meter",
        "gaze": views["has_gaze"],
    }
    return [
        capitalised(", ".join(text for text, is_there in words_of.items() if is_there[i]))
        for i in range(len(dataset.recordings))
    ]


REMARKS: Final = Remarks(weighting, _limits, _of_claims, ("Driver's view", _views))
